// SPDX-License-Identifier: MIT
// Are errors as large as a covariance says? Sources: Bar-Shalom, Li & Kirubarajan, Estimation with Applications to
// Tracking and Navigation (2001), section 5.4.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::navigation {

/// Normalised estimation error squared, e^T P^-1 e: chi-square of e's size where P is right. Directions in which P has
/// no variance to rounding do not count, and an error in them makes it infinite.
/// @throws std::invalid_argument for sizes that differ.
[[nodiscard]] double nees(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& P);

/// NEES of errors of a chain that P describes to first order only. With D the diagonal of P, u_k and l_k the
/// eigenvectors and eigenvalues of the correlations D^-1/2 P D^-1/2,
///   NEES = sum_k (u_k . D^-1/2 e)^2 / l_k   over the directions with l_k > threshold,
/// chi-square with as many degrees of freedom. In a direction with less, what the first order leaves out may
/// be all there is: an attitude error psi adds about psi^2 of an axis' variance there, which no P of first
/// order knows. Monte Carlo takes a threshold of 1e-12 to 0.01 by the attitude (second_order, monte_carlo.h).
class FirstOrderNees {
 public:
  struct Direction {
    Eigen::VectorXd weights;  ///< of the errors, each in units of its sigma; [its own unit] where that is 0
    double variance = 0;      ///< of the sum by P, in these units
  };
  /// @param threshold variance of a direction in units of sigma^2; below rounding: rounding
  /// @throws std::invalid_argument where P is not square or the threshold not below 1.
  FirstOrderNees(const Eigen::Ref<const Eigen::MatrixXd>& P, double threshold);

  /// @throws std::invalid_argument for another size than that of P.
  [[nodiscard]] double operator()(const Eigen::Ref<const Eigen::VectorXd>& error) const;
  [[nodiscard]] int dof() const { return static_cast<int>(counted_.size()); }
  /// Those that do not count.
  [[nodiscard]] const std::vector<Direction>& left_out() const { return left_out_; }
  /// Component of an error along one of them.
  [[nodiscard]] double along(const Direction& direction, const Eigen::Ref<const Eigen::VectorXd>& error) const;

 private:
  Eigen::VectorXd scale_;  ///< one over each sigma; 1 where that is 0
  std::vector<Direction> counted_, left_out_;
};

/// Central band that holds the mean of `count` independent chi-square numbers of `dof` with `probability`.
struct Band {
  double lower = 0, upper = 0;
  [[nodiscard]] bool holds(double x) const { return lower <= x && x <= upper; }
};
/// @throws std::invalid_argument unless dof > 0, count > 0 and 0 < probability < 1.
[[nodiscard]] Band chi_square_mean_band(double dof, double count, double probability = 0.95);

/// Central band for the ratio of a standard deviation found in `count` zero-mean normal numbers to the true one.
[[nodiscard]] Band sigma_ratio_band(double count, double probability = 0.95);

}  // namespace gyrobudget::inline v0::navigation
