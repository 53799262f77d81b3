// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>

#include "profile.h"
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {

/// A linear model of variances with a covariance that depends on the answer: s = A theta + D gamma + noise of
/// covariance S(theta), theta >= 0, gamma of any sign. Rows are taus, columns are terms.
struct LinearModel {
  Eigen::MatrixXd A;
  Eigen::MatrixXd D;  ///< no columns where there is nothing beside the terms
  Eigen::VectorXd s;
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& theta)> covariance;
};

/// A coefficient held at a value.
struct Held {
  Eigen::Index index = 0;
  double value = 0;
};

/// A and s divided by the root of S, and without what D can take up: least squares in theta alone.
struct Whitened {
  Eigen::MatrixXd A;
  Eigen::VectorXd s;
};
/// @throws std::invalid_argument where S has no Cholesky factor.
[[nodiscard]] Whitened whiten(const LinearModel&, const Eigen::MatrixXd& S);
[[nodiscard]] Whitened whiten(const LinearModel&, const Eigen::LLT<Eigen::MatrixXd>& factor);

struct GlsSolution {
  Eigen::VectorXd theta;
  Eigen::MatrixXd S;  ///< covariance at theta; empty where nothing in theta scatters: zero, or ramps and lines alone
  double chi2 = 0;    ///< Q(theta; S)
  int iterations = 0;
  bool converged = false;
};

/// min |W (s - A theta)|^2 over theta >= 0, by active set (Lawson & Hanson 1974) with QR inner solves: exact, no start
/// values. `held` fixes one coefficient.
[[nodiscard]] Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& WA, const Eigen::VectorXd& Ws,
                                                        std::optional<Held> held = {});

/// Fixed point of reweighting: theta minimises Q(.; S(theta)).
[[nodiscard]] GlsSolution iterate_gls(const LinearModel&, std::optional<Held> held = {},
                                      const Eigen::VectorXd* start = nullptr);

/// T(v) = Q(th_v; S(th_v)) - min_th Q(th; S(th_v)): how much worse the curve is explained with the coefficient held,
/// both measured with the covariance of the held fit. Infinite where the held fit has no covariance.
[[nodiscard]] double profile_test(const LinearModel&, Held held, const Eigen::VectorXd& start);

/// What D takes up at theta, best by S: gamma.
[[nodiscard]] Eigen::VectorXd free_part(const LinearModel&, const Eigen::VectorXd& theta, const Eigen::MatrixXd& S);

/// {v : T(v) <= cut} around the estimate.
[[nodiscard]] ProfileInterval profile_interval(const LinearModel&, Eigen::Index index, const GlsSolution& best,
                                               double standard_deviation, double cut);

}  // namespace gyrobudget::inline v0::fit
