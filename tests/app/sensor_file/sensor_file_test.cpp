// SPDX-License-Identifier: MIT
#include "gyrobudget/app/sensor_file/sensor_file.h"

#include "gyrobudget/app/sensor_file/minimum.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>
#include <regex>
#include <stdexcept>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using noise::ErrorModel;
using Kind = noise::FrontEnd::Kind;
using noise::SensorModel;
using noise::Term;
using text::InputError;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kHour = 3600;
constexpr double kGravity = 9.80665;
constexpr double kLastDigits = 1e-15;  // relative: a few roundings

class SensorFile : public TemporaryFolder {
 protected:
  [[nodiscard]] SensorModel read(std::string_view text) const {
    return sensor_file::read_sensor(file("sensor.yaml", text));
  }
  [[nodiscard]] std::string message(std::string_view text) const {
    const std::string found = message_of<InputError>([&] { (void)read(text); });
    EXPECT_EQ(found.rfind(path("sensor.yaml"), 0), 0U) << found;
    return found.substr(std::min(found.size(), path("sensor.yaml").size()));
  }
};

void expect_near(double found, double expected) { EXPECT_NEAR(found, expected, kLastDigits * std::abs(expected)); }

void expect_same(const ErrorModel& a, const ErrorModel& b) {
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp}) {
    EXPECT_EQ(a[t], b[t]) << static_cast<char>(t);
  }
  ASSERT_EQ(a.gauss_markov.size(), b.gauss_markov.size());
  for (std::size_t i = 0; i < a.gauss_markov.size(); ++i) {
    EXPECT_EQ(a.gauss_markov[i].sigma, b.gauss_markov[i].sigma);
    EXPECT_EQ(a.gauss_markov[i].correlation_time, b.gauss_markov[i].correlation_time);
  }
  ASSERT_EQ(a.sinusoids.size(), b.sinusoids.size());
  for (std::size_t i = 0; i < a.sinusoids.size(); ++i) {
    EXPECT_EQ(a.sinusoids[i].amplitude, b.sinusoids[i].amplitude);
    EXPECT_EQ(a.sinusoids[i].frequency, b.sinusoids[i].frequency);
    EXPECT_EQ(a.sinusoids[i].phase, b.sinusoids[i].phase);
  }
  EXPECT_EQ(a.turn_on_bias, b.turn_on_bias);
  EXPECT_EQ(a.scale_factor, b.scale_factor);
  EXPECT_EQ(a.misalignment, b.misalignment);
  EXPECT_EQ(a.g_sensitivity, b.g_sensitivity);
  EXPECT_EQ(a.filter, b.filter);
  EXPECT_EQ(a.g2_sensitivity, b.g2_sensitivity);
  EXPECT_EQ(a.vibration_rectification, b.vibration_rectification);
  EXPECT_EQ(a.delay, b.delay);
  EXPECT_EQ(a.range, b.range);
  ASSERT_EQ(a.temperature.has_value(), b.temperature.has_value());
  if (a.temperature) {
    EXPECT_EQ(a.temperature->reference, b.temperature->reference);
    EXPECT_EQ(a.temperature->linear, b.temperature->linear);
    EXPECT_EQ(a.temperature->quadratic, b.temperature->quadratic);
    EXPECT_EQ(a.temperature->rate, b.temperature->rate);
  }
  EXPECT_EQ(a.powered_on_before, b.powered_on_before);
  EXPECT_EQ(a.calibrated_over, b.calibrated_over);
}

void expect_same(const SensorModel& a, const SensorModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.lever_arm, b.lever_arm);
  expect_same(a.gyro, b.gyro);
  ASSERT_EQ(a.accelerometer.has_value(), b.accelerometer.has_value());
  if (a.accelerometer) expect_same(*a.accelerometer, *b.accelerometer);
}

// --- The form of this project --------------------------------------------------------------------------------------

