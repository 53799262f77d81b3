// SPDX-License-Identifier: MIT
// Are errors as large as a covariance says? Sources: Bar-Shalom, Li & Kirubarajan, Estimation with Applications to
// Tracking and Navigation (2001), section 5.4.
#pragma once

#include <Eigen/Core>

namespace gyrobudget::inline v0::navigation {

/// Normalised estimation error squared, e^T P^-1 e: chi-square of e's size where P is right. Directions in which P has
/// no variance to rounding do not count, and an error in them makes it infinite.
/// @throws std::invalid_argument for sizes that differ.
[[nodiscard]] double nees(const Eigen::Ref<const Eigen::VectorXd>& error,
                          const Eigen::Ref<const Eigen::MatrixXd>& P);

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
