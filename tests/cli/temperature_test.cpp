// SPDX-License-Identifier: MIT
// A sensor that depends on its temperature, from simulation to datasheet to sensor file, and what it costs.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using json = nlohmann::json;

constexpr const char* kWarmSensor =
    "name: warm\n"
    "gyro:\n"
    "  arw: 0.15 deg/sqrt(h)\n"
    "  bias_instability: 0.7 deg/h\n"
    "  temperature: {reference: 25 degC, linear: [10 deg/h/K, -20 deg/h/K, 0 deg/h/K], rate: 30 deg/h/(K/min)}\n";

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

// Two exponentials, so that T and dT/dt are told apart.
std::string warming(const Scratch& scratch) {
  std::string rows = "time (s),temperature (degC)\n";
  for (int t = 0; t <= 7200; t += 20)
    rows += std::to_string(t) + "," + std::to_string(40 - 12 * std::exp(-t / 400.) - 8 * std::exp(-t / 2500.)) + "\n";
  return scratch.file("temperature.csv", rows);
}

// The intervals are of 95 %; twice as wide holds nearly all.
void expect_near_interval(const json& c, double truth, const std::string& what) {
  const double lower = c["lower"], upper = c["upper"], width = upper - lower;
  EXPECT_GT(truth, lower - width / 2) << what << c;
  EXPECT_LT(truth, upper + width / 2) << what << c;
}

TEST(TemperatureOfALog, IsFittedWrittenAndLeavesTheNoise) {
  const Scratch scratch;
  const std::string sensor = scratch.file("warm.yaml", kWarmSensor), log = scratch.path("log.csv"),
                    written = scratch.path("fitted.yaml"), page = scratch.path("page.html");
  const auto simulated = gyrobudget_run("simulate " + sensor + " --duration 2h --rate 10 --temperature " +
                                        warming(scratch) + " -o " + log);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto run = gyrobudget_run("calibrate " + log + " --json -o " + written + " --report " + page);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json sheet = parsed<json>(run.out);
  ASSERT_EQ(sheet["axes"].size(), 3U) << "the temperature is no axis";
  const double linear[] = {10, -20, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& t = sheet["axes"][i]["temperature"];
    EXPECT_TRUE(t["removed"].get<bool>());
    expect_near_interval(t["coefficients"]["linear"], linear[i], "linear");
    expect_near_interval(t["coefficients"]["rate"], 30, "rate");
    // N of 72 000 samples is known to 0.27 %; five of those.
    EXPECT_NEAR(sheet["axes"][i]["parameters"]["arw"]["value"].get<double>() / 0.15, 1, 5 * 0.0027);
  }
  const double before = sheet["axes"][1]["temperature"]["before"]["rrw"]["value"];
  const json& after = sheet["axes"][1]["parameters"]["rrw"];
  EXPECT_LT(after["value"].get<double>(), before / 3);
  EXPECT_NE(text_of(written).find("temperature:"), std::string::npos) << text_of(written);
  EXPECT_EQ(text_of(written).find("rad^1"), std::string::npos) << "few digits need no SI: " << text_of(written);
  EXPECT_NE(text_of(page).find("bias over temperature"), std::string::npos);
  EXPECT_EQ(gyrobudget_run("simulate " + written + " --duration 1min -o " + scratch.path("again.csv")).exit_code, 0);
}

