// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "model.h"

namespace gyrobudget::inline v0::noise {

/// Model 1 of Nunes et al.: K. Jerath, S. Brennan, C. Lagoa, "Bridging the gap between sensor noise modeling
/// and sensor characterization", Measurement 116 (2018) 350-366, with the 1/f filter of N. J. Kasdin, Proc.
/// IEEE 83 (1995) 802-827. With u, v, w independent standard normal,
///
///     y_k = N u_k / sqrt(dt) + b_k + r_k
///     b_k = B v_k - a_1 b_{k-1} - ... - a_p b_{k-p},  a_j = a_{j-1} (j - 3/2)/j, a_0 = 1    (autoregressive)
///     b_k = B (v_k + h_1 v_{k-1} + ... + h_{p-1} v_{k-p+1}),  h_j = h_{j-1} (j - 1/2)/j     (moving_average)
///     r_{k+1} = r_k + K sqrt(dt) w_k,  r_0 = 0
///
/// PSD: N^2 + B^2 dt / |a(z)|^2 + K^2 dt^2 / (4 sin^2(pi f dt)) at z = exp(2 pi i f dt).
///
/// Where it departs from IEEE Std 952:
/// - Truncation: bias instability is flat to within 11 % up to tau = 5 p dt (moving average: 0.5 p dt), white
///   beyond; tables at autoregressive_flicker and moving_average_flicker. A floor that holds to 2 h at 100 Hz
///   takes 1.5e5 taps.
/// - Start from rest: the first p samples hold less 1/f noise than the later ones; see ModelMoments.
/// - The driving deviation B does not depend on the sample rate, and must not.
/// At m of a few samples all three terms read as process.h says of sampled processes.
struct Jerath {
  enum class Filter { autoregressive, moving_average };

  double arw = 0;               ///< N [rad/sqrt(s)]
  double bias_instability = 0;  ///< B [rad/s], the coefficient: the floor is 0.664 B
  double rrw = 0;               ///< K [rad/s/sqrt(s)]
  /// p. At 100 Hz 1e4 hold the floor to 500 s at 60 ns a sample, 1.5e5 to 2 h at 100 ns (generator_benchmark).
  std::int64_t taps = 10'000;
  Filter filter = Filter::autoregressive;

  /// @throws std::invalid_argument for taps outside 1 ... 1e7. The sample interval dt [s] does not enter: every
  /// part is given by its coefficient.
  [[nodiscard]] Model model(double dt) const;
};

}  // namespace gyrobudget::inline v0::noise
