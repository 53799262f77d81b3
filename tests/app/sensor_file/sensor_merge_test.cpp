// SPDX-License-Identifier: MIT
#include "gyrobudget/app/sensor_file/sensor_merge.h"

#include "gyrobudget/app/text/error.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <string>
#include <vector>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using noise::SensorModel;
using noise::Signal;
using noise::Term;
using sensor_file::held_beyond;
using sensor_file::merged;
using sensor_file::read_sensor_file;
using sensor_file::Update;
using List = std::vector<std::string>;

class SensorMerge : public TemporaryFolder {};

// N, B and K of a gyro, as calibrate fits them; K is one for each axis.
Update fitted() {
  const auto si = [](const char* unit) { return noise::parse_unit(unit).to_si; };
  Update update;
  update.model.name = "new";
  update.model.gyro.white = 0.2 * si("deg/sqrt(h)");
  update.model.gyro.bias_instability = 0.7 * si("deg/h");
  const double walk = si("deg/h/sqrt(h)");
  update.model.gyro.rate_random_walk = {1 * walk, 2 * walk, 5 * walk};
  for (const Term t : {Term::white, Term::flicker, Term::rate_random_walk})
    update.fitted.push_back({Signal::angular_rate, t});
  update.comment = fmt::format("Fitted by: a test\n{}\n", sensor_file::kEndOfComment);
  return update;
}

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// As people write them: comments, an order of their own, an indent of their own.
constexpr std::string_view kByHand =
    "# bought in 2019\n"
    "name: bench gyro\n"
    "\n"
    "gyro:\n"
    "    # from the maker\n"
    "    turn_on_bias: 0.5 deg/h   # at 25 degC\n"
    "    arw: 0.1 deg/sqrt(h)      # from the maker too\n"
    "    range: 400 deg/s\n"
    "    rrw: [1 deg/h/sqrt(h),\n"
    "          2 deg/h/sqrt(h), 3 deg/h/sqrt(h)]\n"
    "    quantization: 0.5 arcsec\n"
    "    # the end of the gyro\n"
    "\n"
    "# mounting\n"
    "lever_arm: [0.1 m, 0 m, 0 m]\n";

TEST_F(SensorMerge, NamesWhatANewFileWouldLose) {
  const auto held = [&](std::string_view text) { return held_beyond(file("s.yaml", text), fitted()); };
  EXPECT_EQ(held(kByHand), (List{"gyro.turn_on_bias", "gyro.range", "gyro.quantization", "lever_arm"}));
  EXPECT_EQ(held("name: a\ngyro: {arw: 1 deg/sqrt(h)}\naccelerometer: {vrw: 1 m/s/sqrt(h)}\n"),
            (List{"accelerometer"}));
  EXPECT_EQ(held("gyro: {}\nwarning: a fan\n"), (List{"warning"}));
  EXPECT_TRUE(held("name: a\ngyro: {arw: 1 deg/sqrt(h), rrw: 1 deg/h/sqrt(h)}\n").empty());
  EXPECT_TRUE(held("").empty());
  EXPECT_TRUE(held_beyond(path("nowhere.yaml"), fitted()).empty());
  EXPECT_TRUE(held_beyond("/dev/null", fitted()).empty());
  // What a program wrote it may write again: coefficients that were fitted then, its own warnings.
  const std::string own = fmt::format("# Fitted by: x\n# {}\nwarning: [a step]\n", sensor_file::kEndOfComment);
  EXPECT_TRUE(
      held(own + "gyro: {quantization: 1 arcsec, gauss_markov: [{sigma: 1 deg/h, correlation_time: 1 s}]}\n").empty());
  EXPECT_EQ(held(own + "gyro: {quantization: 1 arcsec, delay: 1 ms}\n"), (List{"gyro.delay"}));
  for (const std::string_view other : {"a: b\n", "text\n", "gyroscope_noise_density: 1\n", "[: \n"})
    EXPECT_THROW((void)held(other), text::InputError) << other;
}

TEST_F(SensorMerge, ReplacesLinesOfCoefficientsAndLeavesTheOthers) {
  const auto result = merged(file("s.yaml", kByHand), fitted());
  const auto replaced = [](std::string text, std::string_view from, std::string_view to) {
    return text.replace(text.find(from), from.size(), to);
  };
  std::string expected = replaced(std::string(kByHand), "    arw: 0.1 deg/sqrt(h)      # from the maker too\n",
                                  "    arw: 0.2 deg/sqrt(h)\n");
  expected = replaced(expected, "    rrw: [1 deg/h/sqrt(h),\n          2 deg/h/sqrt(h), 3 deg/h/sqrt(h)]\n",
                      "    rrw: [1 deg/h/sqrt(h), 2 deg/h/sqrt(h), 5 deg/h/sqrt(h)]\n");
  constexpr std::string_view kLast = "    quantization: 0.5 arcsec\n";  // what is new goes behind the last coefficient
  expected = replaced(expected, kLast, std::string(kLast) + "    bias_instability: 0.7 deg/h\n");
  EXPECT_EQ(result.text, fmt::format("# Fitted by: a test\n# {}\n{}", sensor_file::kEndOfComment, expected));
  EXPECT_TRUE(result.taken.empty());
  const auto file_now = read_sensor_file(file("merged.yaml", result.text)).model;
  EXPECT_EQ(file_now.name, "bench gyro");
  EXPECT_EQ(file_now.gyro.white, fitted().model.gyro.white);
  EXPECT_EQ(file_now.gyro.rate_random_walk, fitted().model.gyro.rate_random_walk);
  EXPECT_EQ(file_now.gyro.bias_instability, fitted().model.gyro.bias_instability);
  const SensorModel before = read_sensor_file(file("s.yaml", kByHand)).model;
  EXPECT_EQ(file_now.gyro.turn_on_bias, before.gyro.turn_on_bias);
  EXPECT_EQ(file_now.gyro.range, before.gyro.range);
  EXPECT_EQ(file_now.gyro.quantization, before.gyro.quantization);
  EXPECT_EQ(file_now.lever_arm, before.lever_arm);
  // A second time nothing but the numbers changes: the comment takes the place of the first.
  EXPECT_EQ(merged(path("merged.yaml"), fitted()).text, result.text);
  // So does what its owner writes above it.
  EXPECT_EQ(merged(file("above.yaml", "# mine\n\n" + result.text), fitted()).text, "# mine\n\n" + result.text);
}

