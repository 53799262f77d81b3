// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "deviation.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::allan {

/// Covariance matrix of the overlapped Allan variances s_i at several factors m_i of one record that is a Gaussian sum
/// of processes, exact in the sense below, as a quadratic form in the squared coefficients theta_a (N^2, B^2, ...):
///
///   E[s_i] = sum_a A(i, a) theta_a,    S(i, j) = cov(s_i, s_j) = sum_ab theta_a theta_b G_ab(i, j)
///   G_ab(i, j) = 2 / (M_i M_j) sum_u n(u) C_a(u) C_b(u)
///
/// where C_a(u) is the covariance of two terms whose triples have their middles u samples apart (a fourth difference of
/// noise::phase_covariance), n(u) counts such pairs of terms, and M_i is the number of terms. A and G depend on the
/// record's length, the factors and the kinds of processes only, not on the data nor on the coefficients: make one of
/// these for a log and share it among axes and iterations. Thread-safe once made.
///
/// Rate ramp and sinusoid are means: they have no variance of their own but multiply that of the noise,
/// cov += 4/(M_i M_j) sum n(u) mu_i mu_j C(u), linear in R^2 or A^2; the sinusoid is averaged over its phase.
///
/// Error of G against the direct sum over all lags, relative to sqrt(S_ii S_jj): below 1e-9, for any n up to 1e9 and
/// any factors. Two exceptions: terms with a sinusoid that makes over 500 cycles in the record, 1 %; and records with
/// gaps, where n(u) is interpolated between lags at which it is counted and C is scaled by the change of the
/// expectation: 1 % where at least half of the triples count, 8 % where fewer do.
///
/// On octave factors up to n/2, S has a Cholesky factor for every mix with at least one random process, from n = 16
/// to 1e9. Dense grids make it singular.
///
/// Cost: about 1000 kernel evaluations per pair of factors and process, in parallel over pairs: a few milliseconds for
/// N, B and K on the 21 octaves of 3.6e6 samples.
class CurveCovariance {
 public:
  /// @param samples length of the record, missing ones included.
  /// @param factors averaging factors, 1 <= m <= n/2, in any order.
  /// @param dt sample interval [s].
  /// @param processes kinds of processes: their coefficients are ignored, correlation times and frequencies are not.
  /// @param form that of the curve.
  /// @param mask that of the curve; used during construction only.
  /// Factors without any term (all lost to gaps; n/2 in Form::ieee) have NaN in their rows and columns.
  /// @throws std::invalid_argument for a factor out of range, a dt or correlation time that is not positive and
  /// finite, or a mask of another length.
  CurveCovariance(std::int64_t samples, std::vector<std::int64_t> factors, double dt,
                  std::vector<noise::Process> processes, Form form = Form::full, const Mask* mask = nullptr);

  /// S for theta_a = coefficient_a^2 [signal^4]; symmetric.
  /// @throws std::invalid_argument where theta has another size than processes().
  [[nodiscard]] Eigen::MatrixXd operator()(const Eigen::VectorXd& theta) const;

  /// A, corrected for gaps: rows are factors, columns processes.
  [[nodiscard]] const Eigen::MatrixXd& expectation() const { return expectation_; }
  [[nodiscard]] const std::vector<std::int64_t>& factors() const { return factors_; }
  /// The processes, each with coefficient 1.
  [[nodiscard]] const std::vector<noise::Process>& processes() const { return processes_; }

  /// The same for some of the factors and some of the processes, by index, without computing anything anew.
  /// @throws std::out_of_range for an index that is none.
  [[nodiscard]] CurveCovariance subset(std::span<const std::size_t> factor_indices,
                                       std::span<const std::size_t> process_indices) const;

 private:
  CurveCovariance() = default;
  [[nodiscard]] std::size_t entry(std::size_t a, std::size_t b) const;

  std::vector<std::int64_t> factors_;
  std::vector<noise::Process> processes_;
  Eigen::MatrixXd expectation_;
  std::vector<Eigen::MatrixXd> G_;  ///< upper triangle of (a, b), row by row
};

}  // namespace gyrobudget::inline v0::allan
