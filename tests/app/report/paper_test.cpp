// SPDX-License-Identifier: MIT
// The forms of the paper's rows, from a small hand-made study; tests/cli holds the real one's numbers.
#include "gyrobudget/app/report/paper.h"

#include "gyrobudget/app/report/layout.h"
#include "gyrobudget/app/report/page_parts.h"

#include <gtest/gtest.h>

#include <regex>
#include <sstream>
#include <string>

#include "../../json.h"
#include "fixtures.h"
#include "published_schemas.h"

namespace gyrobudget::report {
namespace {

using Json = nlohmann::ordered_json;

PaperFlight small_flight() {
  PaperFlight flight{
      .time_s = {0, 83}, .pitch = {1.5, 0.8}, .published_km = {0.20, 4.66, 5.92}, .words = {"They are no noise."}};
  for (const char* id : {"reference", "ideal", "ifog", "mems", "offset_ifog", "offset_mems"}) {
    PaperPath path{.id = id,
                   .name = id,
                   .downrange = {0, 12'000},
                   .crossrange = {0, 1},
                   .up = {0, 26'000},
                   .distance = {0, 200},
                   .from_ideal = {0, 15}};
    path.flown.fill({0, 0.01});
    path.measured.fill({0, 0.02});
    flight.paths.push_back(path);
  }
  PaperHypothesis lost{
      .id = "per_second", .what = "deg/h taken for deg/s", .takes_unit = "times the noise", .why = "It comes down."};
  lost.gyros = {PaperHypothesis::Gyro{.km = 1e-12, .flights = 1},
                {.km = 0.145, .theory_km = 0.184, .flights = 10, .takes = 25.3},
                {.flights = 10, .lost = 10}};
  PaperHypothesis alone{.id = "vacuum", .what = "no air", .why = "Nothing pushes back."};
  alone.gyros[0] = {.km = 0.29, .flights = 1};
  flight.hypotheses = {lost, alone};
  return flight;
}

Paper small_study() {
  Paper paper{.command = "gyrobudget paper </script>", .seed = 42, .rate_hz = 100, .duration_s = 36'000};
  paper.rows = {{.id = "table1.model1.arw",
                 .group = "model 1, IFOG",
                 .what = "ARW",
                 .unit = "deg/sqrt(h)",
                 .published = 5.4e-4,
                 .ours = 5.39e-4,
                 .theory = 5.4e-4,
                 .scatter = PaperRow::Scatter{5.37e-4, 5.43e-4},
                 .fitted = PaperRow::Fitted{5.401e-4, 5.397e-4, 5.405e-4, 5.4e-4, fit::Status::identified},
                 .why = "White noise reads as it is."},
                {.id = "table1.model1.bias_instability",
                 .group = "model 1, IFOG",
                 .what = "bias instability",
                 .unit = "deg/h",
                 .published = 9e-3,
                 .ours = 7.8e-3,
                 .theory = 8e-3,
                 .scatter = PaperRow::Scatter{7.6e-3, 8.5e-3},
                 .fitted = PaperRow::Fitted{0, 0, 2.39e-3, 1.7e-3, fit::Status::upper_bound},
                 .why = "It is the crossing."},
                {.id = "fig7.model1.minimum",
                 .group = "model 1, IFOG",
                 .what = "smallest deviation",
                 .unit = "deg/h",
                 .ours = 5.2e-3,
                 .theory = 5.31e-3,
                 .why = "It is the crossing."}};
  PaperRecord record{.id = "model1", .axis = fixtures::mems().axes.front(), .trace_step_s = 50};
  record.reading = *record.axis.fit;
  for (const auto& p : record.axis.points) record.exact.push_back(p.deviation);
  record.trace_low = {-1e-6, -2e-6};
  record.trace_high = {1e-6, 2e-6};
  paper.records.push_back(record);
  paper.drifts.push_back({.id = "mems",
                          .name = "MEMS",
                          .arw = 4.4e-5,
                          .time_s = {1800, 3600},
                          .std = {1e-3, 2e-3},
                          .runs = {{1e-3, -2e-3}},
                          .final = {-2e-3, 1e-3}});
  paper.flight = small_flight();
  return paper;
}

TEST(Paper, TableSetsOursBesideThePublishedWithItsReason) {
  const std::string text = paper_table(small_study());
  for (const char* part :
       {"seed 42", "Table I", "0.0005401 (0.0005397 to 0.0005405)", "below 0.00239", "It is the crossing. 95 % of",
        "readings: 0.00760 to 0.00850.", "its noise holds ARW 0.000540 deg/sqrt(h), bias instability 0.00170 deg/h",
        "Figure 7", "1 of the 2 published values"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
  }
  EXPECT_EQ(text.find("Table II"), std::string::npos) << "a heading without rows";
  std::istringstream lines(text);
  constexpr std::size_t kUnit = 15;  // of a table's last column
  for (std::string line; std::getline(lines, line);) EXPECT_LE(width(line), kLineWidth + kUnit) << line;
}

TEST(Paper, JsonHasTheKeysThatAreKnown) {
  const Json json = tests::parsed<Json>(paper_json(small_study()));
  tests::expect_schema(json);
  EXPECT_EQ(json["schema"], "gyrobudget.paper/1");
  EXPECT_EQ(json["seed"], 42);
  const Json& first = json["rows"][0];
  EXPECT_EQ(first["published"], 5.4e-4);
  EXPECT_EQ(first["ours"], 5.39e-4);
  EXPECT_EQ(first["fitted"], 5.401e-4);
  EXPECT_EQ(first["upper"], 5.405e-4);
  EXPECT_EQ(first["status"], "identified");
  EXPECT_EQ(json["rows"][1]["status"], "upper_bound");
  EXPECT_TRUE(json["rows"][2]["published"].is_null());
  EXPECT_FALSE(json["rows"][2].contains("fitted"));
  EXPECT_FALSE(json["rows"][2].contains("scatter_low"));
}

TEST(Paper, HypothesesStandBesideThePublishedDistances) {
  const std::string text = paper_table(small_study());
  for (const char* part :
       {"published   0.200   4.66  5.92", "per_second      0  0.145  lost", "25.3",
        "deg/h taken for deg/s. It comes down.", "no air. Nothing pushes back.", "They are no noise."})
    EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
  const Json json = tests::parsed<Json>(paper_json(small_study()));
  const Json& h = json["hypotheses"][0];
  EXPECT_EQ(h["published"]["mems"], 5.92);
  EXPECT_EQ(h["ours"]["ifog"], 0.145);
  EXPECT_EQ(h["theory"]["ifog"], 0.184);
  EXPECT_EQ(h["takes"]["ifog"], 25.3);
  EXPECT_TRUE(h["ours"]["mems"].is_null());
  EXPECT_EQ(h["lost"]["mems"], 10);
  EXPECT_EQ(json["hypotheses"][1]["flights"]["mems"], 0);
  EXPECT_EQ(json["words"].back(), "They are no noise.");
  Paper noise_alone = small_study();
  noise_alone.flight = {};
  EXPECT_EQ(paper_table(noise_alone).find("it takes"), std::string::npos);
  EXPECT_TRUE(tests::parsed<Json>(paper_json(noise_alone))["hypotheses"].empty());
}

TEST(Paper, PageHasThePathsInKilometresAndDegrees) {
  const Json flight = tests::parsed<Json>(paper_data(small_study()))["flight"];
  ASSERT_EQ(flight["paths"].size(), 6U);
  const Json& mems = flight["paths"][3];
  EXPECT_EQ(mems["id"], "mems");
  EXPECT_EQ(mems["up_km"][1], 26.0);
  EXPECT_EQ(mems["from_ideal_km"][1], 0.015);
  EXPECT_NEAR(mems["measured_deg"][2][1].get<double>(), 1.14592, 1e-5);
  EXPECT_NEAR(flight["pitch_deg"][1].get<double>(), 45.8366, 1e-4);
}

TEST(Paper, PageIsWholeAndItsDataCannotCloseTheScript) {
  const std::string page = paper_page(small_study());
  EXPECT_EQ(page.find("{{"), std::string::npos) << "an unfilled slot";
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  std::size_t scripts = 0;
  for (std::size_t at = 0; (at = page.find("</script>", at)) != std::string::npos; ++at) ++scripts;
  EXPECT_EQ(scripts, 3U);
  const Json data = tests::parsed<Json>(paper_data(small_study()));
  EXPECT_EQ(data["paper"]["command"], "gyrobudget paper </script>");
  EXPECT_EQ(data["axes"][0]["curves"]["exact"].size(), data["allan"]["axes"][0]["points"].size());
  EXPECT_EQ(data["axes"][0]["curves"]["marks"].size(), 3U);
  EXPECT_NEAR(data["traces"][0]["high"][1].get<double>(), 2e-6 / 4.84813681e-6, 1e-6);
}

TEST(Paper, EveryElementThatTheScriptsAskForExists) {
  const std::string script(kPaperJs), html = std::string(kPaperHtml) + std::string(kShellHtml);
  const std::regex asked(R"re(byId\("([a-z0-9-]+)"\))re");
  std::size_t found = 0;
  for (auto it = std::sregex_iterator(script.begin(), script.end(), asked); it != std::sregex_iterator(); ++it) {
    EXPECT_NE(html.find("id=\"" + (*it)[1].str() + "\""), std::string::npos) << (*it)[1];
    ++found;
  }
  EXPECT_GE(found, 10U);
  // Both pages have what plot.js asks for.
  const std::string shared(kPlotJs);
  for (const std::string_view body : {kPageHtml, kPaperHtml}) {
    const std::string whole = std::string(body) + std::string(kShellHtml);
    for (auto it = std::sregex_iterator(shared.begin(), shared.end(), asked); it != std::sregex_iterator(); ++it) {
      EXPECT_NE(whole.find("id=\"" + (*it)[1].str() + "\""), std::string::npos) << (*it)[1];
    }
  }
}

}  // namespace
}  // namespace gyrobudget::report
