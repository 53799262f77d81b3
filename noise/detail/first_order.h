// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace gyrobudget::inline v0::noise::detail {

/// Joint law of a first-order process x_{k+1} = (1 - d) x_k + noise after n steps and of its sum on the way,
/// given where it began:
///     x_n = (1 - decay) x_0 + e,   S = x_0 + ... + x_{n-1} = gain x_0 + g,
/// e and g normal with these moments. Every number is a sum of positive ones: nothing cancels, however slow
/// the process is and however many the steps.
struct FirstOrder {
  double decay = 0;
  double gain = 0;
  double var_end = 0;
  double covariance = 0;
  double var_sum = 0;

  /// One step of a Gauss-Markov process; of a random walk with correlation_time infinite see walk().
  [[nodiscard]] static FirstOrder gauss_markov(double sigma, double correlation_time, double dt);
  /// One step of a random walk of K.
  [[nodiscard]] static FirstOrder walk(double k, double dt);
  /// `steps` of these in a row, in time O(log(steps)).
  [[nodiscard]] FirstOrder repeated(std::uint64_t steps) const;

  struct Draw {
    double end, sum;
  };
  /// x_n and S from x_0 and two standard normal numbers.
  [[nodiscard]] Draw draw(double start, double u, double v) const;
};

}  // namespace gyrobudget::inline v0::noise::detail
