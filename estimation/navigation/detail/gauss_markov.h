// SPDX-License-Identifier: MIT
// Inside navigation: closed forms of a unit Gauss-Markov process, in correlation times.
#pragma once

#include <cmath>

namespace gyrobudget::inline v0::navigation::detail {

/// (1 - e^-x)/x, the mean of e^-t for t from 0 to x.
inline double mean_exponential(double x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

/// Variance of the mean over x: 2 (1 - mean_exponential(x))/x. Its series where that cancels.
inline double mean_variance(double x) { return x < 1e-4 ? 1 - x / 3 + x * x / 12 : 2 * (1 - mean_exponential(x)) / x; }

/// Allan variance at x: (2/x) [1 - (3 - 4 e^-x + e^-2x)/(2x)]. Its series, 2x/3 - x^2/2 + 7 x^3/30 - ..., where that
/// cancels.
inline double allan_variance(double x) {
  if (x < 1e-3) return x * (2.0 / 3 - x * (0.5 - 7 * x / 30));
  const double e = std::expm1(-x);  // 3 - 4 (1 + e) + (1 + e)^2 = e^2 - 2e
  return 2 / x * (1 - (e * e - 2 * e) / (2 * x));
}

}  // namespace gyrobudget::inline v0::navigation::detail
