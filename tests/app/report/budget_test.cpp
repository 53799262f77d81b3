// SPDX-License-Identifier: MIT
// The forms of a budget, from small hand-made ones; tests/cli runs the program.
#include "gyrobudget/app/report/budget.h"

#include "gyrobudget/app/report/budget_words.h"
#include "gyrobudget/app/report/page_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <sstream>
#include <string>

#include "../../json.h"
#include "published_schemas.h"

namespace gyrobudget::report {
namespace {

using Json = nlohmann::ordered_json;
using navigation::CoreMatrix;

CoreMatrix diagonal(double position, double velocity, double attitude) {
  CoreMatrix P = CoreMatrix::Zero();
  P.diagonal().head<3>().setConstant(position * position);
  P.diagonal().segment<3>(3).setConstant(velocity * velocity);
  P.diagonal().tail<3>().setConstant(attitude * attitude);
  return P;
}

// Two sources, 3 m and 4 m each way, at 0 s and 10 s; everything asked for.
BudgetResult full() {
  BudgetResult r{.scene = "a.yaml", .name = "a </script> scene", .sensor = "s.yaml", .command = "gyrobudget budget"};
  r.study.at = 10;
  r.study.at_index = 1;
  r.study.budget.times = {0, 10};
  r.study.budget.steps = 12345;
  const CoreMatrix zero = CoreMatrix::Zero(), three = diagonal(3, 0.3, 0.03), four = diagonal(4, 0.4, 0.04);
  r.study.budget.lines = {{"gyro.arw", {zero, three}}, {"accelerometer.bias_instability", {zero, four}}};
  r.study.budget.total = {zero, three + four};
  r.study.budget.claimed = {zero, diagonal(4.5, 0.5, 0.05)};
  r.study.aided = true;
  r.study.pad = 600;
  r.study.tolerance = 0.001;
  r.study.left_out = {{"initial.position", 0.01, 1e-6}, {"gyro.rrw", 0, 0}};
  r.study.not_modelled = {{"gyro.range", "no state holds it"}};
  r.notes = {"a note"};
  r.study.exact = std::vector<CoreMatrix>{three, four};
  r.study.monte_carlo = budget::Study::Flown{.runs = 100,
                                             .seed = 7,
                                             .covariance = diagonal(5, 0.5, 0.05),
                                             .nees = {.mean = 9.1, .dof = 9, .left_out = {}},
                                             .points = {{1, 2, 3}, {-1, 0, 2}}};
  r.limit = "rss < 10 m";
  r.study.limit = budget::Study::Limit{.component = budget::Component::rss,
                                       .limit = 10,
                                       .found = 5 * std::sqrt(3),
                                       .factors = {std::numeric_limits<double>::infinity(), 1.5}};
  return r;
}

// No source has an effect: nothing to divide by.
BudgetResult empty() {
  BudgetResult r = full();
  for (auto& line : r.study.budget.lines) line.covariance.assign(2, CoreMatrix::Zero());
  r.study.budget.total.assign(2, CoreMatrix::Zero());
  r.study.exact = std::vector<CoreMatrix>(2, CoreMatrix::Zero());
  r.study.monte_carlo->nees = {.mean = std::numeric_limits<double>::quiet_NaN(), .dof = 0, .left_out = {}};
  return r;
}

}  // namespace

TEST(BudgetReport, NotesSayWhatTheStudyFound) {
  BudgetResult r = full();
  EXPECT_EQ(budget_notes(r), r.notes);
  r.sensor.clear();
  budget::Study& s = r.study;
  s.no_heading = "no heading";
  s.out_of_range = {{.carrier = navigation::Carrier::accelerometer, .axis = 2, .from = 3, .peak = 40, .range = 30}};
  s.large_attitude = {.axis = 1, .sigma = 0.2, .time = 9};
  s.runs = {.asked = 20, .flown = 11, .unaligned = 2, .fixes = {.given = 100, .refused = 1}};
  s.stopped = true;
  const auto notes = budget_notes(r);
  // In the order of the program, what moves first.
  const std::vector<std::string> parts{"a note",
                                       "no heading",
                                       "accelerometer z is cut off from 3 s on",
                                       "the IMU is ideal",
                                       "the attitude about north has a sigma of 11.5 deg at 9 s",
                                       "2 runs of Monte Carlo found no heading",
                                       "Monte Carlo was interrupted: 11 of 20 runs",
                                       "refused 1 % of their fixes"};
  ASSERT_EQ(notes.size(), parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_NE(notes[i].find(parts[i]), std::string::npos) << notes[i];
  s.stopped_at = 1;
  EXPECT_NE(budget_notes(r).back().find("interrupted at accelerometer.bias_instability"), std::string::npos);
  s.runs.fixes.refused = 0;
  EXPECT_EQ(budget_notes(r).size(), parts.size() - 1);
}

TEST(BudgetReport, JsonHasTheNumbersThatWentIn) {
  const Json j = tests::parsed<Json>(budget_json({full()}));
  tests::expect_schema(j);
  tests::expect_schema(tests::parsed<Json>(budget_json({empty()})));
  EXPECT_EQ(j["schema"], "gyrobudget.budget/1");
  EXPECT_EQ(j["at_s"], 10);
  EXPECT_NEAR(j["total"]["position_m"]["rss"].get<double>(), 5 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(j["total"]["velocity_m_s"]["rss"].get<double>(), 0.5 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(j["total"]["attitude_deg"]["total"].get<double>(), 0.05 * std::sqrt(3) * 180 / M_PI, 1e-12);
  EXPECT_NEAR(j["claimed"]["position_m"]["up"].get<double>(), 4.5, 1e-12);
  ASSERT_EQ(j["sources"].size(), 2u);
  EXPECT_EQ(j["sources"][0]["name"], "gyro.arw");
  EXPECT_NEAR(j["sources"][0]["share"].get<double>(), 9.0 / 25, 1e-12);
  EXPECT_NEAR(j["sources"][1]["exact_position_rss_m"].get<double>(), 4 * std::sqrt(3), 1e-12);
  EXPECT_EQ(j["left_out"][0]["bound_position_m"], 0.01);
  EXPECT_EQ(j["left_out"][0]["why"], "1e-06 of the total's variance at most");
  EXPECT_EQ(j["left_out"][1]["why"], "has no effect in this scene");
  EXPECT_EQ(j["not_modelled"][0]["what"], "gyro.range");
  EXPECT_EQ(j["steps"], 12345);
  EXPECT_EQ(j["limit"]["met"], true);
  EXPECT_TRUE(j["limit"]["allowed_factor"]["gyro.arw"].is_null());  // any
  EXPECT_EQ(j["monte_carlo"]["seed"], 7);
  EXPECT_NEAR(j["monte_carlo"]["position_rss_ratio"].get<double>(), 1, 1e-12);
  EXPECT_LT(j["monte_carlo"]["ratio_low"].get<double>(), 1);
  EXPECT_GT(j["monte_carlo"]["nees_high"].get<double>(), 9);
  EXPECT_EQ(j["growth"]["sources"]["gyro.arw"].size(), 2u);
  EXPECT_EQ(j["notes"][0], "a note");

  BudgetResult bare = full();
  bare.study.exact.reset();
  bare.study.monte_carlo.reset();
  bare.study.limit.reset();
  bare.study.budget.claimed.clear();
  const Json nothing = tests::parsed<Json>(budget_json({bare}));
  tests::expect_schema(nothing);
  for (const auto* field : {"claimed", "limit", "monte_carlo"}) EXPECT_TRUE(nothing[field].is_null()) << field;
  EXPECT_TRUE(nothing["sources"][0]["exact_position_rss_m"].is_null());
  EXPECT_EQ(tests::parsed<Json>(budget_json({bare, bare}))["budgets"].size(), 2u);
}

TEST(BudgetReport, TheTextIsNarrowAndHasNoHoles) {
  for (const BudgetResult& r : {full(), empty()}) {
    const std::string text = budget_text({r, r});
    EXPECT_FALSE(std::regex_search(text, std::regex("\\bnan\\b|\\binf\\b"))) << text;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 130u) << line;
    EXPECT_NE(text.find("claimed by the filter"), std::string::npos);
    EXPECT_NE(text.find("initial.position"), std::string::npos);
    EXPECT_NE(text.find("Side by side"), std::string::npos);
  }
  EXPECT_NE(budget_text({full()}).find("any"), std::string::npos);
}

TEST(BudgetReport, ThePageIsWholeAndLoadsNothing) {
  for (const BudgetResult& r : {full(), empty()}) {
    std::string page = budget_page({r});
    EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0U);
    EXPECT_NE(page.find("</html>"), std::string::npos);
    EXPECT_EQ(page.find("{{"), std::string::npos) << "an unfilled slot";
    EXPECT_EQ(page.find("a </script> scene"), std::string::npos) << "not escaped";
    EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
    const auto chart = page.find(kChartJs);
    if (chart != std::string::npos) page.erase(chart, kChartJs.size());
    EXPECT_EQ(page.find("http://"), std::string::npos);
    EXPECT_EQ(page.find("https://"), std::string::npos);
    const std::string open = "<script type=\"application/json\" id=\"data\">";
    const auto from = page.find(open) + open.size();
    const Json data = tests::parsed<Json>(page.substr(from, page.find("</script>", from) - from));
    ASSERT_FALSE(data.is_discarded());
    EXPECT_EQ(data["budgets"][0]["cloud"].size(), 2u);
  }
}

}  // namespace gyrobudget::report
