// SPDX-License-Identifier: MIT
// Linear algebra of Jacobians, compiled once for all sizes of the state.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

namespace gyrobudget::inline v0::flight::detail {

constexpr int kMostStates = 27;
/// Square and of any size up to that, without memory from the heap.
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostStates, kMostStates>;

/// A matrix in factors, for several right sides.
class Factors {
 public:
  explicit Factors(const Square& matrix);
  /// x = A^-1 f, of as many numbers as A has rows.
  void solve(const double* f, double* x) const;

 private:
  Eigen::PartialPivLU<Square> lu_;
};

/// Largest magnitude of an eigenvalue, to 1 %, by powers of the matrix that is given.
[[nodiscard]] double spectral_radius(Square power);

}  // namespace gyrobudget::inline v0::flight::detail
