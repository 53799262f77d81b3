// SPDX-License-Identifier: MIT
#include "gls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace gyrobudget::inline v0::fit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostReweightings = 200;
constexpr int kFullSteps = 8;  // then each is lengthened or shortened by what the one before it did
constexpr double kShortest = 0.05, kLongest = 10;
constexpr int kDampAfter = 60;         // what still cycles between active sets is broken by averaging
constexpr double kFixedPoint = 1e-12;  // relative change of the modelled variances

using Columns = std::vector<Eigen::Index>;

// Least squares on the chosen columns, zero elsewhere.
Eigen::VectorXd solve_on(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Columns& columns) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(A.cols());
  if (columns.empty()) return x;
  Eigen::MatrixXd chosen(A.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) chosen.col(static_cast<Eigen::Index>(j)) = A.col(columns[j]);
  const Eigen::VectorXd y = chosen.householderQr().solve(b);
  for (std::size_t j = 0; j < columns.size(); ++j) x(columns[j]) = y(static_cast<Eigen::Index>(j));
  return x;
}

// Lawson & Hanson's step: from feasible x towards z until the first coefficient reaches zero, which then leaves.
void step_to_boundary(Eigen::VectorXd& x, const Eigen::VectorXd& z, Columns& passive) {
  double alpha = 1;
  Eigen::Index limiting = passive.front();
  for (const auto j : passive) {
    if (z(j) > 0) continue;
    const double reach = x(j) > 0 ? x(j) / (x(j) - z(j)) : 0;
    if (reach <= alpha) alpha = reach, limiting = j;
  }
  x = (x + alpha * (z - x)).cwiseMax(0);
  x(limiting) = 0;
  std::erase(passive, limiting);
}

// Columns have unit length; `free` lists those that may move.
Eigen::VectorXd active_set(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Columns& free) {
  Eigen::VectorXd x = solve_on(A, b, free);
  if (x.minCoeff() >= 0) return x;  // the usual case: no bound is active
  x.setZero();
  Columns passive;
  const double tolerance = 1e-14 * b.norm();
  for (std::size_t round = 0; round < 3 * free.size() + 3; ++round) {
    const Eigen::VectorXd gradient = A.transpose() * (b - A * x);
    auto best = free.end();
    for (auto j = free.begin(); j != free.end(); ++j) {
      const bool outside = std::find(passive.begin(), passive.end(), *j) == passive.end();
      if (outside && gradient(*j) > tolerance && (best == free.end() || gradient(*j) > gradient(*best))) best = j;
    }
    if (best == free.end()) break;  // Karush-Kuhn-Tucker point
    passive.push_back(*best);
    Eigen::VectorXd z = solve_on(A, b, passive);
    while (!passive.empty() && std::any_of(passive.begin(), passive.end(), [&](auto j) { return z(j) <= 0; })) {
      step_to_boundary(x, z, passive);
      z = solve_on(A, b, passive);
    }
    x = z;
  }
  return x;
}

// Leaves of A and s what the columns of D cannot take up.
void take_out(const Eigen::MatrixXd& D, Whitened& w) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(D * D.colwise().norm().cwiseInverse().asDiagonal());
  const Eigen::MatrixXd base = qr.householderQ() * Eigen::MatrixXd::Identity(D.rows(), D.cols());
  w.A -= base * (base.transpose() * w.A);
  w.s -= base * (base.transpose() * w.s);
}

// First weights: relative ones, which need no model.
Eigen::VectorXd relative_start(const LinearModel& model, std::optional<Held> held) {
  const double floor = model.s.maxCoeff() * std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  const Eigen::VectorXd weight = model.s.cwiseMax(floor).cwiseInverse();
  Whitened w{weight.asDiagonal() * model.A, weight.cwiseProduct(model.s)};
  if (model.D.cols() > 0) take_out(weight.asDiagonal() * model.D, w);
  return nonnegative_least_squares(w.A, w.s, held);
}

// Of a step, from the change `before` that led to the last one (taken by `part`) and the one that is left `now`: along
// them the iteration contracts by r, so the fixed point is 1/(1 - r) changes away. Negative beside a bound, where the
// optimum answers a step with a larger one back.
double next_part(double part, const Eigen::VectorXd& before, const Eigen::VectorXd& now) {
  const double r = before.dot(now) / std::max(before.squaredNorm(), std::numeric_limits<double>::min());
  return r < 1 ? std::clamp(part / (1 - r), kShortest, kLongest) : 1;
}

}  // namespace