TEST(TemperatureOfALog, StreamsAreTheSameAsTheBiasSays) {
  const Scratch scratch;
  const std::string sensor = scratch.file(
      "ideal.yaml", "gyro: {temperature: {reference: 20 degC, linear: 2 deg/h/K, quadratic: 1 deg/h/K^2}}\n");
  for (const std::string model : {"spectral", "gauss-markov"}) {
    const auto run = gyrobudget_run("simulate " + sensor + " --duration 10s --rate 1 --axes x --unit deg/h --model " +
                                    model + " --temperature '23 degC'");
    ASSERT_EQ(run.exit_code, 0) << run.err;
    // 2 x 3 + 9
    EXPECT_NE(run.out.find("\n0,15"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("temperature (degC)"), std::string::npos) << run.out;
  }
  EXPECT_EQ(gyrobudget_run("simulate " + sensor + " --duration 10s --temperature 'from=1 degC'").exit_code, 2);
  EXPECT_EQ(gyrobudget_run("simulate " + sensor + " --duration 10s --temperature '23 kg'").exit_code, 2);
}

// A bias of 10 K times 3 deg/h/K about the vertical, for 60 s at rest: 30 deg/h times 60 s are half a degree. It is not
// random, so each run of Monte Carlo has it as the covariance does.
TEST(TemperatureOfAScene, IsASourceOfTheBudget) {
  const Scratch scratch;
  const std::string sensor = scratch.file(
      "warm.yaml",
      "gyro: {temperature: {reference: 20 degC, linear: [0 deg/h/K, 0 deg/h/K, 3 deg/h/K]}}\naccelerometer:\n");
  const std::string scene = scratch.file(
      "scene.yaml",
      "name: warm\nsite: alcantara\ntrajectory: static:duration=60\n"
      "sensor: {file: " +
          sensor + ", temperature: 30 degC}\nalignment: {level_sigma: 1e-9 deg, heading_sigma: 1e-9 deg}\n");
  const auto run = gyrobudget_run("budget " + scene + " --keep-all --runs 20 --rate 20 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json found = parsed<json>(run.out);
  double attitude = 0;
  for (const auto& source : found["sources"])
    if (source["name"] == "gyro.temperature") attitude = source["attitude_deg"]["up"];
  constexpr double kTurned = 30. / 60;  // [deg]
  EXPECT_NEAR(attitude, kTurned, 1e-3 * kTurned);
  const json& ratio = found["monte_carlo"]["attitude_ratio"]["up"];
  ASSERT_TRUE(ratio.is_number()) << found["monte_carlo"];
  EXPECT_NEAR(ratio.get<double>(), 1, 1e-3);
}

TEST(RowsOfOneSensor, AreReadFromALogOfTwoByTurns) {
  const Scratch scratch;
  const std::string clean = scratch.path("clean.csv"), both = scratch.path("both.csv");
  ASSERT_EQ(
      gyrobudget_run(
          "simulate " GYROBUDGET_EXAMPLES "/sensors/mems.yaml --duration 1h --rate 10 --axes x --seed 4 -o " + clean)
          .exit_code,
      0);
  // Each row stands twice, a tenth of an interval apart: the second sensor has three times the noise.
  const std::string awk =
      "awk -F, -v OFS=, -v CONVFMT=%.17g -v OFMT=%.17g '/^[0-9]/ {print $1, 0, $2; s = 3 * $2; print $1 + 0.05, 1, s; next} /^time/ {print \"time (s)\", \"id\", \"gyro_x (rad/s)\"}' ";
  ASSERT_EQ(shell(awk + clean + " > " + both).exit_code, 0);
  const auto mixed = gyrobudget_run("calibrate --json " + both);
  EXPECT_EQ(mixed.exit_code, 1) << mixed.err;
  const json axis = parsed<json>(mixed.out)["axes"][0];
  EXPECT_EQ(axis["fit"]["verdict"], "not_described");
  ASSERT_FALSE(axis["findings"].empty());
  EXPECT_EQ(axis["findings"][0]["kind"], "several_sensors");
  EXPECT_NE(gyrobudget_run("calibrate " + both).out.find("--rows COLUMN=VALUE"), std::string::npos);
  const auto one = gyrobudget_run("calibrate --json " + both + " --rows id=0");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  const auto alone = parsed<json>(gyrobudget_run("calibrate --json " + clean).out)["axes"][0];
  EXPECT_EQ(parsed<json>(one.out)["axes"][0]["parameters"]["arw"]["value"], alone["parameters"]["arw"]["value"]);
  EXPECT_EQ(gyrobudget_run("calibrate " + both + " --rows id").exit_code, 2);
}

}  // namespace
}  // namespace gyrobudget::tests