TEST_F(SensorFile, EveryKey) {
  const SensorModel m = read(R"yaml(# a comment
name: IFOG, closed loop, 2018
gyro:
  arw: 5.4e-4 deg/sqrt(h)
  bias_instability: 1.7e-3 deg/h   # coefficient
  rrw: "4.32e-2 deg/h/sqrt(h)"
  quantization: 1 arcsec
  rate_ramp: -1 deg/h/h
  gauss_markov: [{sigma: 0.1 deg/h, correlation_time: 300 s}, {sigma: 1 deg/h, correlation_time: 1 h}]
  sinusoid:
    - amplitude: 2 deg/h
      frequency: 50 mHz
      phase: 90 deg
  turn_on_bias: 0.01 deg/h
  scale_factor: 10 ppm
  misalignment: 20 arcsec
  g_sensitivity: 0.5 deg/h/g
  g2_sensitivity: 0.02 deg/h/g^2
  vibration_rectification: [1 deg/h/g^2, 2 deg/h/g^2, 3 deg/h/g^2]
  filter: {kind: second_order, bandwidth: 100 Hz}
  delay: 2 ms
  range: 400 deg/s
  powered_on_before: 1 h
  calibrated_over: 10 min
  temperature:
    reference: 30 degC
    linear: [5 deg/h/K, -6 deg/h/K, 7 deg/h/K]
    quadratic: -0.1 deg/h/K^2
    rate: 20 deg/h/(K/min)
lever_arm: [10 cm, 0 m, -2 mm]
accelerometer:
  turn_on_bias: [1 mg, 2 mg, 3000 ug]
  g2_sensitivity: 15 ug/g^2
  vrw: 0.06 m/s/sqrt(h)
  bias_instability: 10 ug
  accel_rw: 1 ug/sqrt(h)
)yaml");
  EXPECT_EQ(m.name, "IFOG, closed loop, 2018");
  expect_near(m.gyro.white[0], 5.4e-4 * kDegree / 60);
  expect_near(m.gyro.bias_instability[0], 1.7e-3 * kDegree / kHour);
  expect_near(m.gyro.rate_random_walk[0], 4.32e-2 * kDegree / kHour / 60);
  expect_near(m.gyro.quantization[0], kDegree / kHour);
  expect_near(m.gyro.rate_ramp[0], -kDegree / kHour / kHour);
  ASSERT_EQ(m.gyro.gauss_markov.size(), 2U);
  expect_near(m.gyro.gauss_markov[0].sigma[0], 0.1 * kDegree / kHour);
  expect_near(m.gyro.gauss_markov[1].correlation_time, kHour);
  ASSERT_EQ(m.gyro.sinusoids.size(), 1U);
  expect_near(m.gyro.sinusoids[0].frequency, 0.05);
  expect_near(m.gyro.sinusoids[0].phase, std::numbers::pi / 2);
  expect_near(m.gyro.turn_on_bias.value()[0], 0.01 * kDegree / kHour);
  expect_near(m.gyro.scale_factor.value()[0], 1e-5);
  expect_near(m.gyro.misalignment.value()[0], 20 * kDegree / kHour);
  expect_near(m.gyro.g_sensitivity.value()[0], 0.5 * kDegree / kHour / kGravity);
  EXPECT_EQ(m.gyro.filter, (noise::FrontEnd{Kind::second_order, 100, noise::FrontEnd::Sampling::held}));
  expect_near(m.gyro.g2_sensitivity.value()[2], 0.02 * kDegree / kHour / (kGravity * kGravity));
  for (const std::size_t axis : {0U, 1U, 2U}) {
    const auto number = static_cast<double>(axis + 1);
    expect_near(m.gyro.vibration_rectification.value()[axis], number * kDegree / kHour / (kGravity * kGravity));
    expect_near(m.accelerometer.value().turn_on_bias.value()[axis], number * 1e-3 * kGravity);
  }
  expect_near(m.gyro.delay.value(), 0.002);
  expect_near(m.gyro.range.value(), 400 * kDegree);
  expect_near(m.gyro.powered_on_before.value(), kHour);
  expect_near(m.gyro.calibrated_over.value(), 600);
  ASSERT_TRUE(m.gyro.temperature);
  EXPECT_EQ(m.gyro.temperature->reference, 30);
  expect_near(m.gyro.temperature->linear[1], -6 * kDegree / kHour);
  expect_near(m.gyro.temperature->quadratic[2], -0.1 * kDegree / kHour);
  expect_near(m.gyro.temperature->rate[0], 20 * kDegree / kHour * 60);
  expect_near(m.lever_arm[0], 0.1);
  EXPECT_EQ(m.lever_arm[1], 0);
  expect_near(m.lever_arm[2], -0.002);
  expect_near(m.accelerometer.value().g2_sensitivity.value()[1], 15e-6 / kGravity);
  ASSERT_TRUE(m.accelerometer);
  expect_near(m.accelerometer->white[0], 0.001);
  expect_near(m.accelerometer->bias_instability[0], 1e-5 * kGravity);
  expect_near(m.accelerometer->rate_random_walk[0], 1e-6 * kGravity / 60);
}

TEST_F(SensorFile, WhatIsLeftOutIsZeroOrIdeal) {
  const SensorModel m = read("gyro: {}\n");
  EXPECT_TRUE(m.gyro.processes(0).empty());
  EXPECT_FALSE(m.gyro.turn_on_bias);
  EXPECT_FALSE(m.accelerometer);
}

