// SPDX-License-Identifier: MIT
// Gauss-Markov processes, chosen terms and several records in words, JSON and pictures.
#include "gyrobudget/app/report/curves.h"
#include "gyrobudget/app/report/page_parts.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/report/words.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "../../json.h"
#include "fixtures.h"
#include "published_schemas.h"

namespace gyrobudget {
namespace {

using noise::Term;

constexpr double kDegPerHour = 4.84813681109536e-06;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

fit::Coefficient markov() {
  return {.term = Term::gauss_markov,
          .value = 2 * kDegPerHour,
          .lower = 1.5 * kDegPerHour,
          .upper = 2.6 * kDegPerHour,
          .upper_two_sided = 2.6 * kDegPerHour,
          .relative_std = 0.1,
          .boundary_test = 30,
          .shape = 300,
          .shape_lower = 200,
          .shape_upper = 500,
          .status = fit::Status::identified,
          .fitted = true};
}

// The MEMS with a Gauss-Markov process for its alternative.
report::LogResult chosen() {
  report::LogResult result = fixtures::mems();
  calibration::Chosen choice;
  choice.selection.terms = {Term::white, Term::flicker, Term::rate_random_walk};
  choice.selection.weighed = {{{Term::white}, Term::rate_random_walk, 812.5, 2.6, true},
                              {{Term::white}, Term::quantization, 0, 1.9, false}};
  choice.selection.alternative = fit::Alternative{{Term::white, Term::rate_random_walk, Term::gauss_markov}, 0.7};
  choice.alternative_fit = result.axes[0].fit;
  choice.alternative_fit->coefficients.push_back(markov());
  result.axes[0].chosen = choice;
  return result;
}

TEST(TermsReport, AGaussMarkovProcessStandsWithItsCorrelationTime) {
  report::LogResult result = fixtures::mems();
  result.axes[0].fit->coefficients.push_back(markov());
  const std::string text = report::datasheet(result);
  EXPECT_TRUE(has(text, "G  Gauss-Markov noise")) << text;
  EXPECT_TRUE(has(text, "correlation time")) << text;
  EXPECT_TRUE(has(text, "200 to 500")) << text;
  const auto json = tests::parsed<nlohmann::json>(report::calibration_json(result));
  tests::expect_schema(json);
  const auto& g = json["axes"][0]["parameters"]["gauss_markov"];
  EXPECT_NEAR(g["value"].get<double>(), 2, 1e-12);
  EXPECT_EQ(g["correlation_time_s"], 300);
  EXPECT_EQ(g["correlation_time_lower_s"], 200);
  EXPECT_EQ(g["correlation_time_upper_s"], 500);
  EXPECT_FALSE(json["axes"][0]["parameters"]["arw"].contains("correlation_time_s"));
  EXPECT_FALSE(json["axes"][0]["parameters"].contains("sinusoid")) << "what was not asked for is not listed";
}

TEST(TermsReport, ItsCurveIsTheExactOneAndItsMarkTheTopOfTheHump) {
  report::LogResult result = fixtures::mems();
  result.axes[0].fit->coefficients.push_back(markov());
  const auto curves = report::axis_curves(result.axes[0], result.rate_hz);
  const auto at = std::find_if(curves.terms.begin(), curves.terms.end(),
                               [](const auto& t) { return t.term == Term::gauss_markov; });
  ASSERT_NE(at, curves.terms.end());
  const auto mark = std::find_if(curves.marks.begin(), curves.marks.end(), [](const auto& m) { return m.name == "G"; });
  ASSERT_NE(mark, curves.marks.end());
  const double top = *std::max_element(at->deviation.begin(), at->deviation.end());
  // A dozen taus a decade: the nearest is within 10 % of the top's, where the hump has fallen by less than 0.2 %.
  EXPECT_NEAR(mark->deviation / top, 1, 2e-3);
  EXPECT_NEAR(mark->tau_s / 300, 1.8926, 1e-3);
}

TEST(TermsReport, WhatWasWeighedAndTheOtherModelAreListed) {
  const report::LogResult result = chosen();
  const std::string text = report::datasheet(result);
  for (const std::string part :
       {"Terms chosen by likelihood ratios: N, B and K.", "weighed:", "rate random walk (K) beside N: adds 812 to ln L",
        "not needed", "The record cannot tell N, B and K from N, K and G", "The other model, N, K and G:"})
    EXPECT_TRUE(has(text, part)) << part << text;
  tests::expect_schema(tests::parsed<nlohmann::json>(report::calibration_json(result)));
  const auto fit = tests::parsed<nlohmann::json>(report::calibration_json(result))["axes"][0]["fit"];
  EXPECT_EQ(fit["chosen"], nlohmann::json({"arw", "bias_instability", "rrw"}));
  EXPECT_EQ(fit["weighed"][0]["candidate"], "rrw");
  EXPECT_EQ(fit["alternative"]["parameters"]["gauss_markov"]["correlation_time_s"], 300);
  const auto page = tests::parsed<nlohmann::json>(report::page_data(result));
  EXPECT_EQ(page["axes"][0]["words"]["weighed"].size(), 2U);
  EXPECT_EQ(page["axes"][0]["other_rows"].back()["shape"]["label"], "correlation time");
  EXPECT_FALSE(has(report::datasheet(fixtures::mems()), "weighed"));
}

TEST(TermsReport, RecordsStandSideBySideUnderTheirCombinedValues) {
  report::RunsResult runs{
      .command = "gyrobudget calibrate a.csv b.csv", .runs = {fixtures::mems(), fixtures::mems()}, .combined = {}};
  runs.runs[0].source = "a.csv", runs.runs[1].source = "b\x1b.csv";
  fit::Combined n{
      .term = Term::white, .records = 2, .identified = 2, .value = 4.4e-5, .lower = 4.3e-5, .upper = 4.5e-5};
  n.p_value = 0.01;
  runs.combined = {{"gyro_x", noise::Signal::angular_rate, {n}, {"c.csv"}}};
  const std::string text = report::runs_datasheet(runs);
  for (const std::string part :
       {"2 records of one sensor type", "a.csv", "b .csv", "they DIFFER (p = 0.010)", "Not taken"})
    EXPECT_TRUE(has(text, part)) << part << text;
  const auto json = tests::parsed<nlohmann::json>(report::runs_json(runs));
  tests::expect_schema(json);
  EXPECT_EQ(json["runs"].size(), 2U);
  const auto& arw = json["combined"][0]["parameters"]["arw"];
  EXPECT_TRUE(arw["next_upper"].is_null()) << "two records tell nothing of a third";
  EXPECT_NEAR(arw["value"].get<double>() * 2.908882086657216e-04, 4.4e-5, 1e-12);
  const auto all = report::side_by_side(runs);
  EXPECT_EQ(all.axes.size(), 2U);
  EXPECT_EQ(all.samples, 2 * fixtures::mems().samples);
  EXPECT_TRUE(has(report::runs_page(runs), "\"combined\":[{\"name\":\"gyro_x\""));
}

}  // namespace
}  // namespace gyrobudget
