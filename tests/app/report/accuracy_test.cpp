// SPDX-License-Identifier: MIT
// The forms of an accuracy study and of a sweep, from small hand-made ones; tests/cli runs the program.
#include "gyrobudget/app/report/accuracy.h"

#include "gyrobudget/app/report/page_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <string>

#include "../../json.h"
#include "published_schemas.h"

namespace gyrobudget::report {
namespace {

using Json = nlohmann::ordered_json;
using fit::Method;
using noise::Term;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

fit::MethodAccuracy method(fit::Method m, double p05) {
  fit::MethodAccuracy a;
  a.method = m;
  a.coefficients.push_back(
      {.term = Term::white,
       .truth = noise::parse_quantity("0.15 deg/sqrt(h)", noise::parse_unit("rad/sqrt(s)").dimension),
       .bias = -0.0004,
       .rmse = 0.0042,
       .bound = 0.004,
       .over_likelihood = 1.012,
       .coverage = 0.75,
       .coverage_by_status = 0.75,
       .coverage_identified = 0.75,
       .identified = 1});
  a.coefficients.push_back({.term = Term::flicker,
                            .truth = 0,
                            .bias = kNaN,
                            .rmse = kNaN,
                            .bound = kNaN,
                            .over_likelihood = kNaN,
                            .coverage = 1,
                            .coverage_by_status = 0.75,
                            .coverage_identified = 0,
                            .identified = 0.25});
  const double n = a.coefficients[0].truth;
  a.coefficients[0].values = {0.99 * n, n, 1.01 * n, 9 * n};
  a.coefficients[1].values = {0, 0, 0, 1e-6};
  a.p_values = {0.01, 0.2, 0.5, 1.0};
  if (std::isnan(p05)) a.p_values.assign(4, kNaN);
  a.false_terms = 0.25;
  a.p_below_5_percent = p05;
  a.p_below_1_percent = std::isnan(p05) ? kNaN : 0;
  a.seconds_per_fit = 0.002;
  return a;
}

AccuracyStudy study() {
  AccuracyStudy s{.sensor = "a </script> gyro", .command = "gyrobudget accuracy x.yaml", .asked = 10};
  s.accuracy.records = 4;
  s.accuracy.samples = 36'000;
  s.accuracy.seed = 42;
  s.accuracy.methods = {method(fit::Method::gls, 0.25), method(fit::Method::visual, kNaN)};
  s.checks = fit::check(fit::parse_requirements("arw.rmse<1.1*crlb, gls.p05<0.1, slope.bias<1"), s.accuracy);
  return s;
}

SweepStudy sweep() {
  using fit::Comparison;
  SweepStudy s{.sensor = "gyro", .command = "gyrobudget accuracy x.yaml --sweep", .rate_hz = 1, .seed = 42};
  const auto row = [](Comparison comparison, const fit::Way& way, double over) {
    fit::SweepRow r{.comparison = comparison, .way = way};
    r.samples = 36'000, r.records = 200;
    r.coefficients = {{Term::white, 0.004 * over, over, over, 0.95}};
    r.curve_seconds = 1e-3, r.fit_seconds = 2e-3, r.covariance_seconds = 5e-3;
    return r;
  };
  s.sweep.rows = {row(Comparison::method, {}, 1), row(Comparison::method, {.method = Method::whittle}, 0.99),
                  row(Comparison::taus_an_octave, {.taus_an_octave = 2}, 1.001),
                  row(Comparison::stride, {.overlap = 16}, 1.002), row(Comparison::stride, {.overlap = 1}, 1.5)};
  s.sweep.complete = true;
  return s;
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Accuracy, TableNamesEveryNumber) {
  const std::string text = accuracy_table(study());
  for (const char* part : {"Stopped after 4 of 10 records of 36 000 samples (10 h at 1 Hz), seed 42",
                           "0.150 deg/sqrt(h)", "-0.0400 %", "0.420 %", "1.050", "1.012", "75.0 ± 21.7 %",
                           "25.0 ± 21.7 %", "2.0 ms", "BROKEN", "held", "not measured", "How to read it"}) {
    EXPECT_TRUE(holds(text, part)) << part << '\n' << text;
  }
  EXPECT_TRUE(holds(text, "Every interval covers")) << "with 4 records, 75 % is no surprise";
}

TEST(Accuracy, NothingFinishedSaysSo) {
  AccuracyStudy none{.sensor = "gyro", .asked = 10};
  none.accuracy.samples = 36'000;
  EXPECT_TRUE(holds(accuracy_table(none), "No record was finished"));
  tests::expect_schema(tests::parsed<Json>(accuracy_json(none)));
  EXPECT_EQ(tests::parsed<Json>(accuracy_json(none))["methods"].size(), 0U);
  EXPECT_FALSE(accuracy_page(none).empty());
}

TEST(Accuracy, JsonHasEveryKeyAndNoNaN) {
  const Json json = tests::parsed<Json>(accuracy_json(study()));
  tests::expect_schema(json);
  EXPECT_EQ(json["schema"], "gyrobudget.accuracy/1");
  EXPECT_EQ(json["records"], 4);
  EXPECT_EQ(json["asked"], 10);
  EXPECT_FALSE(json["complete"].get<bool>());
  const Json& arw = json["methods"][0]["coefficients"]["arw"];
  EXPECT_EQ(arw["term"], "N");
  EXPECT_NEAR(arw["truth"].get<double>(), 0.15, 1e-12);
  EXPECT_NEAR(arw["over_bound"].get<double>(), 1.05, 1e-12);
  EXPECT_NEAR(arw["coverage_std"].get<double>(), std::sqrt(0.75 * 0.25 / 4), 1e-12);
  EXPECT_TRUE(json["methods"][0]["coefficients"]["bias_instability"]["rmse"].is_null());
  EXPECT_TRUE(json["methods"][1]["p05"].is_null());
  ASSERT_EQ(json["requirements"].size(), 3U) << "arw.rmse, gls.p05 and what was not measured";
}

TEST(Accuracy, PageDataCountEveryRecordOnce) {
  const Json data = tests::parsed<Json>(accuracy_data(study()));
  ASSERT_EQ(data["estimates"].size(), 1U) << "B's truth is 0: there is no ratio";
  for (const Json& series : data["estimates"][0]["series"]) {
    int sum = series["zero"].get<int>() + series["outside"].get<int>();
    for (const int n : series["counts"]) sum += n;
    EXPECT_EQ(sum, 4);
    EXPECT_EQ(series["outside"], 1);
  }
  ASSERT_EQ(data["p_values"].size(), 1U) << "the reading has no test";
  EXPECT_EQ(data["p_values"][0]["counts"].size(), 20U);
  EXPECT_EQ(data["p_values"][0]["counts"][0], 1);
  EXPECT_EQ(data["p_values"][0]["counts"][19], 1) << "p = 1 belongs to the last";
}

TEST(Accuracy, SweepSaysWhichDefaultsFollow) {
  const std::string text = sweep_table(sweep());
  for (const char* part : {"gls (default)", "0.400 %", "0.990", "5.0 ms", "What follows", "gls is the default method",
                           "One tau an octave is the default", "a stride of m/16 gives N 1.002"}) {
    EXPECT_TRUE(holds(text, part)) << part << '\n' << text;
  }
  const Json json = tests::parsed<Json>(sweep_json(sweep()));
  tests::expect_schema(json);
  EXPECT_EQ(json["schema"], "gyrobudget.accuracy_sweep/1");
  EXPECT_EQ(json["rows"].size(), 5U);
  EXPECT_TRUE(json["rows"][0]["default"].get<bool>());
  EXPECT_EQ(json["rows"][3]["coefficients"]["arw"]["over_default"], 1.002);
  EXPECT_EQ(json["rows"][2]["group"], "taus an octave");
  EXPECT_EQ(json["rows"][3]["setting"], "m/16");
  EXPECT_EQ(json["rows"][4]["group"], "stride");
  EXPECT_TRUE(holds(sweep_table(SweepStudy{.sensor = "gyro"}), "No record was finished"));
}

TEST(Accuracy, RowsOfASweepSayWhatTheyAre) {
  using fit::Comparison;
  const auto setting = [](Comparison comparison, const fit::Way& way, std::int64_t samples = 0) {
    return setting_of({.comparison = comparison, .way = way, .samples = samples});
  };
  EXPECT_EQ(setting(Comparison::method, {.method = Method::loglog}), "loglog");
  EXPECT_EQ(setting(Comparison::covariance, {}), "exact");
  EXPECT_EQ(setting(Comparison::covariance, {.method = Method::edf}), "its diagonal (edf)");
  EXPECT_EQ(setting(Comparison::covariance, {.method = Method::loglog}), "none (loglog)");
  EXPECT_EQ(setting(Comparison::stride, {}), "1 sample");
  EXPECT_EQ(setting(Comparison::record_length, {}, 10'000), "1e4 gls");
  EXPECT_EQ(setting(Comparison::record_length, {.overlap = 16}, 1'000'000), "1e6 gls, stride m/16");
  EXPECT_EQ(setting(Comparison::record_length, {.method = Method::whittle}, 100'000), "1e5 whittle");
}

TEST(Accuracy, PagesAreWholeAndHaveEveryElementThatTheirScriptsAskFor) {
  const std::pair<std::string, std::string> pages[] = {
      {accuracy_page(study()), std::string(kAccuracyJs) + std::string(kPlotJs)},
      {sweep_page(sweep()), std::string(kSweepJs) + std::string(kPlotJs)}};
  const std::regex asked(R"re((?:byId|figure)\("([a-z0-9-]+)")re");
  for (const auto& [page, script] : pages) {
    EXPECT_FALSE(holds(page.substr(0, page.find("<script")), "{{")) << "an unfilled slot";
    std::size_t scripts = 0;
    for (std::size_t at = 0; (at = page.find("</script>", at)) != std::string::npos; ++at) ++scripts;
    EXPECT_EQ(scripts, 3U);
    for (auto it = std::sregex_iterator(script.begin(), script.end(), asked); it != std::sregex_iterator(); ++it) {
      EXPECT_TRUE(holds(page, "id=\"" + (*it)[1].str() + "\"")) << (*it)[1];
    }
  }
}

}  // namespace
}  // namespace gyrobudget::report