TEST_F(SensorFile, OtherUnitsOfTheSameKind) {
  expect_near(read("gyro: {arw: 60 deg/h/sqrt(Hz)}").gyro.white[0], kDegree / 60);
  expect_near(read("gyro: {arw: 1e-3 rad/s/√Hz}").gyro.white[0], 1e-3);
}

TEST_F(SensorFile, BiasStabilityIsTheMinimumOfTheCurve) {
  const std::string noise = "gyro:\n  arw: 0.3 deg/sqrt(h)\n  rrw: 10 deg/h/sqrt(h)\n";
  const SensorModel curve = read(noise + "  bias_instability: 4 deg/h\n");
  const double least =
      sensor_file::curve_minimum(curve.gyro.white[0], curve.gyro.bias_instability[0], curve.gyro.rate_random_walk[0]);
  constexpr double kDigits = 1e-9;
  const std::string key = fmt::format("  bias_stability: {:.12g} rad/s\n", least);
  for (const std::string& text : {noise + key, "gyro:\n" + key + noise.substr(noise.find('\n') + 1)}) {  // in any order
    const auto file = sensor_file::read_sensor_file(this->file("sensor.yaml", text));
    EXPECT_NEAR(file.model.gyro.bias_instability[2] / curve.gyro.bias_instability[2], 1, kDigits);
    ASSERT_EQ(file.notes.size(), 1U);
    EXPECT_CONTAINS(file.notes[0], "bias_stability of gyro is the minimum of the Allan deviation");
    EXPECT_CONTAINS(file.notes[0], "bias_instability 4.000 deg/h");
  }
  // Without a walk the minimum is the flat of flicker.
  EXPECT_NEAR(read("gyro:\n  arw: 0.3 deg/sqrt(h)\n  bias_stability: 6.6428 deg/h\n").gyro.bias_instability[0] /
                  read("gyro:\n  bias_instability: 10 deg/h\n").gyro.bias_instability[0],
              1, 1e-4);
  EXPECT_CONTAINS(message(noise + "  bias_stability: 0.1 deg/h\n"),
                  ":4:19: bias_stability: found '0.1 deg/h', expected at least ");
  EXPECT_CONTAINS(message(noise + "  bias_instability: 4 deg/h\n  bias_stability: 9 deg/h\n"),
                  "beside bias_instability");
}

// Help has every key that the reader takes: its own list of them stands in the error of one that it does not.
TEST_F(SensorFile, HelpHasEveryKey) {
  const std::string help(sensor_file::sensor_help());
  EXPECT_NO_THROW((void)read(help));
  for (const char* text : {"gyro:\n  zzzzzz: 1\n", "gyro: ideal\naccelerometer:\n  zzzzzz: 1\n"}) {
    const std::string error = message(text);
    ASSERT_NE(error.find("there are "), std::string::npos) << error;
    const std::regex word("[a-z_0-9]+");
    const std::string list = error.substr(error.find("there are ") + 10);
    int keys = 0;
    for (std::sregex_iterator at(list.begin(), list.end(), word), end; at != end; ++at) {
      if (at->str() == "and") continue;
      ++keys;
      EXPECT_TRUE(std::regex_search(help, std::regex("[ #{,]" + at->str() + "\\b"))) << at->str();
    }
    EXPECT_GE(keys, 18);
  }
}

TEST_F(SensorFile, RoundTripIsExact) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-12, 2), digits(1, 10);
  const auto any = [&] { return digits(random) * std::pow(10, std::floor(exponent(random))); };
  constexpr std::array kKinds{Kind::first_order, Kind::second_order, Kind::moving_average};
  std::size_t kind = 0;
  const auto fill = [&](ErrorModel& m) {
    for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp})
      m[t] = any();
    m.gauss_markov = {{any(), any()}, {any(), any()}};
    m.sinusoids = {{any(), any(), any()}, {any(), any(), 0}};
    m.turn_on_bias = any();
    m.scale_factor = m.misalignment = m.g2_sensitivity = m.vibration_rectification = noise::PerAxis(any(), 0, any());
    for (auto* extra : {&m.delay, &m.range, &m.powered_on_before, &m.calibrated_over}) *extra = any();
    m.filter = {kKinds.at(kind++ % kKinds.size()), any(), noise::FrontEnd::Sampling::held};
    m.temperature = {any(), noise::PerAxis(any(), -any(), any()), any(), -any()};
  };
  constexpr int kModels = 300;
  for (int i = 0; i < kModels; ++i) {
    SensorModel model;
    model.name = i % 2 ? "gyro \"x\": #1, 5 °C" : "plain name";
    fill(model.gyro);
    model.gyro.g_sensitivity = any();
    if (i % 3) {
      fill(model.accelerometer.emplace());
      model.lever_arm = {any(), -any(), 0};
    }
    expect_same(read(sensor_file::sensor_yaml(model, "written\nby a test")), model);
  }
}

