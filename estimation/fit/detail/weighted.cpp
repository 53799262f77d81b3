// SPDX-License-Identifier: MIT
#include "weighted.h"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace gyrobudget::inline v0::fit {
namespace {

constexpr int kMostSteps = 200;
constexpr int kMostHalvings = 30;
constexpr double kTrusted = 1e-10;  // squared relative change of the curve below which a step is taken unseen
constexpr double kSettled = 1e-26;  // and below which it is the last

// Covariance of min |W (s - A theta)|^2 over the coefficients above zero, where s varies as S.
WeightedSolution with_covariance(const LinearModel& model, GlsSolution solution, const Eigen::VectorXd& W) {
  const Eigen::Index p = solution.theta.size();
  WeightedSolution result{std::move(solution), Eigen::MatrixXd::Zero(p, p)};
  GlsSolution& s = result.solution;
  if (!s.converged || s.theta.maxCoeff() <= 0) return result;
  s.S = model.covariance(s.theta);
  // The bound is ignored: a coefficient at zero still has the scatter that its limit needs.
  const Eigen::MatrixXd WA = W.asDiagonal() * model.A;
  const Eigen::VectorXd length = WA.colwise().norm();
  const Eigen::MatrixXd unit = WA * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd H =
      length.cwiseInverse().asDiagonal() * unit.completeOrthogonalDecomposition().pseudoInverse() * W.asDiagonal();
  result.covariance = H * s.S * H.transpose();
  return result;
}

double log_squares(const LinearModel& model, const Eigen::VectorXd& theta) {
  const Eigen::ArrayXd fitted = model.A * theta;
  if (!(fitted.minCoeff() > 0)) return std::numeric_limits<double>::infinity();
  return (model.s.array() / fitted).log().square().sum();
}

}  // namespace

WeightedSolution weigh_by_variance(const LinearModel& model) {
  LinearModel independent = model;
  independent.covariance = [&](const Eigen::VectorXd& theta) -> Eigen::MatrixXd {
    return model.covariance(theta).diagonal().asDiagonal();
  };
  GlsSolution solution = iterate_gls(independent);
  const Eigen::VectorXd W =
      solution.S.size() == 0 ? model.s : Eigen::VectorXd(solution.S.diagonal().cwiseSqrt().cwiseInverse());
  return with_covariance(model, std::move(solution), W);
}

WeightedSolution fit_logarithms(const LinearModel& whole) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < whole.s.size(); ++i) {
    if (whole.s(i) > 0) rows.push_back(i);
  }
  LinearModel model = whole;
  model.A = whole.A(rows, Eigen::all);
  model.s = whole.s(rows);
  model.covariance = [&](const Eigen::VectorXd& theta) -> Eigen::MatrixXd {
    return whole.covariance(theta)(rows, rows);
  };
  GlsSolution solution;
  const Eigen::VectorXd relative = model.s.cwiseInverse();
  solution.theta = nonnegative_least_squares(relative.asDiagonal() * model.A, Eigen::VectorXd::Ones(model.s.size()));
  double squares = log_squares(model, solution.theta);
  while (solution.iterations < kMostSteps && !solution.converged && std::isfinite(squares)) {
    ++solution.iterations;
    // ln(A theta) about the last theta: ln f + (A theta - f)/f.
    const Eigen::VectorXd fitted = model.A * solution.theta;
    const Eigen::VectorXd inverse = fitted.cwiseInverse();
    const Eigen::VectorXd target = (model.s.array() / fitted.array()).log() + 1;
    const Eigen::VectorXd step = nonnegative_least_squares(inverse.asDiagonal() * model.A, target) - solution.theta;
    const double change = (model.A * step).cwiseProduct(inverse).squaredNorm();
    double part = 1, there = log_squares(model, solution.theta + step);
    const bool trusted = change < kTrusted;  // the sum of squares is rounded more coarsely than the step
    for (int i = 0; i < kMostHalvings && !trusted && !(there < squares); ++i) {
      part *= 0.5;
      there = log_squares(model, solution.theta + part * step);
    }
    const bool better = trusted || there < squares;
    solution.converged = change < kSettled || !better;
    if (better) solution.theta += part * step, squares = there;
  }
  const Eigen::VectorXd W = (model.A * solution.theta).cwiseInverse();
  WeightedSolution result = with_covariance(model, std::move(solution), W);
  if (result.solution.S.size() > 0) result.solution.S = whole.covariance(result.solution.theta);
  return result;
}

}  // namespace gyrobudget::inline v0::fit
