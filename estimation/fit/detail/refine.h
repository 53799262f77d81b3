// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {

/// Residuals r = s - A c^2 of the coefficients c (c^2 by element), A and s whitened (see gls.h).
class WhitenedResidual {
 public:
  WhitenedResidual(Eigen::MatrixXd whitened_A, Eigen::VectorXd whitened_s);
  [[nodiscard]] Eigen::Index residuals() const { return Ws_.size(); }
  [[nodiscard]] Eigen::Index coefficients() const { return WA_.cols(); }
  [[nodiscard]] Eigen::VectorXd value(const Eigen::VectorXd& c) const;
  [[nodiscard]] Eigen::MatrixXd jacobian(const Eigen::VectorXd& c) const;  ///< dr/dc = -2 A diag(c)

 private:
  Eigen::MatrixXd WA_;
  Eigen::VectorXd Ws_;
};

struct Refined {
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;  ///< (J'J)^-1 at the solution: weights are absolute, nothing is rescaled
  int iterations = 0;
  bool converged = false;
};

/// Ceres least squares over the coefficients from a start with all of them above zero.
[[nodiscard]] Refined refine(const WhitenedResidual&, const Eigen::VectorXd& start);

}  // namespace gyrobudget::inline v0::fit
