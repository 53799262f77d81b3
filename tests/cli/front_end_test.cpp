// SPDX-License-Identifier: MIT
// A sensor behind a low pass, from its log to its datasheet, with what a user may say of the filter.
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <string>
#include <vector>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using json = nlohmann::json;

constexpr double kWhite = 0.15;     // deg/sqrt(h)
constexpr double kBandwidth = 5.0;  // Hz, at 100 Hz

// A log of a gyro behind a first-order low pass, deg/h.
std::string filtered_log(const Scratch& scratch) {
  constexpr double kDt = 0.01, kPerRootHour = 60;  // 1 deg/sqrt(h) is 60 deg/h/sqrt(Hz)
  const noise::FilteredWhite white{kWhite * kPerRootHour, {noise::FrontEnd::Kind::first_order, kBandwidth}};
  const auto rate = noise::generate_record(std::vector<noise::Process>{white}, 50'000, kDt, {15, 1});
  std::string rows = "gyro_x (deg/h)\n";
  for (const double y : rate) rows += fmt::format("{}\n", y);
  return scratch.file("filtered.csv", rows);
}

json axis_of(const Outcome& run) { return parsed<json>(run.out)["axes"][0]; }

bool holds(const json& of, const char* lower, const char* upper, double truth) {
  return of[lower].get<double>() <= truth && truth <= of[upper].get<double>();
}

TEST(FrontEndOption, IsFoundGivenOrForbidden) {
  const Scratch scratch;
  const std::string calibrate = "calibrate " + filtered_log(scratch) + " --rate 100 --json";
  const auto found = gyrobudget_run(calibrate), kind = gyrobudget_run(calibrate + " --front-end first_order"),
             given = gyrobudget_run(calibrate + " --front-end first_order:5Hz"),
             none = gyrobudget_run(calibrate + " --front-end none");
  for (const auto* run : {&found, &kind, &given}) {
    ASSERT_EQ(run->exit_code, 0) << run->err;
    const json axis = axis_of(*run), front_end = axis["fit"]["front_end"];
    EXPECT_EQ(front_end["kind"], "first_order");
    EXPECT_EQ(front_end["fitted"], run != &given);
    EXPECT_TRUE(holds(front_end, "lower_hz", "upper_hz", kBandwidth)) << front_end;
    EXPECT_TRUE(holds(axis["parameters"]["arw"], "lower", "upper", kWhite)) << axis["parameters"]["arw"];
  }
  ASSERT_EQ(none.exit_code, 0) << none.err;
  const json without = axis_of(none)["fit"];
  EXPECT_TRUE(without["front_end"].is_null() || without["front_end"]["kind"] == "unknown") << without["front_end"];
  EXPECT_GT(without["tau_min_s"], axis_of(found)["fit"]["tau_min_s"]);
}

TEST(FrontEndOption, IsSaidInWords) {
  const Scratch scratch;
  const auto run = gyrobudget_run("calibrate " + filtered_log(scratch) + " --rate 100");
  EXPECT_NE(run.out.find("Front end: a low pass of first order with a bandwidth of"), std::string::npos) << run.out;
}

TEST(FrontEndOption, RefusesWhatItCannotUse) {
  const Scratch scratch;
  const std::string calibrate = "calibrate " + filtered_log(scratch) + " --rate 100 ";
  const auto refused = [&](const std::string& options, const std::string& why) {
    const auto run = gyrobudget_run(calibrate + options);
    EXPECT_EQ(run.exit_code, 2) << options << run.err;
    EXPECT_NE(run.err.find(why), std::string::npos) << options << run.err;
  };
  refused("--front-end third_order", "must be first_order, second_order or moving_average");
  refused("--front-end first_order:-3Hz", "must be above 0");
  refused("--front-end first_order:3Hz --method edf", "--method gls or whittle");
}

TEST(FrontEndOption, AccuracySimulatesRecordsBehindIt) {
  const Scratch scratch;
  const std::string sensor = scratch.file("sensor.yaml", "name: s\ngyro:\n  arw: 0.15 deg/sqrt(h)\n");
  const std::string accuracy = "accuracy " + sensor + " --duration 100s --rate 100 --records 20 --methods gls --json";
  const auto rmse = [&](const std::string& options) {
    const auto run = gyrobudget_run(accuracy + options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return parsed<json>(run.out)["methods"][0]["coefficients"]["arw"]["rmse"].get<double>();
  };
  // A free corner at a tenth of the rate costs a factor of 2 at least.
  EXPECT_GT(rmse(" --front-end first_order:10Hz"), 1.5 * rmse(""));
  const auto open = gyrobudget_run(accuracy + " --front-end first_order");
  EXPECT_EQ(open.exit_code, 2);
  EXPECT_NE(open.err.find("need a bandwidth"), std::string::npos) << open.err;
}

}  // namespace
}  // namespace gyrobudget::tests