TEST_F(SensorFile, TheOlderKeysOfAFilterAreRead) {
  const auto filter = [&](const std::string& keys) { return read("gyro: {" + keys + "}").gyro.filter; };
  const auto held = noise::FrontEnd::Sampling::held;
  EXPECT_EQ(filter("bandwidth: 0.1 kHz"), (noise::FrontEnd{Kind::first_order, 100, held}));
  EXPECT_EQ(filter("filter_order: 2, bandwidth: 25 Hz"), (noise::FrontEnd{Kind::second_order, 25, held}));
  EXPECT_EQ(filter("filter: {bandwidth: 25 Hz, kind: moving_average}"),
            (noise::FrontEnd{Kind::moving_average, 25, held}));
  EXPECT_EQ(filter("arw: 0.1 deg/sqrt(h)"), std::nullopt);
}

TEST_F(SensorFile, ATemperatureNeedsItsReferenceInDegreesCelsius) {
  EXPECT_CONTAINS(message("gyro: {temperature: {linear: 5 deg/h/K}}"), "found no reference");
  EXPECT_CONTAINS(message("gyro: {temperature: {reference: 300 K, linear: 5 deg/h/K}}"), "expected it in degC");
  EXPECT_CONTAINS(message("gyro: {temperature: {reference: 30 degC, linear: 5 deg/h}}"), "deg/h/K");
}

TEST_F(SensorFile, NamesThatYamlWouldReadAsSomethingElse) {
  for (const std::string name : {"yes", "null", "~", "1.5", "a: b", "a #b", "- x", "'", "\"", "back\\slash", " lead",
                                 "trail ", "[x]", "{x}", "&a", "*a", "line\nbreak", "Größe", "x"}) {
    SensorModel model;
    model.name = name;
    EXPECT_EQ(read(sensor_file::sensor_yaml(model)).name, text::printable(name));
  }
}

TEST_F(SensorFile, IsWrittenWithTheFewestDigitsInDatasheetUnits) {
  const SensorModel m =
      read("name: IFOG\ngyro: {arw: 5.4e-4 deg/sqrt(h), bias_instability: 1.7e-3 deg/h, rrw: 4.32e-2 deg/h/sqrt(h)}");
  EXPECT_EQ(sensor_file::sensor_yaml(m, "made by hand"),
            "# made by hand\nname: \"IFOG\"\ngyro:\n  arw: 0.00054 deg/sqrt(h)\n  bias_instability: 0.0017 deg/h\n"
            "  rrw: 0.0432 deg/h/sqrt(h)\n");
}

