// SPDX-License-Identifier: MIT
// simulate --trajectory: logs of a whole IMU in motion, and the truth beside them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "program.h"

namespace gyrobudget::tests {
namespace {

constexpr const char* kIdeal = "name: ideal\ngyro:\naccelerometer:\n";
constexpr const char* kSensor =
    "name: s\ngyro: {arw: 0.1 deg/sqrt(h), bias_instability: 1 deg/h, turn_on_bias: 3 deg/h, range: 0.5 deg/s}\n"
    "accelerometer: {vrw: 0.05 m/s/sqrt(h), vibration_rectification: 100 ug/g^2}\n";

/// Rows of a CSV behind its comments and its header.
std::vector<std::vector<double>> rows(const std::string& text) {
  std::vector<std::vector<double>> result;
  std::istringstream lines(text);
  bool header = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    if (!header) {
      std::istringstream cells(line);
      result.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) result.back().push_back(std::stod(cell));
    }
    header = false;
  }
  return result;
}

class SimulateImu : public testing::Test {
 protected:
  std::string simulate(const std::string& sensor, const std::string& options) const {
    const Outcome run =
        gyrobudget_run("simulate " + scratch_.file("sensor.yaml", sensor) + " -q --trajectory " + options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  }
  Scratch scratch_;
};

TEST_F(SimulateImu, AnIdealOneAtRestSensesEarth) {
  const std::string log = simulate(kIdeal, "static:latitude=0,duration=1 --rate 10");
  EXPECT_NE(log.find("time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2)"), std::string::npos);
  const auto found = rows(log);
  ASSERT_EQ(found.size(), 10U);
  EXPECT_EQ(found.front()[0], 0.1);  // the end of its interval
  EXPECT_EQ(found.back()[0], 1);
  for (const auto& row : found) {
    EXPECT_NEAR(row[1], 7292115e-11, 1e-18);   // north
    EXPECT_NEAR(row[6], -9.7803253359, 1e-9);  // up
  }
}

TEST_F(SimulateImu, IncrementsAreRatesTimesTheInterval) {
  const std::string flight = "cruise:duration=4,turn_acceleration=2 --rate 50 ";
  const auto rates = rows(simulate(kSensor, flight + "--unit deg/s"));
  const auto increments = rows(simulate(kSensor, flight + "--unit deg --input increment"));
  ASSERT_EQ(rates.size(), 200U);
  ASSERT_EQ(increments.size(), 200U);
  for (std::size_t k = 0; k < rates.size(); ++k) {
    for (std::size_t c = 1; c < 7; ++c) EXPECT_NEAR(increments[k][c] * 50, rates[k][c], 1e-14 + 1e-15 * 10);
  }
}

TEST_F(SimulateImu, SameBytesWhateverTheThreadsAndTheStart) {
  const std::string flight = "climb:duration=30 --rate 1000 --vibration '2 g' ";
  const std::string whole = simulate(kSensor, flight);
  EXPECT_EQ(simulate(kSensor, flight + "--threads 1"), whole);
  const std::string tail = simulate(kSensor, flight + "--skip 20s");
  const std::string rest = tail.substr(tail.find("\n20.001,"));
  EXPECT_EQ(whole.substr(whole.find("\n20.001,")), rest);
  EXPECT_NE(simulate(kSensor, flight + "--run 1"), whole);
  EXPECT_NE(simulate(kSensor, flight + "--seed 2"), whole);
  EXPECT_NE(simulate(kSensor, "climb:duration=30 --rate 1000"), whole);
}

TEST_F(SimulateImu, TruthIsATrajectoryAgain) {
  const std::string truth = scratch_.path("truth.csv");
  const std::string flight = "'cruise:duration=5,height=3000' --rate 20 ";
  const auto direct = rows(simulate(kIdeal, flight + "--truth " + truth));
  for (const std::string form : {"quaternion", "euler"}) {
    (void)simulate(kIdeal, flight + "--attitude " + form + " --duration 4s --truth " + truth);
    const auto again = rows(simulate(kIdeal, truth + " --rate 20"));
    ASSERT_EQ(again.size(), 80U);
    for (std::size_t k = 0; k < again.size(); ++k) {
      // Splines through positions of 1 nm, 50 ms apart: 2e-6 m/s^2 between rounded samples.
      for (std::size_t c = 1; c < 7; ++c) ASSERT_NEAR(again[k][c], direct[k][c], c < 4 ? 1e-11 : 1e-5) << k << c;
    }
  }
}

// An IMU off the centre of mass senses w' x r + w x (w x r) more, by the differences of its own gyros; a spin of 1
// rad/s at 2 m is 2 m/s^2.
TEST_F(SimulateImu, AnIMUOffTheCentreOfMassSensesItsTurning) {
  const std::string spin = "static:latitude=0,duration=1,spin_z=57.29577951308232 --rate 100";
  const auto at_centre = rows(simulate(kIdeal, spin));
  const auto forward = rows(simulate(std::string("lever_arm: [-2 m, 0 m, 0 m]\n") + kIdeal, spin));
  constexpr double kEarth = 1e-7;  // squares of Earth's rate
  for (std::size_t k = 0; k < forward.size(); ++k) EXPECT_NEAR(forward[k][4] - at_centre[k][4], -2, kEarth);

  const std::string turns = "cruise:duration=10,turn_acceleration=4,turn_period=8 --rate 200";
  const auto centre = rows(simulate(kIdeal, turns));
  const auto right = rows(simulate(std::string("lever_arm: [0 m, -1 m, 0 m]\n") + kIdeal, turns));
  constexpr double kDifference = 1e-5;  // of gyro samples 5 ms apart
  double largest = 0;
  for (std::size_t k = 1; k + 1 < right.size(); ++k) {
    const double wx = centre[k][1], wy = centre[k][2], wz = centre[k][3];
    const double ax = (centre[k + 1][1] - centre[k - 1][1]) * 100, az = (centre[k + 1][3] - centre[k - 1][3]) * 100;
    const double expected[3] = {-az + wx * wy, -wx * wx - wz * wz, ax + wy * wz};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(right[k][4 + i] - centre[k][4 + i], expected[i], kDifference) << k;
      largest = std::max(largest, std::abs(expected[i]));
    }
  }
  EXPECT_GT(largest, 100 * kDifference);
}

