// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/detail/refine.h"

#include "gyrobudget/estimation/fit/detail/gls.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

namespace gyrobudget::fit {
namespace {

struct Problem {
  Eigen::MatrixXd A, S;
  Eigen::VectorXd s;
  [[nodiscard]] WhitenedResidual residual() const {
    const Whitened w = whiten({.A = A, .D = {}, .s = s, .covariance = {}}, S);
    return {w.A, w.s};
  }
};

Problem random_problem(std::uint64_t stream) {
  Problem p;
  p.A.resize(9, 3);
  noise::fill_normal({11, stream}, 0, {p.A.data(), 27});
  p.A = p.A.cwiseAbs();
  Eigen::MatrixXd root(9, 9);
  noise::fill_normal({11, stream}, 100, {root.data(), 81});
  p.S = root * root.transpose() + Eigen::MatrixXd::Identity(9, 9);
  p.s.resize(9);
  noise::fill_normal({11, stream}, 300, {p.s.data(), 9});
  p.s = p.A * Eigen::Vector3d(4, 9, 1) + 0.01 * p.s;
  return p;
}

// Central differences: error h^2 f'''/6 + eps f/h; the residual is quadratic, so only rounding is left.
TEST(WhitenedResidual, JacobianAgreesWithNumericalDerivative) {
  const Problem p = random_problem(1);
  const WhitenedResidual residual = p.residual();
  const Eigen::Vector3d c(1.7, 2.6, 0.9);
  const Eigen::MatrixXd J = residual.jacobian(c);
  constexpr double kStep = 1e-4, kTolerance = 1e-10;  // 100 * eps * |r| / step
  for (int j = 0; j < 3; ++j) {
    Eigen::Vector3d forward = c, backward = c;
    forward(j) += kStep;
    backward(j) -= kStep;
    const Eigen::VectorXd numerical = (residual.value(forward) - residual.value(backward)) / (2 * kStep);
    EXPECT_LT((numerical - J.col(j)).cwiseAbs().maxCoeff(), kTolerance * 1e1 * (1 + J.col(j).norm())) << "column " << j;
  }
}

TEST(Refine, CeresAgreesWithTheLinearSolution) {
  for (std::uint64_t stream = 1; stream <= 20; ++stream) {
    const Problem p = random_problem(stream);
    const Eigen::LLT<Eigen::MatrixXd> factor(p.S);
    const Eigen::VectorXd theta = nonnegative_least_squares(factor.matrixL().solve(p.A), factor.matrixL().solve(p.s));
    ASSERT_GT(theta.minCoeff(), 0);
    const WhitenedResidual residual = p.residual();
    const Refined refined = refine(residual, theta.cwiseSqrt() * 1.3);  // a start 30 % off
    ASSERT_TRUE(refined.converged);
    // Ceres ends when the cost changes by 1e-15 relative: parameters to the square root of that, about 3e-8.
    EXPECT_LT((refined.coefficients - theta.cwiseSqrt()).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(Refine, CovarianceIsTheInverseInformation) {
  const Problem p = random_problem(3);
  const WhitenedResidual residual = p.residual();
  const Refined refined = refine(residual, Eigen::Vector3d(2, 3, 1));
  const Eigen::MatrixXd J = residual.jacobian(refined.coefficients);
  const Eigen::MatrixXd expected = (J.transpose() * J).inverse();
  EXPECT_LT((refined.covariance - expected).norm(), 1e-9 * expected.norm());
}

TEST(Whiten, RefusesACovarianceThatIsNone) {
  Problem p = random_problem(4);
  p.S(0, 0) = -1;
  EXPECT_THROW((void)p.residual(), std::invalid_argument);
}

// A free column takes up whatever lies along it: theta is that of least squares over both, and no trace is left.
TEST(Whiten, TakesOutWhatAFreeColumnExplains) {
  Problem p = random_problem(5);
  Eigen::VectorXd column(9);
  noise::fill_normal({11, 5}, 500, {column.data(), 9});
  const LinearModel model{.A = p.A, .D = column, .s = p.s - 7 * column, .covariance = {}};
  const Whitened w = whiten(model, p.S);
  const Eigen::VectorXd theta = w.A.householderQr().solve(w.s);
  Eigen::MatrixXd both(9, 4);
  both << p.A, column;
  const Eigen::LLT<Eigen::MatrixXd> factor(p.S);
  const Eigen::VectorXd expected =
      Eigen::MatrixXd(factor.matrixL().solve(both)).householderQr().solve(factor.matrixL().solve(model.s));
  constexpr double kRounding = 1e-10;  // of four columns of order 1, condition below 1e4
  EXPECT_LT((theta - expected.head(3)).norm(), kRounding * expected.norm());
  EXPECT_NEAR(free_part(model, theta, p.S)(0), expected(3), kRounding * expected.norm());
}

}  // namespace
}  // namespace gyrobudget::fit