TEST_F(SensorFile, ErrorsNamePlaceFindingAndExpectation) {
  EXPECT_CONTAINS(message("gyro:\n  arw: 0.15\n"), ":2:8: arw: '0.15' has no unit; expected one like deg/sqrt(h)");
  EXPECT_CONTAINS(message("gyro:\n  arw: 0.15 deg/h\n"), ":2:8: arw: '0.15 deg/h' has a unit of the wrong kind");
  EXPECT_CONTAINS(message("gyro:\n  arw: abc\n"), ":2:8: arw: 'abc' does not start with a finite number");
  EXPECT_CONTAINS(message("gyro:\n  arw: -1 deg/sqrt(h)\n"),
                  ":2:8: arw: found '-1 deg/sqrt(h)', expected a value of 0 or more");
  EXPECT_CONTAINS(message("gyro:\n  arv: 1 deg/sqrt(h)\n"),
                  ":2:3: 'arv' is no key of gyro (did you mean 'arw'?); there are arw,");
  EXPECT_CONTAINS(message("gyros:\n  arw: 1 deg/sqrt(h)\n"), ":1:1: found the key 'gyros', expected \"gyro:\"");
  EXPECT_CONTAINS(message("gyro:\n  vrw: 1 m/s/sqrt(h)\n"), "'vrw' is no key of gyro");
  EXPECT_CONTAINS(message("gyro:\naccelerometer:\n  g_sensitivity: 1 deg/h/g\n"),
                  ":3:3: 'g_sensitivity' is no key of accelerometer");
  EXPECT_CONTAINS(message("gyro:\n  turn_on_bias: [1 deg/h, 2 deg/h]\n"),
                  ":2:17: turn_on_bias: found a list of 2, expected a list of three, [x, y, z]");
  EXPECT_CONTAINS(message("gyro:\n  turn_on_bias: [1 deg/h, 2 deg/h, 3]\n"), ":2:36: turn_on_bias: '3' has no unit");
  EXPECT_CONTAINS(message("gyro:\n  filter_order: 3\n"),
                  ":2:17: filter_order: found '3', expected a whole number from 1 to 2");
  EXPECT_CONTAINS(message("gyro:\n  filter: {kind: third_order, bandwidth: 5 Hz}\n"),
                  ":2:18: kind: found 'third_order', expected first_order, second_order or moving_average");
  EXPECT_CONTAINS(message("gyro:\n  filter: {kind: first_order}\n"), ":2:11: filter: found no bandwidth");
  EXPECT_CONTAINS(message("gyro:\n  filter: {bandwidth: 5 Hz}\n"), ":2:11: filter: found no kind");
  EXPECT_CONTAINS(message("gyro:\n  filter: {kind: first_order, bandwidth: 5 Hz}\n  bandwidth: 5 Hz\n"),
                  ":3:14: bandwidth: found it beside filter");
  EXPECT_CONTAINS(message("gyro:\n  bandwidth: 0 Hz\n"), "expected a value above 0");
  EXPECT_CONTAINS(message("gyro: {arw: 1 deg/sqrt(h)}\n--- # next\ngyro: {}\n"), ":3:1: found a second document");
  EXPECT_CONTAINS(message("gyro:\n  calibrated_ovr: 1 s\n"), "did you mean 'calibrated_over'?");
  EXPECT_CONTAINS(message("gyro:\nlever_arm: 1 m\n"), ":2:12: lever_arm: found '1 m', expected a list of three");
  EXPECT_CONTAINS(message("gyro:\nscale: 1\n"), ":2:1: 'scale' is no key of a sensor file");
  EXPECT_CONTAINS(message("accelerometer:\n"), "found no \"gyro:\"");
  EXPECT_CONTAINS(message("gyro: 5\n"), ":1:7: gyro: found '5', expected keys and values below it");
  EXPECT_CONTAINS(
      message("gyro:\n  arw: [1, 2]\n"),
      ":2:8: arw: found a list of 2, expected a list of three, [x, y, z], each a number and a unit (deg/sqrt(h)");
  EXPECT_CONTAINS(message("gyro:\n  arw: 1 deg/sqrt(h)\n  arw: 2 deg/sqrt(h)\n"), ":3:3: 'arw' is given twice");
  EXPECT_CONTAINS(message("gyro:\n  gauss_markov: [{sigma: 1 deg/h}]\n"),
                  ":2:18: gauss_markov: found no 'correlation_time'");
  EXPECT_CONTAINS(message("gyro:\n  gauss_markov: [{sigma: 1 deg/h, correlation_time: 0 s}]\n"),
                  "expected a value above 0");
  EXPECT_CONTAINS(message("gyro:\n  gauss_markov: {sigma: 1 deg/h}\n"),
                  "expected a list like [{sigma: ..., correlation_time: ...}]");
  EXPECT_CONTAINS(message("gyro:\n  sinusoid: [{amplitud: 1 deg/h}]\n"),
                  "'amplitud' is no key of sinusoid (did you mean 'amplitude'?)");
  EXPECT_CONTAINS(message("gyro: {arw: 1\n"), ": no YAML: ");
  EXPECT_CONTAINS(message("just text"), ":1:1: found 'just text', expected keys");
  EXPECT_CONTAINS(message("- a\n- b\n"), "found a list, expected keys");
  EXPECT_CONTAINS(message(""), ": is empty");
  EXPECT_CONTAINS(message("# nothing\n"), "found nothing, expected keys");
  EXPECT_CONTAINS(message(std::string("gyro:\0", 6)), "expected a text file");
  EXPECT_CONTAINS(message(std::string(2 << 20, '\n')),
                  "has more than 1048576 bytes, expected a sensor file of at most that");
}