TEST_F(SensorMerge, PutsWarningsANameAndANewTriadIn) {
  Update update = fitted();
  update.rename = true;
  update.warnings = {"do not use: a step"};
  update.model.accelerometer = noise::ErrorModel{.white = 1e-3};
  update.fitted.push_back({Signal::specific_force, Term::white});
  const auto result = merged(file("s.yaml", kByHand), update);
  const auto now = read_sensor_file(file("merged.yaml", result.text));
  EXPECT_EQ(now.model.name, "new");
  EXPECT_EQ(now.warnings, update.warnings);
  EXPECT_EQ(now.model.accelerometer.value().white, noise::PerAxis(1e-3));
  EXPECT_TRUE(has(result.text, "# bought in 2019\n"));
  update.warnings.clear();
  EXPECT_TRUE(read_sensor_file(file("again.yaml", merged(path("merged.yaml"), update).text)).warnings.empty());
}

// Gauss-Markov processes stand for what B and K now hold: both together would count it twice.
TEST_F(SensorMerge, TakesOutWhatTheNewFitHoldsAlready) {
  const std::string markov =
      "gyro:\n  gauss_markov:\n    - {sigma: 1 deg/h, correlation_time: 100 s}\n  sinusoid:\n"
      "  - {amplitude: 1 deg/h, frequency: 50 Hz}\n  delay: 1 ms\n";
  const auto result = merged(file("s.yaml", markov), fitted());
  EXPECT_EQ(result.taken, (List{"gyro.gauss_markov"}));
  EXPECT_FALSE(has(result.text, "correlation_time"));
  EXPECT_EQ(result.model.gyro.sinusoids.size(), 1U);  // a record that was not fitted with one says nothing of it
  EXPECT_EQ(result.model.gyro.delay, 1e-3);
  Update white = fitted();
  white.fitted = {{Signal::angular_rate, Term::white}};
  EXPECT_EQ(merged(path("s.yaml"), white).model.gyro.gauss_markov.size(), 1U);
  EXPECT_EQ(merged(path("s.yaml"), white).model.gyro.rate_random_walk, noise::PerAxis(0));
}

// What a model has beside noise goes in too: in place of the file's, or behind the coefficients.
TEST_F(SensorMerge, PutsInWhatElseTheModelHas) {
  Update update = fitted();
  update.model.gyro.delay = 2e-3;
  for (const std::string_view text :
       {"gyro:\n  delay: 1 ms  # guessed\n  range: 400 deg/s\n", "gyro: {range: 400 deg/s}\n"}) {
    EXPECT_EQ(held_beyond(file("s.yaml", text), update), (List{"gyro.range"}));
    const auto now = read_sensor_file(file("merged.yaml", merged(path("s.yaml"), update).text)).model.gyro;
    EXPECT_EQ(now.delay, 2e-3);
    EXPECT_TRUE(now.range);
    EXPECT_EQ(now.white, update.model.gyro.white);
  }
}

// However a file is written, what it must hold it holds.
TEST_F(SensorMerge, HoldsWhatItMustInAnyStyle) {
  for (const std::string_view text :
       {"{name: a, gyro: {delay: 1 ms, arw: 1 deg/sqrt(h)}}\n", "gyro: {delay: 1 ms}\n# last\n", "gyro:\n delay: 1 ms",
        "---\ngyro:\n  ? arw\n  : 1 deg/sqrt(h)\n  delay: 1 ms\n", "gyro: &g\n  delay: 1 ms\naccelerometer: *g\n",
        "\"gyro\":\r\n  delay: 1 ms\r\n  arw: 1 deg/sqrt(h)\r\n",
        "gyro:\n  arw:\n    1 deg/sqrt(h)\n  delay: 1 ms\n"}) {
    const auto result = merged(file("s.yaml", text), fitted());
    const auto now = read_sensor_file(file("merged.yaml", result.text)).model;
    EXPECT_EQ(now.gyro.white, fitted().model.gyro.white) << text << result.text;
    EXPECT_EQ(now.gyro.rate_random_walk, fitted().model.gyro.rate_random_walk) << text;
    EXPECT_EQ(now.gyro.delay, 1e-3) << text << result.text;
  }
  EXPECT_THROW((void)merged(file("s.yaml", "gyroscope_noise_density: 1\n"), fitted()), text::InputError);
  EXPECT_THROW((void)merged(path("nowhere.yaml"), fitted()), text::InputError);
}

}  // namespace
}  // namespace gyrobudget::app_tests