Whitened whiten(const LinearModel& model, const Eigen::LLT<Eigen::MatrixXd>& factor) {
  Whitened w{factor.matrixL().solve(model.A), factor.matrixL().solve(model.s)};
  if (model.D.cols() > 0) take_out(factor.matrixL().solve(model.D), w);
  return w;
}

Whitened whiten(const LinearModel& model, const Eigen::MatrixXd& S) {
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  if (factor.info() != Eigen::Success) throw std::invalid_argument("covariance of the curve is not positive definite");
  return whiten(model, factor);
}

Eigen::VectorXd free_part(const LinearModel& model, const Eigen::VectorXd& theta, const Eigen::MatrixXd& S) {
  if (model.D.cols() == 0) return {};
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  const Eigen::MatrixXd D = factor.matrixL().solve(model.D);
  return D.householderQr().solve(factor.matrixL().solve(model.s - model.A * theta));
}

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& WA, const Eigen::VectorXd& Ws,
                                          std::optional<Held> held) {
  // Unit columns: coefficients of different units may lie 20 decades apart.
  Eigen::VectorXd length = WA.colwise().norm();
  length = (length.array() > 0).select(length, 1);
  Columns free;
  for (Eigen::Index j = 0; j < WA.cols(); ++j) {
    if (!held || j != held->index) free.push_back(j);
  }
  Eigen::VectorXd b = Ws;
  if (held) b -= WA.col(held->index) * held->value;
  Eigen::VectorXd x = active_set(WA * length.cwiseInverse().asDiagonal(), b, free).cwiseQuotient(length);
  if (held) x(held->index) = held->value;
  return x;
}

GlsSolution iterate_gls(const LinearModel& model, std::optional<Held> held, const Eigen::VectorXd* start) {
  GlsSolution solution;
  solution.theta = start ? *start : relative_start(model, held);
  if (held) solution.theta(held->index) = held->value;
  double part = 1;
  Eigen::VectorXd before;
  while (solution.iterations < kMostReweightings && !solution.converged) {
    if (solution.theta.maxCoeff() <= 0) {  // nothing allowed explains anything: no covariance to weigh with
      solution.converged = true;
      solution.S.resize(0, 0);
      solution.chi2 = kInfinity;
      return solution;
    }
    solution.S = model.covariance(solution.theta);
    if (solution.S.diagonal().maxCoeff() <= 0) {  // a ramp, a line: they have no scatter, so they explain none
      solution.converged = held.has_value();
      solution.S.resize(0, 0);
      solution.chi2 = kInfinity;
      return solution;
    }
    const Eigen::LLT<Eigen::MatrixXd> factor(solution.S);
    if (factor.info() != Eigen::Success) return solution;
    const Whitened whitened = whiten(model, factor);
    const Eigen::VectorXd optimum = nonnegative_least_squares(whitened.A, whitened.s, held);
    const Eigen::VectorXd modelled = model.A * solution.theta;
    const Eigen::VectorXd change = (model.A * optimum - modelled).cwiseQuotient(modelled.cwiseMax(1e-300));
    solution.converged = change.cwiseAbs().maxCoeff() < kFixedPoint;
    if (solution.iterations >= kFullSteps)
      part = solution.iterations < kDampAfter ? next_part(part, before, change) : 0.5;
    before = change;
    const Eigen::VectorXd step = optimum - solution.theta;
    // A lengthened step shrinks no coefficient away that the optimum holds: with all of them gone, nothing is left to
    // weigh with and no way back.
    solution.theta =
        solution.converged || part == 1 ? optimum : (solution.theta + part * step).cwiseMax(kShortest * optimum).eval();
    ++solution.iterations;
    solution.chi2 = (whitened.s - whitened.A * solution.theta).squaredNorm();
  }
  return solution;
}

double profile_test(const LinearModel& model, Held held, const Eigen::VectorXd& start) {
  const GlsSolution constrained = iterate_gls(model, held, &start);
  if (constrained.S.size() == 0) return kInfinity;
  const Eigen::LLT<Eigen::MatrixXd> factor(constrained.S);
  const Whitened w = whiten(model, factor);
  const Eigen::VectorXd best = nonnegative_least_squares(w.A, w.s);
  return std::max(0.0, (w.s - w.A * constrained.theta).squaredNorm() - (w.s - w.A * best).squaredNorm());
}

ProfileInterval profile_interval(const LinearModel& model, Eigen::Index index, const GlsSolution& best,
                                 double standard_deviation, double cut) {
  return profile_interval(
      [&](double v) {
        return profile_test(model, {index, v}, best.theta);
      },
      best.theta(index), standard_deviation, cut);
}

}  // namespace gyrobudget::inline v0::fit
