// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::fit {

// The record as its likelihood sees it: the orthonormal sine transform (DST-I) of the n-1 differences of n rates,
//   c_k = sqrt(2/n) sum_{j=1}^{n-1} (y_j - y_{j-1}) sin(pi j k/n),  k = 1 .. n-1.
// Differences make every process but a trend stationary, and the sine transform leaves nothing of the record's ends:
// white noise and rate random walk become exactly independent, the others nearly so.

/// c_1 .. c_{n-1} of n = rate.size() rates, n as noise::fft_length_within gives. Error about 1e-15 of the largest.
/// Source: W. H. Press et al., Numerical Recipes, 3rd ed., section 12.4: one real FFT of n points.
[[nodiscard]] std::vector<double> sine_transform_of_differences(std::span<const double> rate);

/// E[c_k^2] of a random process with its coefficient, the exact diagonal of the covariance: with s = sin(pi k/2n),
/// c = cos(pi k/2n), theta = pi k/n,
///
///   N  4 N^2 s^2 / dt
///   K  K^2 dt
///   Q  16 Q^2/dt^2 (s^4 + s^2 c^2/n): two readings at the ends have one neighbour each
///   B  2 B^2 s - 2 B^2/(pi n) [1 - (s^2/c) ln cot(pi k/4n) - (-1)^k j(pi k)],
///      j(a) = int_0^inf v^2 e^-v/(a^2 + v^2) dv; of order 1/n^2 the rest is left out: 2e-3 at n = 16, 2e-5 at 256
///   G  4 s^2 sigma^2 (1-phi^2)/D - 4/n sigma^2 (1-phi)^2 phi sin^2(theta)/D^2 (1 - (-1)^k phi^n),
///      D = (1-phi)^2 + 4 phi s^2, phi = exp(-dt/Tc)
///
/// The first part of each is 4 s^2 S(f)/dt at f = k/(2 n dt), the rest what the ends of the record add.
/// @param k real, in (0, n). At a k that is not whole the terms in (-1)^k, of order 1/(k^2 n), are left out.
/// @throws std::invalid_argument for a ramp or a sinusoid, which are means.
[[nodiscard]] double sine_variance(const noise::Process&, double k, std::int64_t n, double dt);

/// c_k of a ramp y_j = dt j: sqrt(2/n) dt cot(pi k/2n) for odd k, else 0.
[[nodiscard]] double sine_mean_of_ramp(std::int64_t k, std::int64_t n, double dt);

/// c_k of cos(w j) and of sin(w j), j = 0 .. n-1 the number of the sample, w = 2 pi f dt in (0, pi).
[[nodiscard]] std::array<double, 2> sine_mean_of_line(std::int64_t k, std::int64_t n, double w);

}  // namespace gyrobudget::inline v0::fit
