// SPDX-License-Identifier: MIT
// The covariance of the error state, in three forms behind one interface.
//
//   form          propagation                   scalar update with gain k, row h, S = h P h^T + r
//   plain         Phi P Phi^T + Q, upper half   P - k h P
//   joseph        the same                      (I - k h) P (I - k h)^T + r k k^T
//   square_root   P = U D U^T, modified         Bierman's update; for considered states plus the rank-one
//                 weighted Gram-Schmidt of the  term (k* - k) S (k* - k)^T
//                 core, rank-one terms' noise
//
// What each keeps (tests/bench/filter_benchmark digits): worst error of a sigma, of itself, against a hundred
// digits, where variances at the start are so many times those of the fixes, 21 states; and what it costs
// (filter_benchmark).
//
//   ratio                1e4      1e8     1e12     1e16     1e20     1e28     1e32   half its digits lost at
//   plain            4.4e-13  4.5e-09  3.8e-06  3.8e-01        -        -        -   1e9
//   joseph           8.9e-16  1.3e-14  6.5e-11  3.1e-07  5.0e-03        -        -   1e15
//   square_root      6.7e-16  5.6e-16  1.0e-15  1.0e-15  2.7e-15  9.6e-11  3.0e-08   1e30
//
// Instructions a step (AVX2, with strapdown and linearisation, 2 600 of them) are 13 300 of 21 and 26 900 of
// 45 states in the first two forms, 26 400 and 108 000 in the third; an update by one row takes 0.6, 1 and
// 0.3 of Joseph's time.
//
// U is unit upper triangular. Sources: Bierman, Factorization Methods for Discrete Sequential Estimation
// (1977), chapters III, V and VI; Thornton (1976); Grewal & Andrews, Kalman Filtering (2015), chapter 7; Bucy
// & Joseph (1968).
#pragma once

#include <span>

#include "error_state.h"

namespace gyrobudget::inline v0::navigation {

/// `automatic` is Joseph's form up to the first row whose innovation variance h P h^T + r is kShrinkLimit
/// times r, where that form would begin to lose digits (table above), and square_root from there on, P being
/// factorised before that row is used.
enum class Form { plain, joseph, square_root, automatic };
inline constexpr double kShrinkLimit = 1e8;

/// One scalar measurement z = h x + v, var v = variance.
struct MeasurementRow {
  StateVector h;
  double variance = 0;  ///< positive
};

class Covariance {
 public:
  /// @throws std::invalid_argument where P is not square of `model` size, not symmetric to 1e-9 of its
  /// diagonal, not finite, or not positive semi-definite to rounding.
  Covariance(const StateMatrix& P, Form form);

  /// Never automatic: joseph until it was left.
  [[nodiscard]] Form form() const { return form_; }
  [[nodiscard]] int size() const { return size_; }

  /// P <- Phi P Phi^T + G diag(q) G^T. Allocates nothing.
  /// @throws std::invalid_argument where the sizes differ.
  void propagate(const Transition& step);

  /// P h, so that innovations i and k covary by h_i . (P h_k). @throws as update for a wrong size.
  [[nodiscard]] StateVector times(const StateVector& h) const;

  /// The update by one row: gain k = P h/(h^T P h + r), 0 for considered states, then
  /// P <- (I - k h^T) P (I - k h^T)^T + r k k^T. Returns k [state per unit of the measurement]. `considered` is empty
  /// or one flag a state. Allocates nothing.
  /// @throws std::invalid_argument for a row of another size or not finite and a variance that is not above 0.
  StateVector update(const MeasurementRow& row, std::span<const bool> considered = {});

  /// The update by one row with any gain k, (I - k h) P (I - k h)^T + r k k^T, r may be 0. Allocates nothing.
  /// @throws std::invalid_argument in square-root form, one that automatic chose included, and for sizes that
  /// differ.
  void update_with(const MeasurementRow& row, const StateVector& gain);

  /// P + more, symmetric, from one who knows that the sum is a covariance but for rounding.
  /// @throws as update_with.
  void add(const StateMatrix& more);

  /// P in full, symmetric.
  [[nodiscard]] StateMatrix matrix() const;
  /// P_ii.
  [[nodiscard]] double variance(int i) const;

 private:
  void propagate_factors(const Transition& step);
  void transform_column(const Transition& step, int k);
  StateVector update_dense(const MeasurementRow& row, std::span<const bool> considered);
  void joseph(const MeasurementRow& row, StateVector& g, const StateVector& gain);
  void symmetrise();
  void leave_for_square_root();
  StateVector update_factors(const MeasurementRow& row, std::span<const bool> considered);

  Form form_;
  bool automatic_;
  int size_;
  StateMatrix p_;  ///< P, or U with D on its diagonal; rows filled up with zeros to whole lanes
};

/// One sigma along each axis of a local frame: roots of the diagonal of C_el^T P C_el, block by block, P a covariance
/// of position, velocity and attitude in axes of e and C_el the frame's axes as columns.
struct LocalSigmas {
  Eigen::Vector3d position;  ///< [m]
  Eigen::Vector3d velocity;  ///< [m/s]
  Eigen::Vector3d attitude;  ///< rotation vector [rad]
};
[[nodiscard]] LocalSigmas local_sigmas(const CoreMatrix& covariance_e, const Eigen::Matrix3d& C_el);

}  // namespace gyrobudget::inline v0::navigation
