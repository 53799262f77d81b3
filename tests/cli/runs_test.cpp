// SPDX-License-Identifier: MIT
// calibrate with several records of one sensor type.
#include <gtest/gtest.h>

#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

// Runs of 2 h at 10 Hz, each with N of its own in deg/sqrt(h).
class Runs {
 public:
  std::string add(const std::string& arw, const std::string& rate = "10") {
    const std::string index = std::to_string(++count_);
    const std::string sensor =
        scratch_.file("sensor.yaml", "name: m\ngyro:\n  arw: " + arw +
                                         " deg/sqrt(h)\n  rrw: 4.32 deg/h/sqrt(h)\n"
                                         "accelerometer:\n  vrw: 0.05 m/s/sqrt(h)\n  accel_rw: 50 ug/sqrt(h)\n");
    const std::string log = scratch_.path("run" + index + ".csv");
    EXPECT_EQ(gyrobudget_run("simulate " + sensor + " --duration 2h --axes x --rate " + rate + " --seed " + index +
                             " -o " + log)
                  .exit_code,
              0);
    return log + " ";
  }
  /// The rows of both logs behind one comment and header, the clock beginning anew with the second.
  [[nodiscard]] std::string join(const std::string& first, const std::string& second) const {
    const std::string joined = scratch_.path("joined.csv");
    EXPECT_EQ(shell("cat " + first + "> " + joined + " && tail -n +3 " + second + ">> " + joined).exit_code, 0);
    return joined;
  }
  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.path(name); }

 private:
  Scratch scratch_;
  int count_ = 0;
};

nlohmann::json json_of(const std::string& arguments) {
  const auto outcome = gyrobudget_run("calibrate --json " + arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return parsed<nlohmann::json>(outcome.out);
}

// One log of two power-ups is what two logs are.
TEST(Runs, AreTheSegmentsOfOneLog) {
  Runs runs;
  const std::string first = runs.add("0.15"), second = runs.add("0.15");
  const auto apart = json_of(first + second);
  const std::string joined = runs.join(first, second);
  const auto segments = json_of(joined + " --segments 10s");
  ASSERT_EQ(segments["runs"].size(), 2U);
  EXPECT_NE(segments["runs"][1]["source"].get<std::string>().find("segment 2"), std::string::npos);
  EXPECT_EQ(segments["combined"][0]["parameters"], apart["combined"][0]["parameters"]);
  EXPECT_EQ(gyrobudget_run("calibrate " + joined + " --segments 10s --curve x.csv").exit_code, 2);
  EXPECT_EQ(json_of(first + "--segments 10s")["schema"], "gyrobudget.calibration/1") << "one segment is one record";
}

TEST(Runs, OfOneSensorAgreeAndAreKnownBetterTogether) {
  Runs runs;
  std::string logs;
  for (int i = 0; i < 4; ++i) logs += runs.add("0.15");
  const auto result = json_of(logs);
  EXPECT_EQ(result["schema"], "gyrobudget.runs/1");
  ASSERT_EQ(result["runs"].size(), 4U);
  ASSERT_EQ(result["combined"].size(), 2U);
  const auto& arw = result["combined"][0]["parameters"]["arw"];
  // N of 72 000 samples is known to 0.27 %, of four such to half of that: 4 sigma.
  EXPECT_NEAR(arw["value"].get<double>() / 0.15, 1, 4 * 0.0027 / 2);
  EXPECT_EQ(arw["records"], 4);
  EXPECT_GT(arw["p_value"].get<double>(), 1e-3);
  EXPECT_LE(arw["next_lower"].get<double>(), arw["lower"].get<double>());
  const auto& vrw = result["combined"][1]["parameters"]["vrw"];
  EXPECT_EQ(vrw["unit"], "m/s/sqrt(h)");
  EXPECT_NEAR(vrw["value"].get<double>() / 0.05, 1, 4 * 0.0027 / 2);
}

TEST(Runs, OfUnitsThatDifferSaySoAndHowMuch) {
  Runs runs;
  const std::string logs = runs.add("0.12") + runs.add("0.15") + runs.add("0.18");
  const auto outcome =
      gyrobudget_run("calibrate " + logs + " -o " + runs.path("type.yaml") + " --report " + runs.path("page.html"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const std::string text : {"3 records of one sensor type", "run2.csv", "together", "they DIFFER", "spread"})
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << outcome.out;
  const auto arw = json_of(logs)["combined"][0]["parameters"]["arw"];
  // Root mean square of the three; their standard deviation is 0.03.
  EXPECT_NEAR(arw["value"].get<double>(), 0.15199, 0.0015);
  EXPECT_NEAR(arw["spread"].get<double>(), 0.03, 0.003);
  EXPECT_LT(arw["p_value"].get<double>(), 1e-6);
  EXPECT_NE(shell("cat " + runs.path("type.yaml")).out.find("spread between records"), std::string::npos);
  const std::string page = shell("cat " + runs.path("page.html")).out;
  EXPECT_NE(page.find("\"combined\":["), std::string::npos);
  EXPECT_NE(page.find("gyro_x, run3.csv"), std::string::npos);
}

TEST(Runs, ColumnsAreMatchedByName) {
  Runs runs;
  const std::string first = runs.add("0.15"), second = runs.add("0.15");
  const std::string swapped = runs.path("swapped.csv"), renamed = runs.path("renamed.csv");
  ASSERT_EQ(shell("awk -F, -v OFS=, '/^#/ {print; next} {print $1, $3, $2}' " + second + "> " + swapped).exit_code, 0);
  ASSERT_EQ(shell("sed s/gyro_x/gyro_a/ " + second + "> " + renamed).exit_code, 0);
  EXPECT_EQ(json_of(first + second)["combined"], json_of(first + swapped)["combined"]);
  const auto outcome = gyrobudget_run("calibrate " + first + renamed);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.err.find("found the columns 'gyro_a'"), std::string::npos) << outcome.err;
}

TEST(Runs, OfAnotherRateOrTwiceTheSameAreRefused) {
  Runs runs;
  const std::string first = runs.add("0.15"), slow = runs.add("0.15", "5");
  const auto rate = gyrobudget_run("calibrate " + first + slow);
  EXPECT_EQ(rate.exit_code, 3);
  EXPECT_NE(rate.err.find("found a rate of 5 Hz, expected the 10 Hz"), std::string::npos) << rate.err;
  EXPECT_EQ(gyrobudget_run("calibrate " + first + first).exit_code, 2);
  EXPECT_EQ(gyrobudget_run("calibrate " + first + slow + "-o " + slow).exit_code, 2);
}

}  // namespace
}  // namespace gyrobudget::tests
