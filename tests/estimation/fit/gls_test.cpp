// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/detail/gls.h"

#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "sensors.h"
#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace gyrobudget::fit {
namespace {

Eigen::MatrixXd random_matrix(std::uint64_t stream, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd matrix(rows, columns);
  noise::fill_normal({7, stream}, 0, {matrix.data(), static_cast<std::size_t>(matrix.size())});
  return matrix;
}

// Independent and slow: the best of the feasible least-squares solutions over all subsets of columns.
Eigen::VectorXd brute_force(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Eigen::VectorXd best = Eigen::VectorXd::Zero(A.cols());
  double least = b.squaredNorm();
  for (unsigned mask = 1; mask < 1U << A.cols(); ++mask) {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index j = 0; j < A.cols(); ++j) {
      if (mask >> j & 1U) columns.push_back(j);
    }
    const Eigen::MatrixXd chosen = A(Eigen::all, columns);
    const Eigen::VectorXd y = chosen.fullPivHouseholderQr().solve(b);
    if (y.minCoeff() < 0) continue;
    const double cost = (b - chosen * y).squaredNorm();
    if (cost < least) {
      least = cost;
      best.setZero();
      best(columns) = y;
    }
  }
  return best;
}

TEST(NonnegativeLeastSquares, IsTheBestOfAllSubsets) {
  constexpr double kTolerance = 1e-11;  // condition of random 8 x 4 matrices is below 1e3: 1e3 * eps * safety
  int bound = 0;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    const Eigen::MatrixXd A = random_matrix(2 * trial, 8, 4);
    const Eigen::VectorXd b = random_matrix(2 * trial + 1, 8, 1);
    const Eigen::VectorXd expected = brute_force(A, b);
    const Eigen::VectorXd found = nonnegative_least_squares(A, b);
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), kTolerance * (1 + expected.maxCoeff())) << "trial " << trial;
    bound += (expected.array() == 0).any();
  }
  EXPECT_GT(bound, 200) << "too few trials had an active bound to test anything";
}

TEST(NonnegativeLeastSquares, ColumnScalesOf20DecadesDoNotMatter) {
  const Eigen::MatrixXd A = random_matrix(1000, 8, 3).cwiseAbs();
  const Eigen::Vector3d truth(1, 2, 3);
  const Eigen::Vector3d scale(1e-20, 1, 1e20);
  const Eigen::VectorXd found = nonnegative_least_squares(A * scale.asDiagonal(), A * truth);
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(found(j) * scale(j), truth(j), 1e-11);
}

TEST(NonnegativeLeastSquares, HoldsWhatItIsTold) {
  const Eigen::MatrixXd A = random_matrix(1001, 8, 3);
  const Eigen::VectorXd b = random_matrix(1002, 8, 1);
  const Eigen::VectorXd found = nonnegative_least_squares(A, b, Held{1, 0.25});
  EXPECT_EQ(found(1), 0.25);
  const Eigen::MatrixXd others = A(Eigen::all, std::vector<Eigen::Index>{0, 2});
  const Eigen::VectorXd expected = brute_force(others, b - 0.25 * A.col(1));
  EXPECT_NEAR(found(0), expected(0), 1e-11);
  EXPECT_NEAR(found(2), expected(1), 1e-11);
}

LinearModel model_of(const tests::Gyro& gyro, std::int64_t samples, double dt) {
  auto covariance = std::make_shared<allan::CurveCovariance>(
      samples, allan::octave_factors(samples), dt,
      std::vector<noise::Process>{noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}});
  LinearModel model;
  model.A = covariance->expectation();
  model.s = model.A * Eigen::Vector3d(gyro.n * gyro.n, gyro.b * gyro.b, gyro.k * gyro.k);
  model.covariance = [covariance](const Eigen::VectorXd& theta) { return (*covariance)(theta); };
  return model;
}

TEST(IterateGls, ReachesAFixedPointThatDoesNotDependOnTheStart) {
  LinearModel model = model_of(tests::mems(), 36000, 1);
  Eigen::VectorXd wiggle = random_matrix(5, model.s.size(), 1);
  model.s.array() *= 1 + 0.01 * wiggle.array();
  const GlsSolution from_nothing = iterate_gls(model);
  ASSERT_TRUE(from_nothing.converged);
  const Eigen::VectorXd far = from_nothing.theta.cwiseProduct(Eigen::Vector3d(1e3, 1e-3, 1e2));
  const GlsSolution from_far = iterate_gls(model, {}, &far);
  ASSERT_TRUE(from_far.converged);
  constexpr double kFixedPointTolerance = 1e-8;  // steps end at 1e-10 of the variances; B is 100 times less seen
  for (int j = 0; j < 3; ++j) {
    EXPECT_NEAR(from_far.theta(j) / from_nothing.theta(j), 1, kFixedPointTolerance);
  }
}

TEST(ProfileTest, IsZeroAtTheEstimateAndQuadraticNearIt) {
  LinearModel model = model_of(tests::mems(), 36000, 1);
  const GlsSolution best = iterate_gls(model);
  EXPECT_NEAR(profile_test(model, {1, best.theta(1)}, best.theta), 0, 1e-10);
  const double d = 0.01 * best.theta(1);
  const double near_T = profile_test(model, {1, best.theta(1) + d}, best.theta);
  const double far_T = profile_test(model, {1, best.theta(1) + 2 * d}, best.theta);
  EXPECT_GT(near_T, 0);
  EXPECT_NEAR(far_T / near_T, 4, 0.1);  // T'' changes by its third-order share over 2 % of theta
}

TEST(ProfileInterval, EndsWhereTheTestMeetsItsCut) {
  const LinearModel model = model_of(tests::mems(), 36000, 1);
  const GlsSolution best = iterate_gls(model);
  constexpr double kCut = 3.841;
  for (Eigen::Index j = 0; j < 3; ++j) {
    const ProfileInterval interval = profile_interval(model, j, best, 0.1 * best.theta(j), kCut);
    EXPECT_LT(interval.lower, best.theta(j));
    EXPECT_GT(interval.upper, best.theta(j));
    EXPECT_NEAR(profile_test(model, {j, interval.lower}, best.theta), kCut, 1e-5);
    EXPECT_NEAR(profile_test(model, {j, interval.upper}, best.theta), kCut, 1e-5);
  }
}

TEST(ProfileTest, IsInfiniteWhereNothingElseExplainsTheCurve) {
  LinearModel model = model_of(tests::mems(), 1024, 1);
  model.A.conservativeResize(Eigen::NoChange, 1);
  const auto white = std::make_shared<allan::CurveCovariance>(1024, allan::octave_factors(1024), 1.0,
                                                              std::vector<noise::Process>{noise::White{1}});
  model.covariance = [white](const Eigen::VectorXd& theta) { return (*white)(theta); };
  const GlsSolution best = iterate_gls(model);
  EXPECT_EQ(profile_test(model, {0, 0.0}, best.theta), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace gyrobudget::fit
