// SPDX-License-Identifier: MIT
// A sensor behind a low pass, from its log to its datasheet, with what a user may say of the filter.
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <fstream>
#include <sstream>
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

std::string contents(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// The file has what was found, and a log that is simulated of it shows it again.
TEST(FrontEndOption, IsWrittenToTheSensorFileAndSimulated) {
  const Scratch scratch;
  const std::string sensor = scratch.path("sensor.yaml"), log = scratch.path("again.csv");
  const auto run = gyrobudget_run("calibrate " + filtered_log(scratch) + " --rate 100 --json -o " + sensor);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const double bandwidth = axis_of(run)["fit"]["front_end"]["bandwidth_hz"];
  EXPECT_NE(contents(sensor).find("  filter: {kind: first_order, bandwidth: "), std::string::npos) << contents(sensor);
  const auto made = gyrobudget_run("simulate " + sensor + " --rate 100 --duration 500s --axes x -o " + log);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto again = gyrobudget_run("calibrate " + log + " --json");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json front_end = axis_of(again)["fit"]["front_end"];
  EXPECT_EQ(front_end["kind"], "first_order");
  // Two draws of one bandwidth: their ratio within the sum of the two intervals, which 1 in 150 of pairs is not.
  EXPECT_LT(front_end["lower_hz"].get<double>(), bandwidth * front_end["upper_hz"].get<double>() / kBandwidth);
  EXPECT_GT(front_end["upper_hz"].get<double>(), bandwidth * front_end["lower_hz"].get<double>() / kBandwidth);
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
  // Whoever knows it pays nothing: at most as much as without one, but for the scatter of 20 records.
  EXPECT_LT(rmse(" --front-end first_order:10Hz --known all"), 2 * rmse(""));
}

TEST(FrontEndOption, AccuracySimulatesRecordersAndCountsRefusals) {
  const Scratch scratch;
  const std::string sensor = scratch.file("sensor.yaml", "name: s\ngyro:\n  arw: 0.15 deg/sqrt(h)\n");
  const std::string accuracy = "accuracy " + sensor + " --duration 100s --rate 100 --records 10 --methods gls ";
  const auto run = gyrobudget_run(accuracy + "--json --front-end rounding:3");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json arw = parsed<json>(run.out)["methods"][0]["coefficients"]["arw"];
  EXPECT_GT(arw["refused"].get<double>(), 0.5) << arw;
  const auto table = gyrobudget_run(accuracy + "--front-end rounding:3");
  EXPECT_NE(table.out.find("refused"), std::string::npos) << table.out;
  const auto refused = [&](const std::string& options, const std::string& why) {
    const auto bad = gyrobudget_run(accuracy + options);
    EXPECT_EQ(bad.exit_code, 2) << options << bad.err;
    EXPECT_NE(bad.err.find(why), std::string::npos) << options << bad.err;
  };
  refused("--front-end first_order", "need a bandwidth");
  refused("--front-end rounding", "write its size behind it");
  refused("--front-end held:x", "whole number");
  refused("--front-end gaps:-2%", "share of gaps");
  refused("--front-end melted:2", "must be first_order");
  refused("--known kind", "--front-end");
  refused("--front-end gaps:2% --known kind", "no low pass");
}

}  // namespace
}  // namespace gyrobudget::tests
