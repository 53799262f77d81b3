// SPDX-License-Identifier: MIT
// The covariance of the error state, in three forms behind one interface.
//
//   form          propagation                   scalar update with gain k, row h, S = h P h^T + r
//   plain         Phi P Phi^T + Q, upper half   P - k h P
//   joseph        the same                      (I - k h) P (I - k h)^T + r k k^T
//   square_root   P = U D U^T, modified         Bierman's update; for considered states plus the rank-one
//                 weighted Gram-Schmidt         term (k* - k) S (k* - k)^T
//
// U is unit upper triangular. Sources: Bierman, Factorization Methods for Discrete Sequential Estimation (1977),
// chapters III, V and VI; Thornton (1976); Grewal & Andrews, Kalman Filtering (2015), chapter 7; Bucy & Joseph (1968).
#pragma once

#include "gyrobudget/navigation/error_state.h"

#include <span>

namespace gyrobudget::inline v0::navigation {

enum class Form { plain, joseph, square_root };

/// One scalar measurement z = h x + v, var v = variance.
struct MeasurementRow {
  StateVector h;
  double variance = 0;  ///< positive
};

class Covariance {
 public:
  /// @throws std::invalid_argument where P is not square of `model` size, not symmetric to 1e-9 of its
  /// diagonal, not finite, or not positive semi-definite to rounding.
  Covariance(const StateMatrix& P, Form);

  [[nodiscard]] Form form() const { return form_; }
  [[nodiscard]] int size() const { return size_; }

  /// P <- Phi P Phi^T + G diag(q) G^T. Allocates nothing.
  /// @throws std::invalid_argument where the sizes differ.
  void propagate(const Transition&);

  /// P h, so that innovations i and k covary by h_i . (P h_k). @throws as update for a wrong size.
  [[nodiscard]] StateVector times(const StateVector& h) const;

  /// The update by one row; returns the gain, 0 for considered states. `considered` is empty or one flag a state.
  /// Allocates nothing.
  StateVector update(const MeasurementRow&, std::span<const bool> considered = {});

  /// The update by one row with any gain k, (I - k h) P (I - k h)^T + r k k^T, r may be 0. Allocates nothing.
  /// @throws std::invalid_argument in square-root form, and for sizes that differ.
  void update_with(const MeasurementRow&, const StateVector& gain);

  /// P in full, symmetric.
  [[nodiscard]] StateMatrix matrix() const;
  /// P_ii.
  [[nodiscard]] double variance(int i) const;

 private:
  void propagate_factors(const Transition&);
  void transform_column(const Transition&, int k);
  StateVector update_dense(const MeasurementRow&, std::span<const bool> considered);
  void joseph(const MeasurementRow&, StateVector& g, const StateVector& gain);
  void symmetrise();
  StateVector update_factors(const MeasurementRow&, std::span<const bool> considered);

  Form form_;
  int size_;
  StateMatrix p_;  ///< P, or U with D on its diagonal; rows filled up with zeros to whole lanes
};

}  // namespace gyrobudget::inline v0::navigation