TEST_F(SensorFile, MutationsGiveAModelOrAnInputError) {
  const std::string seed =
      "name: a\ngyro:\n  arw: 5.4e-4 deg/sqrt(h)\n  gauss_markov: [{sigma: 1 deg/h, correlation_time: 3 s}]\n"
      "  range: 400 deg/s\naccelerometer: {vrw: 1 m/s/sqrt(h)}\n";
  std::mt19937_64 random(7);
  constexpr int kMutants = 3000;
  int models = 0;
  for (int i = 0; i < kMutants; ++i) {
    std::string text = seed;
    for (int n = 0; n < 1 + i % 3; ++n) {
      const std::size_t at = random() % text.size();
      if (random() % 2) {
        text[at] = static_cast<char>(random() % 128);
      } else {
        text.erase(at, random() % 8);
      }
    }
    try {
      (void)read(text);
      ++models;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(models, 0);
  EXPECT_LT(models, kMutants);
}

TEST_F(SensorFile, TheExamplesHoldThePapersValues) {
  // Nunes et al., table I, converted by hand: N [rad/sqrt(s)], B [rad/s], K [rad/s/sqrt(s)].
  const std::string folder = GYROBUDGET_EXAMPLES "/sensors/";
  const SensorModel ifog = sensor_file::read_sensor(folder + "ifog.yaml"),
                    mems = sensor_file::read_sensor(folder + "mems.yaml");
  constexpr double kPrinted = 5e-7;  // relative: the values below have seven digits
  for (const auto& [found, expected] : {std::pair{ifog.gyro.white[0], 1.570796e-7},
                                        {ifog.gyro.bias_instability[0], 8.241833e-9},
                                        {ifog.gyro.rate_random_walk[0], 3.490659e-9},
                                        {mems.gyro.white[0], 4.363323e-5},
                                        {mems.gyro.bias_instability[0], 3.393696e-6},
                                        {mems.gyro.rate_random_walk[0], 3.490659e-7}}) {
    EXPECT_NEAR(found, expected, kPrinted * expected);
  }
}

// --- The forms of others -------------------------------------------------------------------------------------------

TEST_F(SensorFile, Kalibr) {
  const SensorModel m = read(
      "#Accelerometers\naccelerometer_noise_density: 1.86e-03   #Noise density (continuous-time)\n"
      "accelerometer_random_walk:   4.33e-04\ngyroscope_noise_density:     1.87e-04\ngyroscope_random_walk: 2.66e-05\n"
      "rostopic:                    /imu0\nupdate_rate:                 200.0\n");
  EXPECT_EQ(m.gyro.white, 1.87e-4);
  EXPECT_EQ(m.gyro.rate_random_walk, 2.66e-5);
  EXPECT_EQ(m.gyro.bias_instability, 0);
  EXPECT_EQ(m.accelerometer.value().white, 1.86e-3);
  EXPECT_EQ(m.accelerometer.value().rate_random_walk, 4.33e-4);
}

TEST_F(SensorFile, OpenVinsNestsKalibrUnderItsImu) {
  const SensorModel m = read(
      "%YAML:1.0\n\nimu0:\n  T_i_b:\n    - [1.0, 0.0, 0.0, 0.0]\n  accelerometer_noise_density: 0.002\n"
      "  accelerometer_random_walk: 3.0e-03\n  gyroscope_noise_density: 1.6968e-04\n  gyroscope_random_walk: 1.9393e-05\n"
      "  model: calibrated\n  update_rate: 200.0\n");
  EXPECT_EQ(m.gyro.white, 1.6968e-4);
  EXPECT_EQ(m.accelerometer.value().rate_random_walk, 3e-3);
}

TEST_F(SensorFile, VinsWritesWalks) {
  const SensorModel m = read("%YAML:1.0\nimu: 1\nacc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 1.0e-4\n");
  EXPECT_EQ(m.gyro.white, 0.01);
  EXPECT_EQ(m.gyro.rate_random_walk, 1e-4);
  EXPECT_EQ(m.gyro.bias_instability, 0);
}

TEST_F(SensorFile, ImuUtilsWritesTheMinimumOfTheCurve) {
  const SensorModel m = read(
      "%YAML:1.0\n---\ntype: IMU\nname: xsens\nGyr:\n   unit: \" rad/s\"\n   avg-axis:\n      gyr_n: 1.5e-04\n      gyr_w: 6.0e-05\n"
      "   x-axis:\n      gyr_n: 1.0e-04\n      gyr_w: 6.1e-05\nAcc:\n   unit: \" m/s^2\"\n   avg-axis:\n      acc_n: 1.0e-02\n"
      "      acc_w: 3.0e-04\n");
  EXPECT_EQ(m.name, "xsens");
  EXPECT_EQ(m.gyro.white, 1.5e-4);
  EXPECT_EQ(m.gyro.rate_random_walk, 0);
  // IEEE Std 952: the flat of the Allan deviation of flicker noise is 0.664 B.
  EXPECT_NEAR(m.gyro.bias_instability[0], 6e-5 / 0.6643, 1e-8);
  EXPECT_NEAR(m.accelerometer.value().bias_instability[0], 3e-4 / 0.6643, 1e-7);
}

TEST_F(SensorFile, ErrorsInTheFormsOfOthers) {
  EXPECT_CONTAINS(message("gyroscope_noise_density: 1e-4\n"),
                  "found no 'gyroscope_random_walk', expected one beside the others");
  EXPECT_CONTAINS(message("gyroscope_noise_density: 1e-4 rad\ngyroscope_random_walk: 1e-5\n"),
                  ":1:26: gyroscope_noise_density: found '1e-4 rad', expected a plain number (SI, continuous time)");
  EXPECT_CONTAINS(message("gyroscope_noise_density: -1\ngyroscope_random_walk: 1e-5\n"),
                  "expected a value of 0 or more");
  EXPECT_CONTAINS(message("imu0:\n  gyroscope_noise_density: [1]\n  gyroscope_random_walk: 1\n"),
                  ":2:28: gyroscope_noise_density: found a list");
  EXPECT_CONTAINS(message("Gyr: {unit: rad, avg-axis: {gyr_n: 1, gyr_w: 1}}\n"),
                  "unit: found 'rad', expected one like deg/h");
  EXPECT_CONTAINS(message("Gyr: {x: 1}\n"), "found no avg-axis");
}

// --- Axes that differ ----------------------------------------------------------------------------------------------

TEST_F(SensorFile, CoefficientsOfEachAxis) {
  const SensorModel m = read(
      "gyro:\n  arw: [0.15 deg/sqrt(h), 9 deg/h/sqrt(Hz), 0 deg/sqrt(h)]\n  rate_ramp: [-1 deg/h/h, 0 deg/h/h, 1 deg/h/h]\n"
      "  gauss_markov: [{sigma: [1 deg/h, 0 deg/h, 2 deg/h], correlation_time: 300 s}]\n"
      "  sinusoid: [{amplitude: [2 deg/h, 2 deg/h, 2 deg/h], frequency: 50 Hz}]\n");
  expect_near(m.gyro.white[0], 0.15 * kDegree / 60);
  expect_near(m.gyro.white[1], 0.15 * kDegree / 60);
  EXPECT_EQ(m.gyro.white[2], 0);
  expect_near(m.gyro.rate_ramp[0], -kDegree / kHour / kHour);
  expect_near(m.gyro.gauss_markov[0].sigma[2], 2 * kDegree / kHour);
  EXPECT_EQ(m.gyro.gauss_markov[0].sigma[1], 0);
  EXPECT_TRUE(m.gyro.sinusoids[0].amplitude.is_uniform());
  // What is the same for all is written once, what is not three times.
  const std::string text = sensor_file::sensor_yaml(m);
  EXPECT_CONTAINS(text, "  bias_instability: 0 deg/h\n");
  EXPECT_CONTAINS(text, "sigma: [1 deg/h, 0 deg/h, 2 deg/h], correlation_time: 3e+02 s");
  EXPECT_CONTAINS(text, "amplitude: 2 deg/h, frequency: 5e+01 Hz");
  expect_same(read(text).gyro, m.gyro);
  EXPECT_CONTAINS(message("gyro:\n  arw: [1 deg/sqrt(h), 2 deg/sqrt(h)]\n"),
                  ":2:8: arw: found a list of 2, expected a list of three, [x, y, z]");
  EXPECT_CONTAINS(message("gyro:\n  rrw: [1 deg/h/sqrt(h), -2 deg/h/sqrt(h), 0 deg/h/sqrt(h)]\n"),
                  "expected a value of 0 or more");
}

TEST_F(SensorFile, RoundTripOfAxesThatDifferIsExact) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> digits(1, 10);
  const auto any = [&] { return noise::PerAxis(digits(random), digits(random), 0); };
  constexpr int kModels = 100;
  for (int i = 0; i < kModels; ++i) {
    SensorModel model;
    for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp})
      model.gyro[t] = any();
    model.gyro.gauss_markov = {{any(), digits(random)}};
    model.gyro.sinusoids = {{any(), digits(random), 0}};
    expect_same(read(sensor_file::sensor_yaml(model)).gyro, model.gyro);
  }
}

