// SPDX-License-Identifier: MIT
// The verb accuracy: its result, its limits and exit codes, the same bytes from any number of threads, interrupts.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using Json = nlohmann::json;

const std::string kMems = "accuracy '" GYROBUDGET_EXAMPLES "/sensors/mems.yaml' ";
const std::string kShort = kMems + "--records 64 --duration 1h -q ";

/// All but the times.
Json timeless(const std::string& text) {
  Json json = parsed<Json>(text);
  for (const char* key : {"seconds", "seconds_per_record", "command"}) json.erase(key);
  for (Json& method : json["methods"]) method.erase("seconds_per_fit");
  return json;
}

TEST(Accuracy, MeasuresEveryMethodAgainstTheTruth) {
  const Outcome run = gyrobudget_run(kShort + "--json --methods gls,edf,loglog,slope,visual,whittle");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const Json json = parsed<Json>(run.out);
  EXPECT_EQ(json["schema"], "gyrobudget.accuracy/1");
  EXPECT_EQ(json["record"]["samples"], 3600);
  EXPECT_EQ(json["records"], 64);
  EXPECT_TRUE(json["complete"].get<bool>());
  ASSERT_EQ(json["methods"].size(), 6U);
  const Json& arw = json["methods"][0]["coefficients"]["arw"];
  EXPECT_NEAR(arw["truth"].get<double>(), 0.15, 1e-9);
  // Six standard errors of an RMSE of 64 records about the bound, which the fit reaches for N.
  constexpr double kSixErrors = 6 / 11.3;
  EXPECT_NEAR(arw["over_bound"].get<double>(), 1, kSixErrors);
  // 95 % less five standard errors.
  EXPECT_GT(arw["coverage"].get<double>(), 0.95 - 5 * 0.0272);
  EXPECT_EQ(json["methods"][5]["coefficients"]["arw"]["over_likelihood"], 1.0);
  EXPECT_TRUE(json["methods"][4]["p05"].is_null());
}

TEST(Accuracy, SameBytesFromAnyNumberOfThreads) {
  const std::string what = kShort + "--json --methods gls,whittle --threads ";
  EXPECT_EQ(timeless(gyrobudget_run(what + "1").out), timeless(gyrobudget_run(what + "2").out));
  EXPECT_NE(timeless(gyrobudget_run(what + "2 --seed 2").out), timeless(gyrobudget_run(what + "2").out));
}

TEST(Accuracy, LimitsSetTheExitCodeAndAreAllPrinted) {
  const Outcome held = gyrobudget_run(kShort + "--require 'arw.rmse<2*crlb, coverage in 0.8..1'");
  EXPECT_EQ(held.exit_code, 0);
  EXPECT_NE(held.out.find("arw.rmse<2*crlb"), std::string::npos);
  EXPECT_EQ(held.out.find("BROKEN"), std::string::npos) << held.out;
  const Outcome broken = gyrobudget_run(kShort + "--json --require 'arw.rmse<0.5*crlb, coverage in 0.8..1'");
  EXPECT_EQ(broken.exit_code, 1);
  const Json requirements = parsed<Json>(broken.out)["requirements"];
  ASSERT_EQ(requirements.size(), 4U);  // the first of arw, the second of each coefficient
  EXPECT_FALSE(requirements[0]["met"].get<bool>());
  EXPECT_GT(requirements[0]["value"].get<double>(), 0.5);
  EXPECT_EQ(requirements[0]["coefficient"], "arw");
  EXPECT_TRUE(requirements[1]["met"].get<bool>());
  const Outcome absent = gyrobudget_run(kShort + "--methods gls --require 'edf.arw.rmse<1'");
  EXPECT_EQ(absent.exit_code, 1) << "what was not measured is not held";
}

