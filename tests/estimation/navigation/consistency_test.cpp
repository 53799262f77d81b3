// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "consistent_runs.h"

using namespace gyrobudget;  // NOLINT
using consistency::Verdict;
using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(Consistency, NEESCountsTheDirectionsThatHaveVariance) {
  Matrix3d P = Matrix3d::Zero();
  P.diagonal() << 4, 1e-12, 1e8;
  EXPECT_NEAR(navigation::nees(Vector3d(2, 3e-6, 1e4), P), 1 + 9 + 1, 1e-12);
  // A sum of two that is known: its direction does not count.
  P << 1, -1, 0, -1, 1, 0, 0, 0, 1;
  EXPECT_NEAR(navigation::nees(Vector3d(1, -1, 0), P), 1, 1e-12);
  EXPECT_EQ(navigation::nees(Vector3d(1, 1, 0), P), std::numeric_limits<double>::infinity());
  P.setZero();
  EXPECT_EQ(navigation::nees(Vector3d::Zero(), P), 0);
  EXPECT_EQ(navigation::nees(Vector3d(1e-9, 0, 0), P), std::numeric_limits<double>::infinity());
  EXPECT_THROW((void)navigation::nees(Eigen::Vector2d::Zero(), P), std::invalid_argument);
}

// Quantiles of tables of chi-square: 95 % of 2 dof 0.0506 to 7.378; of 200 dof 162.73 to 241.06.
TEST(Consistency, BandsAreThoseOfTables) {
  const auto one = navigation::chi_square_mean_band(2, 1);
  EXPECT_NEAR(one.lower, 0.0506, 1e-4);
  EXPECT_NEAR(one.upper, 7.378, 1e-3);
  const auto hundred = navigation::chi_square_mean_band(2, 100);
  EXPECT_NEAR(hundred.lower, 1.6273, 1e-4);
  EXPECT_NEAR(hundred.upper, 2.4106, 1e-4);
  EXPECT_NEAR(navigation::sigma_ratio_band(200).upper, std::sqrt(241.06 / 200), 1e-4);
  EXPECT_THROW((void)navigation::chi_square_mean_band(0, 1), std::invalid_argument);
  EXPECT_THROW((void)navigation::chi_square_mean_band(1, 1, 1), std::invalid_argument);
}

namespace {

constexpr int kRuns = 24;

// False alarm of the mean's test: 4.5 standard errors of `kRuns` run means, 2e-4 by Student's distribution of 23 dof.
void expect_mean(const std::vector<double>& of_run, double expected) {
  const double mean = Verdict::mean(of_run);
  double variance = 0;
  for (const double x : of_run) variance += (x - mean) * (x - mean) / static_cast<double>(of_run.size() - 1);
  EXPECT_NEAR(mean, expected, 4.5 * std::sqrt(variance / static_cast<double>(of_run.size())));
}

}  // namespace

// 600 s with GNSS and a minute without, a truth with exact 1/f, random walk and turn-on bias: errors are as large as
// the filter says, in navigation and in the bias itself.
TEST(Consistency, OfAFilterWithThreeFlickerStates) {
  const Verdict v = consistency::fly({.sensor = consistency::mems(), .flicker_states = 3, .runs = kRuns}, 1);
  expect_mean(v.of_run, 9);
  EXPECT_GT(Verdict::inside(v.navigation, 9, kRuns), 0.9);
  EXPECT_GT(Verdict::inside(v.bias, 1, 3 * kRuns), 0.9);
  constexpr double kNis = 0.06;  // 4.5 s.e. of 24 x 540 fixes of 6 rows: sqrt(12/12960) = 0.03
  EXPECT_NEAR(Verdict::mean(v.nis), 6, 2 * kNis);
}

// Without states for 1/f the bias is far off, and NIS does not see it.
TEST(Consistency, IsLostWithoutFlickerStatesAndNISIsBlindToIt) {
  const Verdict v = consistency::fly({.sensor = consistency::mems(), .flicker_states = 0, .runs = kRuns}, 1);
  EXPECT_LT(Verdict::inside(v.bias, 1, 3 * kRuns), 0.5);
  EXPECT_GT(Verdict::mean(v.bias), 1.5);
  EXPECT_NEAR(Verdict::mean(v.nis), 6, 0.12);
}

// Two directions of three hold variance: the sum of the first two axes has none of first order.
TEST(Consistency, NEESOfFirstOrderSaysWhatItLeavesOut) {
  Matrix3d P;
  P << 4, -4, 0, -4, 4, 0, 0, 0, 9;
  const navigation::FirstOrderNees nees(P, 1e-6);
  EXPECT_EQ(nees.dof(), 2);
  ASSERT_EQ(nees.left_out().size(), 1U);
  const auto& direction = nees.left_out()[0];
  EXPECT_NEAR(std::abs(direction.weights.dot(Vector3d(1, 1, 0))), std::sqrt(2), 1e-12);
  // Half of (2, -2) over variance 2 along (1, -1)/sqrt(2), in sigmas of 2; one sigma of the third; and an error of
  // second order that does not count.
  const Vector3d error(2 + 1e-3, -2 + 1e-3, 3);
  EXPECT_NEAR(nees(error), 1 + 1, 1e-12);
  EXPECT_NEAR(std::abs(nees.along(direction, error)), std::sqrt(2) * 1e-3 / 2, 1e-12);
  // An axis without variance is a direction of its own, in its own unit.
  P.setZero();
  P(0, 0) = 4;
  const navigation::FirstOrderNees one(P, 0);
  EXPECT_EQ(one.dof(), 1);
  ASSERT_EQ(one.left_out().size(), 2U);
  EXPECT_NEAR(one(Vector3d(2, 1e-9, 5)), 1, 1e-12);
  EXPECT_NEAR(
      std::hypot(one.along(one.left_out()[0], Vector3d(2, 3, 4)), one.along(one.left_out()[1], Vector3d(2, 3, 4))), 5,
      1e-12);
  EXPECT_THROW((void)navigation::FirstOrderNees(P, 1), std::invalid_argument);
  EXPECT_THROW((void)one(Eigen::Vector2d::Zero()), std::invalid_argument);
}