// --- What a file states, and what it warns of ----------------------------------------------------------------------

TEST_F(SensorFile, AnIdealTriadIsStatedToBeOne) {
  for (const std::string_view ideal : {"accelerometer: ideal\n", "accelerometer:\n"}) {
    const SensorModel m = read("gyro: {arw: 1 deg/sqrt(h)}\n" + std::string(ideal));
    ASSERT_TRUE(m.accelerometer) << ideal;
    EXPECT_EQ(m.accelerometer->scale_factor, noise::PerAxis(0));
    EXPECT_EQ(m.accelerometer->turn_on_bias, noise::PerAxis(0));
    EXPECT_FALSE(m.gyro.scale_factor);
  }
  EXPECT_CONTAINS(message("gyro: perfect\n"), "gyro: found 'perfect', expected keys and values below it");
}

TEST_F(SensorFile, WarningsAreReadAndWritten) {
  using List = std::vector<std::string>;
  const auto warnings = [&](std::string_view text) {
    return sensor_file::read_sensor_file(file("sensor.yaml", text)).warnings;
  };
  EXPECT_EQ(warnings("warning: the fan was on\ngyro: ideal\n"), (List{"the fan was on"}));
  EXPECT_EQ(warnings("gyro: ideal\nwarning: [a, b]\n"), (List{"a", "b"}));
  EXPECT_TRUE(warnings("gyro: ideal\n").empty());
  const List two{"do not use: a step, \"big\"", "yes"};
  EXPECT_EQ(warnings(sensor_file::sensor_yaml({}, {}, two)), two);
  EXPECT_CONTAINS(message("warning: {a: b}\ngyro: ideal\n"), "warning: found keys and values, expected text");
}

