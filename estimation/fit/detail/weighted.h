// SPDX-License-Identifier: MIT
#pragma once

#include "gls.h"

namespace gyrobudget::inline v0::fit {

/// An estimate with weights that ignore how taus are correlated, and what that leaves of its accuracy.
struct WeightedSolution {
  GlsSolution solution;        ///< S is the full covariance at theta, chi2 with it
  Eigen::MatrixXd covariance;  ///< of theta: H S H', H the linearised estimator, so correlations count here
};

/// Linear residuals over the standard deviation of each tau, iterated to the fixed point.
[[nodiscard]] WeightedSolution weigh_by_variance(const LinearModel&);

/// min sum (ln s_i - ln (A theta)_i)^2 over theta >= 0 by Gauss-Newton steps with bounds. Taus with s = 0 are left out.
[[nodiscard]] WeightedSolution fit_logarithms(const LinearModel&);

}  // namespace gyrobudget::inline v0::fit
