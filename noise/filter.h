// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace gyrobudget::inline v0::noise {

/// White noise through a rational filter, at rest before sample 0:
///
///     a_0 y_k + a_1 y_{k-1} + ... + a_p y_{k-p} = b_0 v_k + b_1 v_{k-1} + ...,   v_k = sigma u_k,
///
/// u independent standard normal, b the numerator and a the denominator, sigma in units of the signal and *per
/// sample*: nothing here knows the sample interval, and that is the trap of models built from filters.
struct FilteredNoise {
  double sigma = 0;
  std::vector<double> numerator = {1};
  std::vector<double> denominator = {1};
};

/// @throws std::invalid_argument for coefficients that are empty or not finite, a_0 = 0 and sigma not finite.
void require_valid(const FilteredNoise& noise);

/// The first 1 + taps coefficients of (1 - z^-1)^power (Kasdin 1995): c_0 = 1, c_j = c_{j-1} (j - 1 - power) / j.
/// @throws std::invalid_argument unless 0 <= taps <= 1e7 and |power| <= 2.
[[nodiscard]] std::vector<double> fractional_difference(double power, std::int64_t taps);

/// 1/f noise as an autoregression of `taps` past samples: denominator (1 - z^-1)^(1/2) cut short, sigma = B,
/// whatever the sample interval. Sampled S(f) = B^2 dt / (2 sin(pi f dt)) down to f = 1/(2 pi^2 taps dt), white
/// of N = B sqrt(pi taps dt) far below it.
/// Ratio of its Allan deviation to flicker's:
///
///     m / taps   0.1     0.3     1       2       3       5       10     30     100
///     ratio      1.001   1.005   1.063   1.105   1.076   0.973   0.77   0.47   0.27
/// @throws std::invalid_argument unless 1 <= taps <= 1e7.
[[nodiscard]] FilteredNoise autoregressive_flicker(double b, std::int64_t taps);

/// 1/f noise as a moving average over `taps` white samples: numerator (1 - z^-1)^(-1/2) cut short, sigma = B.
/// It holds a tenth as long per tap as the autoregression:
///
///     m / taps   0.1     0.3     1       3       10
///     ratio      1.013   1.043   1.20    0.90    0.52
/// @throws std::invalid_argument unless 1 <= taps <= 1e7.
[[nodiscard]] FilteredNoise moving_average_flicker(double b, std::int64_t taps);

/// Two-sided power spectral density [signal^2/Hz] of the stationary noise sampled every dt [s], sigma^2 dt
/// |b(z)/a(z)|^2 at z = exp(2 pi i f dt). Error below 1e-15 (taps) / |a(z)| of it; time O(taps).
/// @throws std::invalid_argument for a frequency outside (0, 1/(2 dt)] and what require_valid refuses.
[[nodiscard]] double psd(const FilteredNoise& noise, double frequency_hz, double dt);

/// Exact second moments of filtered noise, from its impulse response h. With H_j = h_0 + ... + h_j, none for
/// j < 0, and g_j = H_j - 2 H_{j-m} + H_{j-2m}, the difference of neighbouring clusters of m is
/// sum_j g_j v_{k-j} / m, so that
///
///     stationary:                        sigma_A^2(m) = sigma^2/(2 m^2) sum_{j >= 0} g_j^2
///     mean of the overlapped estimate
///     over samples 0 ... n-1 at rest:    the same sum with weights (n - max(j, 2m-1)) / (n - 2m + 1), j < n
///
/// The second is what a generated record has on average: a filter that remembers longer than the record starts
/// quieter than it becomes (flicker: -0.35 % of the variance at m = n/16, -0.8 % at n/8, -1.9 % at n/4, -7.9 %
/// at n/2).
///
/// Every term is positive. h comes from one Fourier transform, long enough for the response to have died below
/// 1e-11 of its peak; relative error below 1e-9. Setting up takes O(taps log(taps)), 1 s for 1e5 taps, of
/// which autoregressive_flicker may have 5e5. A variance takes O(response), 24 samples a tap of that filter.
class FilterMoments {
 public:
  /// @throws std::invalid_argument for what require_valid refuses and a filter that is not stable or remembers
  /// more than 1.2e7 samples.
  explicit FilterMoments(const FilteredNoise& noise);

  /// Of the stationary noise, unit [signal^2]. @throws std::invalid_argument for m < 1.
  [[nodiscard]] double allan_variance(std::int64_t m) const;
  /// Expectation of the overlapped estimate over `samples` samples from rest.
  /// @throws std::invalid_argument unless 1 <= m <= samples / 2.
  [[nodiscard]] double allan_variance(std::int64_t m, std::int64_t samples) const;
  /// Of one sample, stationary [signal^2].
  [[nodiscard]] double variance() const;
  /// Samples until an impulse has died away.
  [[nodiscard]] std::int64_t response_length() const;

 private:
  [[nodiscard]] double step_response(std::int64_t j) const;
  template <typename Weight>
  [[nodiscard]] double weighted_sum(std::int64_t m, std::int64_t end, Weight weight) const;

  double sigma_;
  std::vector<double> steps_;  ///< H_j up to where it stays
};

}  // namespace gyrobudget::inline v0::noise
