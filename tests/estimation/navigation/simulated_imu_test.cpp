// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/simulated_imu.h"

#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gyrobudget;  // NOLINT
using Eigen::Vector3d;
using navigation::SimulatedImu;

namespace {

constexpr double kRate = 50;

Vector3d vector(const noise::Vector3& v) { return {v[0], v[1], v[2]}; }

noise::SensorModel noisy() {
  noise::SensorModel sensor{.gyro = {.white = 1e-4, .bias_instability = 1e-5}};
  sensor.accelerometer = noise::ErrorModel{.white = 1e-3};
  return sensor;
}

}  // namespace

TEST(SimulatedImu, OfAnIdealSensorIsTheTruth) {
  const earth::Trajectory path = earth::cruise({.speed = 30, .turn_acceleration = 2, .duration = 10});
  const auto readings = SimulatedImu(path, {}, {.rate_hz = kRate}).next(500);
  const auto truth = path.increments(1 / kRate);
  ASSERT_EQ(truth.size(), 500U);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    // The interval's ends are rounded: of an angle or velocity of one interval by a few times 1e-16 of ten seconds'
    // worth.
    constexpr double kRounding = 1e-12;
    EXPECT_LT((vector(readings[k].angle) - vector(truth[k].angle)).norm(), kRounding);
    EXPECT_LT((vector(readings[k].velocity) - vector(truth[k].velocity)).norm(), kRounding);
  }
}

TEST(SimulatedImu, OffTheCentreOfASpinFeelsItPullInwards) {
  constexpr double kSpin = 10;  // rad/s
  const earth::Trajectory path = earth::stand({.spin = {0, 0, kSpin}, .duration = 2});
  noise::SensorModel off;
  off.lever_arm = {-0.5, 0, 0};  // the IMU is half a metre forward of the centre
  const auto there = SimulatedImu(path, off, {.rate_hz = kRate}).next(100);
  const auto centre = SimulatedImu(path, {}, {.rate_hz = kRate}).next(100);
  for (std::size_t k = 0; k < there.size(); ++k) {
    const Vector3d more = kRate * (vector(there[k].velocity) - vector(centre[k].velocity));
    // Earth's own turning of 7.3e-5 rad/s comes on top of the spin.
    EXPECT_NEAR(more.x(), -0.5 * kSpin * kSpin, 0.5 * 3 * kSpin * 7.3e-5);
    EXPECT_LT(more.tail(2).norm(), 0.5 * 3 * kSpin * 7.3e-5);
    EXPECT_EQ(there[k].angle, centre[k].angle);
  }
}

TEST(SimulatedImu, NumbersDoNotDependOnHowTheyAreAskedFor) {
  const earth::Trajectory path = earth::climb({.duration = 10});
  const auto imu = [&] { return SimulatedImu(path, noisy(), {.rate_hz = kRate, .seed = 3, .run = 4}); };
  const auto all = imu().next(100);
  SimulatedImu skipped = imu(), pieces = imu();
  skipped.skip(60);
  (void)pieces.next(1);
  (void)pieces.next(59);
  const auto rest = skipped.next(40), piece = pieces.next(40);
  for (std::size_t k = 0; k < 40; ++k) {
    EXPECT_EQ(rest[k].angle, all[60 + k].angle);
    EXPECT_EQ(rest[k].velocity, all[60 + k].velocity);
    EXPECT_EQ(piece[k].angle, all[60 + k].angle);
  }
  EXPECT_NE(SimulatedImu(path, noisy(), {.rate_hz = kRate, .seed = 3, .run = 5}).next(1)[0].angle, all[0].angle);
}

TEST(SimulatedImu, StandsStillBeyondTheEnd) {
  const auto readings = SimulatedImu(earth::climb({.duration = 1}), {}, {.rate_hz = kRate}).next(52);
  EXPECT_GT(vector(readings[49].velocity).norm(), 0);
  EXPECT_EQ(vector(readings[51].velocity).norm(), 0);
}