TEST(Accuracy, RefusesWrongUseBeforeAnyWork) {
  for (const char* wrong :
       {"--require 'arw.rmse<'", "--require 'arw.size<1'", "--require ','", "--methods gls,magic", "--records 0",
        "--records many", "--duration 3s", "--rate 1e9", "--axis z", "--terms N,X", "--report -", "--longest 1e5",
        "--sweep --methods gls", "--sweep --require 'bias<1'", "--sweep --longest 10"}) {
    const Outcome run = gyrobudget_run(kMems + wrong);
    EXPECT_EQ(run.exit_code, 2) << wrong << '\n' << run.err;
    EXPECT_EQ(run.out, "") << wrong;
  }
  const Outcome column = gyrobudget_run(kMems + "--require 'coverage of 1'");
  EXPECT_NE(column.err.find("column 10"), std::string::npos) << column.err;
  EXPECT_EQ(gyrobudget_run("accuracy nowhere.yaml").exit_code, 3);
  EXPECT_EQ(gyrobudget_run(kMems + "--axis accelerometer").exit_code, 3);
}

TEST(Accuracy, AnAccelerometerHasItsOwnUnits) {
  const Scratch scratch;
  const std::string sensor = scratch.file("imu.yaml",
                                          "name: IMU\ngyro:\n  arw: 0.1 deg/sqrt(h)\naccelerometer:\n"
                                          "  vrw: 0.05 m/s/sqrt(h)\n  bias_instability: 20 ug\n");
  const Outcome run =
      gyrobudget_run("accuracy " + sensor + " --axis accelerometer --records 16 --duration 1h -q --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json coefficients = parsed<Json>(run.out)["methods"][0]["coefficients"];
  EXPECT_NEAR(coefficients["vrw"]["truth"].get<double>(), 0.05, 1e-9);
  EXPECT_EQ(coefficients["bias_instability"]["unit"], "ug");
  EXPECT_EQ(coefficients["accel_rw"]["truth"], 0);
  EXPECT_TRUE(coefficients["accel_rw"]["rmse"].is_null());
}

TEST(Accuracy, AnInterruptPrintsWhatIsDone) {
  // More records than there is time for; the interrupt comes once the first block is certainly done.
  const Outcome run = shell(
      "%P " + kMems + "--records 1000000 --duration 1h --methods gls --json & p=$!; sleep 1.5; kill -INT $p; wait $p");
  EXPECT_EQ(run.exit_code, 130);
  EXPECT_NE(run.err.find("interrupted: the result is that of the first"), std::string::npos) << run.err;
  const Json json = parsed<Json>(run.out);
  ASSERT_FALSE(json.is_discarded()) << run.out;
  EXPECT_FALSE(json["complete"].get<bool>());
  const int records = json["records"];
  ASSERT_GT(records, 0);
  EXPECT_LT(records, 1'000'000);
  // The beginning of a longer run is the shorter run.
  const auto whole = timeless(
      gyrobudget_run(kMems + "--duration 1h --methods gls --json -q --records " + std::to_string(records)).out);
  EXPECT_EQ(timeless(run.out)["methods"], whole["methods"]);
}

TEST(Accuracy, SweepHasEveryGroupOnTheSameRecords) {
  const Scratch scratch;
  const Outcome run = gyrobudget_run(kMems + "--sweep --records 4 --duration 1h --longest 1e4 -q --json --report " +
                                     scratch.path("page.html"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(scratch.files(), 1U);
  const Json json = parsed<Json>(run.out);
  EXPECT_EQ(json["schema"], "gyrobudget.accuracy_sweep/1");
  std::map<std::string, int> rows;
  for (const Json& row : json["rows"]) {
    ++rows[row["group"]];
    EXPECT_EQ(row["records"], 4);
    if (row["default"]) {
      EXPECT_EQ(row["coefficients"]["arw"]["over_default"], 1.0);
    }
  }
  EXPECT_EQ(rows, (std::map<std::string, int>{
                      {"method", 6}, {"covariance", 3}, {"taus an octave", 3}, {"stride", 8}, {"record length", 3}}));
}

}  // namespace
}  // namespace gyrobudget::tests
