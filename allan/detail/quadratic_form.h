// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/estimator.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace gyrobudget::inline v0::allan::detail {

/// The matrix A of an estimate s = x^T A x of n + 1 phases in units of dt: dense, for short records. Every
/// term is a sum of squares of linear filters of the phases; A is their Gram matrix, scaled as family_scale
/// says (time deviations as the modified ones of the same name).
[[nodiscard]] Eigen::MatrixXd estimator_matrix(Estimator, std::int64_t samples, std::int64_t m, std::int64_t stride);

/// First two moments of an estimate.
struct Moments {
  double expectation = 0;
  double variance = 0;
  [[nodiscard]] double edf() const { return 2 * expectation * expectation / variance; }
};

/// Of s = x^T A x for the Gaussian phases of a sum of processes: tr(A R) and 2 tr(A R A R) with the
/// generalised phase covariance R, and mu^T A mu and 4 mu^T A R A mu of a rate ramp. A must annihilate
/// constants and straight lines, as every estimator of stability does: then what R leaves undefined drops
/// out. A sinusoid counts as if it were noise.
[[nodiscard]] Moments moments(const Eigen::MatrixXd& A, std::span<const noise::Process> mix, double dt);

/// The expectation alone, in a fraction of the time.
[[nodiscard]] double expectation(const Eigen::MatrixXd& A, std::span<const noise::Process> mix, double dt);

/// Expectation of the one term of the total variance (its square over 2 m^2 dt^2) whose middle is phase i of
/// 0 .. n.
[[nodiscard]] double reflected_expectation(std::span<const noise::Process> mix, std::int64_t samples, std::int64_t m,
                                           std::int64_t i, double dt);

}  // namespace gyrobudget::inline v0::allan::detail