TEST_F(SimulateImu, SaysWhatIsSpecial) {
  const std::string sensor =
      scratch_.file("s.yaml", std::string("lever_arm: [1 m, 0 m, 0 m]\ngyro: {range: 1 deg/h}\n"));
  const Outcome run =
      gyrobudget_run("simulate " + sensor + " --trajectory static:duration=1 -o " + scratch_.path("log.csv"));
  EXPECT_EQ(run.exit_code, 0);
  for (const char* part : {"gyro out of range in 100, 0 and 0 samples", "the IMU is at minus its lever_arm",
                           "an ideal one", "simulated 100 samples of an IMU at 100 Hz"}) {
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  }
}

TEST_F(SimulateImu, WrongUsageIsSaid) {
  const std::string sensor = scratch_.file("sensor.yaml", kSensor);
  const auto expect = [&](const std::string& options, int code, const std::string& part) {
    const Outcome run = gyrobudget_run("simulate " + sensor + " " + options);
    EXPECT_EQ(run.exit_code, code) << options << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_TRUE(run.out.empty()) << options;
  };
  expect("", 2, "needs --duration");
  expect("--duration 1s --truth t.csv", 2, "--truth belongs to --trajectory");
  expect("--trajectory cruise --model 1", 2, "--model");
  expect("--trajectory cruise --axes x", 2, "--axes");
  expect("--trajectory ascent:duration=1e12", 2, "86400");
  expect("--trajectory cruise --attitude euler", 2, "--attitude");
  expect("--trajectory cruise --unit deg", 2, "not a unit of angular rate");
  expect("--trajectory cruise --input increment --unit deg/s", 2, "not a unit of angle");
  expect("--trajectory cruise:duration=10 --duration 20s", 2, "ends at 10 s");
  expect("--trajectory cruise:duration=10 --skip 10s", 2, "leaves none");
  expect("--trajectory cruise:sped=10", 2, "did you mean 'speed'?");
  expect("--trajectory nowhere.csv", 3, "no such file");
  expect("--trajectory " + sensor, 3, "sensor.yaml");
  expect("--trajectory cruise --truth " + sensor, 2, "that is the input");
}

}  // namespace
}  // namespace gyrobudget::tests
