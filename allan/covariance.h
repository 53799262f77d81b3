// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::allan {

/// Exact covariance matrix of overlapped Allan variances at several factors, as a quadratic form in the squared
/// coefficients theta_a of a sum of processes: S = sum_ab theta_a theta_b G_ab (theory section 5). The matrices G
/// depend on record length, factors and processes only; compute once, share among axes and iterations.
class CurveCovariance {
 public:
  /// @param processes with unit coefficients (their coefficients are ignored).
  CurveCovariance(std::int64_t samples, std::vector<std::int64_t> factors, double dt,
                  std::vector<noise::Process> processes, Form = Form::full, const Mask* = nullptr);

  /// S for theta_a = coefficient^2, in (signal^2)^2.
  [[nodiscard]] Eigen::MatrixXd operator()(const Eigen::VectorXd& theta) const;
  /// A with E[variance_i] = sum_a A(i, a) theta_a (mask corrected).
  [[nodiscard]] const Eigen::MatrixXd& expectation() const;
  [[nodiscard]] const std::vector<std::int64_t>& factors() const;
  [[nodiscard]] const std::vector<noise::Process>& processes() const;
  /// The same for a subset of the factors and of the processes (indices).
  [[nodiscard]] CurveCovariance subset(std::span<const std::size_t> factor_indices,
                                       std::span<const std::size_t> process_indices) const;

 private:
  std::vector<std::int64_t> factors_;
  std::vector<noise::Process> processes_;
  Eigen::MatrixXd expectation_;
  std::vector<Eigen::MatrixXd> G_;  ///< upper triangle of (a, b), row by row
};

}  // namespace gyrobudget::inline v0::allan
