// SPDX-License-Identifier: MIT
// calibrate on records that hold more than noise, and by every method.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

const std::string kMems = GYROBUDGET_EXAMPLES "/sensors/mems.yaml";

nlohmann::json json_of(const Outcome& outcome) { return parsed<nlohmann::json>(outcome.out); }

// 2 h of the MEMS at 10 Hz with something added to the gyro by an awk expression of the sample's number i.
class Spoilt {
 public:
  explicit Spoilt(const std::string& added) {
    const std::string clean = scratch_.path("clean.csv");
    EXPECT_EQ(gyrobudget_run("simulate " + kMems + " --duration 2h --rate 10 --axes x --seed 4 -o " + clean).exit_code,
              0);
    const std::string awk = "awk -F, -v OFS=, -v CONVFMT=%.17g -v OFMT=%.17g '/^[0-9-]/ {i++; $2 += " + added + "} 1' ";
    EXPECT_EQ(shell(awk + clean + " > " + path()).exit_code, 0);
  }
  [[nodiscard]] std::string path() const { return scratch_.path("spoilt.csv"); }
  [[nodiscard]] nlohmann::json axis(const std::string& options = "") const {
    return json_of(gyrobudget_run("calibrate --json " + path() + " " + options))["axes"][0];
  }

 private:
  Scratch scratch_;
};

double value(const nlohmann::json& axis, const std::string& key) {
  return axis["parameters"][key]["value"].get<double>();
}

/// The first finding of a kind; null where there is none.
nlohmann::json finding(const nlohmann::json& axis, const std::string& kind) {
  for (const auto& found : axis["findings"])
    if (found["kind"] == kind) return found;
  return nullptr;
}

constexpr double kTruthN = 0.15, kTruthK = 4.32;  // of the MEMS

TEST(Findings, KnocksAreNamedWithTheirTimesAndMaskedOnRequest) {
  const Spoilt record("(i % 7001 == 5000 ? 0.01 : 0)");
  const auto as_it_is = record.axis(), masked = record.axis("--mask outliers");
  const auto knocks = finding(as_it_is, "outliers");
  EXPECT_EQ(knocks["count"], 10);
  EXPECT_NEAR(knocks["share"].get<double>(), 10. / 72000, 1e-12);
  EXPECT_NEAR(knocks["list"][0]["at_s"].get<double>(), 499.9, 1e-6);
  EXPECT_FALSE(knocks["masked"].get<bool>());
  EXPECT_TRUE(knocks["spoils"].get<bool>());
  EXPECT_GT(value(as_it_is, "arw"), 1.2 * kTruthN);  // ten knocks of 74 sigma are a third of the noise
  EXPECT_TRUE(finding(masked, "outliers")["masked"].get<bool>());
  // N of 72 000 samples is known to 0.27 %; five of those.
  EXPECT_NEAR(value(masked, "arw") / kTruthN, 1, 5 * 0.0027);
  const auto text = gyrobudget_run("calibrate " + record.path()).out;
  EXPECT_NE(text.find("10 of 72000 samples (0.014 %) lie further"), std::string::npos) << text;
  EXPECT_NE(text.find("--mask"), std::string::npos);
  EXPECT_NE(text.find("Do not use these numbers yet"), std::string::npos);
  EXPECT_EQ(gyrobudget_run("calibrate --mask outliers " + record.path()).out.find("Do not use"), std::string::npos);
}

TEST(Findings, FivePercentOfOutliersLeaveADatasheetWhenMasked) {
  const Spoilt record("(i % 20 == 3 ? (i % 40 == 3 ? 0.004 : -0.004) : 0)");
  const auto masked = record.axis("--mask outliers");
  EXPECT_EQ(finding(masked, "heavy_tail")["count"], 3600);
  EXPECT_EQ(finding(masked, "heavy_tail")["share"], 0.05);
  EXPECT_NEAR(value(masked, "arw") / kTruthN, 1, 5 * 0.003);
  EXPECT_EQ(masked["fit"]["verdict"], "described");
}