// --- Files that do not tell which of two forms they are of -----------------------------------------------------------

// VINS' code takes gyr_n for a sigma of a sample: N = n / sqrt(rate), and adds (w dt)^2 to a bias' variance each step,
// w^2 dt a second: K = w / sqrt(rate).
TEST_F(SensorFile, SigmasOfASampleAreReadWithTheirRate) {
  const std::string vins =
      "%YAML:1.0\nimu: 1\nacc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\ng_norm: 9.81\n";
  const auto with_rate = sensor_file::read_sensor_file(file("vins.yaml", vins), {.rate_hz = 200});
  const double root = std::sqrt(200.0);
  expect_near(with_rate.model.gyro.white[0], 0.004 / root);
  expect_near(with_rate.model.gyro.rate_random_walk[0], 2e-6 / root);
  expect_near(with_rate.model.accelerometer.value().white[0], 0.08 / root);
  expect_near(with_rate.model.accelerometer.value().rate_random_walk[0], 4e-5 / root);
  ASSERT_EQ(with_rate.notes.size(), 1U);
  EXPECT_CONTAINS(with_rate.notes[0],
                  "sigmas of a sample at 200 Hz, so gyr_n is an angle random walk of 0.972 deg/sqrt(h)");
  EXPECT_CONTAINS(with_rate.notes[0], "it would be 13.8 deg/sqrt(h)");  // .004 rad/sqrt(s) = .004 * 57.2958 * 60
  const auto without = sensor_file::read_sensor_file(file("vins.yaml", vins));
  EXPECT_EQ(without.model.gyro.white, noise::PerAxis(0.004));
  ASSERT_EQ(without.notes.size(), 1U);
  EXPECT_CONTAINS(without.notes[0], "read as densities, so gyr_n is an angle random walk of 13.8 deg/sqrt(h)");
  EXPECT_CONTAINS(without.notes[0], "it would be 0.972 deg/sqrt(h) at 200 Hz");
  // Kalibr's keys are densities by their name, whatever the rate.
  const std::string kalibr = "gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 1e-5\n";
  const auto densities = sensor_file::read_sensor_file(file("kalibr.yaml", kalibr), {.rate_hz = 200});
  EXPECT_EQ(densities.model.gyro.white, noise::PerAxis(1e-4));
  EXPECT_TRUE(densities.notes.empty());
  EXPECT_THROW((void)sensor_file::read_sensor_file(file("v.yaml", vins), {.rate_hz = 0}), std::invalid_argument);
}

TEST_F(SensorFile, ImuUtilsHasAxesAndMayHaveSigmasOfASample) {
  const std::string text =
      "Gyr:\n  unit: \" rad/s\"\n  avg-axis: {gyr_n: 2, gyr_w: 2}\n  x-axis: {gyr_n: 1, gyr_w: 1}\n"
      "  y-axis: {gyr_n: 2, gyr_w: 2}\n  z-axis: {gyr_n: 3, gyr_w: 4}\n";
  const auto densities = sensor_file::read_sensor_file(file("i.yaml", text));
  EXPECT_EQ(densities.model.gyro.white, noise::PerAxis(1, 2, 3));
  EXPECT_NEAR(densities.model.gyro.bias_instability[2] / densities.model.gyro.bias_instability[0], 4, 1e-12);
  ASSERT_EQ(densities.notes.size(), 1U);
  const auto samples = sensor_file::read_sensor_file(file("i.yaml", text), {.rate_hz = 100});
  expect_near(samples.model.gyro.white[2], 0.3);
  EXPECT_EQ(samples.model.gyro.bias_instability, densities.model.gyro.bias_instability);  // the minimum of the curve
}

}  // namespace
}  // namespace gyrobudget::app_tests
