// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/simulated_fixes.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

using namespace gyrobudget;  // NOLINT
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::Aid;

namespace {

earth::Trajectory drive() { return earth::cruise({.speed = 30, .turn_acceleration = 2, .duration = 1000}); }

Aid aid(Aid::Kind kind, double sigma) {
  Aid a;
  a.name = "test";
  a.kind = kind;
  a.sigma.setConstant(sigma);
  return a;
}

// East, north, up error of a position fix of an antenna at the IMU.
Vector3d position_error(const navigation::Fix& fix, const earth::Trajectory& path) {
  const auto truth = path.at(static_cast<double>(fix.stamp) * 1e-9);
  const auto at = earth::to_geodetic(truth.pose.p_eb_e);
  return earth::C_e_enu(at.latitude, at.longitude).transpose() * (fix.value - truth.pose.p_eb_e);
}

}  // namespace

TEST(SimulatedFixes, HaveTheWhiteNoiseTheyAreSaidToHave) {
  const auto path = drive();
  Aid gnss = aid(Aid::Kind::position, 1);
  gnss.sigma = {1, 2, 4};
  const auto fixes = simulated_fixes(gnss, 0, path, 1, 0);
  ASSERT_EQ(fixes.size(), 1001U);
  Vector3d sum = Vector3d::Zero();
  for (const auto& fix : fixes) sum += position_error(fix, path).cwiseAbs2();
  constexpr double kSpread = 5 * 0.0447;  // of a mean of 1001 squares: sqrt(2/1001); false alarm 1e-6
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sum[i] / 1001 / (gnss.sigma[i] * gnss.sigma[i]), 1, kSpread);
}

// Bias, lever arm and time tag are one draw a run: their spread over runs is what was asked for.
TEST(SimulatedFixes, DrawConstantErrorsOnceARun) {
  const auto path = drive();
  Aid gnss = aid(Aid::Kind::position, 1e-9);
  gnss.bias_sigma.setConstant(3);
  double sum = 0;
  constexpr int kRuns = 400;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    gnss.valid = {0, 2};
    const auto fixes = simulated_fixes(gnss, 0, path, 1, run);
    const Vector3d first = position_error(fixes[0], path), second = position_error(fixes[1], path);
    EXPECT_LT((first - second).norm(), 1e-6);
    sum += first.squaredNorm() / 3;
  }
  EXPECT_NEAR(sum / kRuns, 9, 9 * 5 * std::sqrt(2.0 / (3 * kRuns)));
}

TEST(SimulatedFixes, StampAsTheAidDoes) {
  const auto path = drive();
  Aid gnss = aid(Aid::Kind::position, 1e-9);
  gnss.time_tag = -0.25;  // stamps are late: this is added to them
  const auto fixes = simulated_fixes(gnss, 0, path, 1, 0);
  EXPECT_EQ(fixes[4].stamp, 4'250'000'000);
  EXPECT_LT((fixes[4].value - path.at(4).pose.p_eb_e).norm(), 1e-6);
}

TEST(SimulatedFixes, KeepToValidityAndOutages) {
  const auto path = drive();
  Aid barometer = aid(Aid::Kind::height, 1);
  barometer.rate = 2;
  barometer.valid = {10, 20};
  barometer.outages = {{12, 15}};
  const auto fixes = simulated_fixes(barometer, 0, path, 1, 0);
  EXPECT_EQ(fixes.size(), 21U - 7U);
  EXPECT_TRUE(simulated_fixes(aid(Aid::Kind::rest, 1), 0, path, 1, 0).empty());
}

TEST(SimulatedFixes, MeasureVelocityAndAttitudeInTheirAxes) {
  const auto path = drive();
  Aid velocity = aid(Aid::Kind::velocity, 1e-12);
  velocity.lever_arm = {0, 2, 0};
  const auto truth = path.at(7);
  const auto at = earth::to_geodetic(truth.pose.p_eb_e);
  const Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude), C_eb = truth.pose.q_eb.toRotationMatrix();
  const Vector3d w_eb_b = truth.sensed.w_ib_b - C_eb.transpose() * Vector3d(0, 0, earth::wgs84::kEarthRate);
  const Vector3d expected = C_en.transpose() * (truth.pose.v_eb_e + C_eb * w_eb_b.cross(velocity.lever_arm));
  EXPECT_LT((simulated_fixes(velocity, 0, path, 1, 0)[7].value - expected).norm(), 1e-9);
  const auto attitude = simulated_fixes(aid(Aid::Kind::attitude, 1e-12), 0, path, 1, 0)[7];
  EXPECT_LT(earth::log_rotation(Eigen::Quaterniond(C_en) * attitude.q_nb * truth.pose.q_eb.conjugate()).norm(), 1e-10);
}

TEST(SimulatedFixes, AreTheSameForASeedAndARun) {
  const auto path = drive();
  const Aid gnss = aid(Aid::Kind::position, 1);
  const auto a = simulated_fixes(gnss, 0, path, 1, 2), b = simulated_fixes(gnss, 0, path, 1, 2);
  EXPECT_EQ(a[3].value, b[3].value);
  EXPECT_NE(a[3].value, simulated_fixes(gnss, 0, path, 2, 2)[3].value);
  EXPECT_NE(a[3].value, simulated_fixes(gnss, 0, path, 1, 3)[3].value);
  EXPECT_NE(a[3].value, simulated_fixes(gnss, 1, path, 1, 2)[3].value);
}