TEST(Findings, AStepIsNamedAndTheLongestPartWithoutItUsed) {
  const Spoilt record("(i > 30000 ? 6e-5 : 0)");
  const auto as_it_is = record.axis(), masked = record.axis("--mask steps");
  ASSERT_EQ(as_it_is["findings"].size(), 1U);
  EXPECT_NEAR(finding(as_it_is, "step")["at_s"].get<double>(), 3000, 60);
  EXPECT_GT(value(as_it_is, "rrw"), 1.5 * kTruthK);  // the step counts as walk
  EXPECT_TRUE(finding(masked, "step")["masked"].get<bool>());
  EXPECT_GT(masked["used"]["from_s"].get<double>(), 2900);
  EXPECT_EQ(masked["used"]["to_s"], 7200);
  EXPECT_LT(value(masked, "rrw"), 1.5 * kTruthK);
}

TEST(Findings, AWarmUpIsNamedAndLeftOutOnRequest) {
  const Spoilt record("3e-4 * exp(-i / 6000)");
  const auto as_it_is = record.axis(), masked = record.axis("--mask warm-up");
  ASSERT_FALSE(finding(as_it_is, "warm_up").is_null());
  EXPECT_NEAR(finding(as_it_is, "warm_up")["size"].get<double>() / (3e-4 * 206264.8), 1, 0.3);
  EXPECT_GT(value(as_it_is, "rrw"), 2 * kTruthK);
  EXPECT_GT(masked["used"]["from_s"].get<double>(), 1000);
  EXPECT_LT(value(masked, "rrw"), 2 * kTruthK);
}

TEST(Findings, ACleanRecordHasNone) {
  const Spoilt record("0");
  const auto axis = record.axis();
  EXPECT_EQ(axis["findings"], nlohmann::json::array());
  EXPECT_EQ(axis["used"]["from_s"], 0);
}

TEST(Methods, EachAnswersAndSaysItsName) {
  const Spoilt record("0");
  for (const std::string method : {"gls", "edf", "loglog", "slope", "visual", "whittle"}) {
    const auto axis = record.axis("--method " + method);
    EXPECT_EQ(axis["fit"]["method"], method);
    // The worst of them, log-log without weights, is off by 5 % (1 sigma).
    EXPECT_NEAR(value(axis, "arw") / kTruthN, 1, 0.2) << method;
    EXPECT_EQ(axis["fit"]["p_value"].is_null(), method != "gls" && method != "whittle") << method;
    EXPECT_TRUE(axis["minimum"].is_object()) << method;
  }
  EXPECT_EQ(gyrobudget_run("calibrate --method best " + record.path()).exit_code, 2);
}

TEST(Methods, CrossCheckSaysWhetherTheLikelihoodAgrees) {
  const Spoilt record("0");
  const auto axis = record.axis("--cross-check");
  const auto& check = axis["cross_check"];
  EXPECT_TRUE(check["agrees"].get<bool>());
  EXPECT_GT(check["p_value"].get<double>(), 1e-3);
  ASSERT_EQ(check["coefficients"].size(), 3U);
  EXPECT_EQ(check["coefficients"][0]["parameter"], "arw");
  EXPECT_EQ(check["coefficients"][0]["fit"], axis["parameters"]["arw"]["value"]);
  EXPECT_FALSE(record.axis().contains("cross_check"));
  EXPECT_NE(gyrobudget_run("calibrate --cross-check " + record.path()).out.find("The two agree."), std::string::npos);
}

TEST(Methods, ATableIsNoRecord) {
  for (const std::string option : {"--method whittle", "--cross-check", "--mask outliers"}) {
    const auto outcome = gyrobudget_run("calibrate --curve table.csv --rate 1 --duration 1h " + option);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("need the log"), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace gyrobudget::tests
