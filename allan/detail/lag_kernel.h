// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

namespace gyrobudget::inline v0::allan::detail {

/// Two averaging factors, m1 <= m2, of a record sampled every dt [s].
struct Pair {
  std::int64_t m1, m2;
  double dt;
};

/// Covariance of one term of the estimate at m1 with one at m2, for a process with unit coefficient:
///
///   C(u) = cov(d1, d2) = 1/(2 m1 m2 dt^2) sum_{a,b = -1,0,1} c_a c_b R(u + a m1 + b m2),  c = (1, -2, 1)
///
/// where d = (difference of the two cluster means) / sqrt 2, R is noise::phase_covariance and u >= 0 the distance
/// between the middles of the two triples in samples. C is even in u and C(0) = Allan variance for m1 = m2.
///
/// As written the sum loses all digits when m2 >> m1 (R grows as u^3); here each process has a form of its own that
/// does not. For white noise, random walk and quantization C is exactly 0 from u = m1 + m2 (+1 for the latter) on.
/// C is smooth in u but for the lags 0, m1, m2 - m1, m2, m1 + m2. Lags that are not whole must stay at least
/// kSmooth away from those.
///
/// Rate ramp and sinusoid are means. For them C(u) is the product of the means of d1 and d2, averaged over the phase
/// of the sinusoid: by Isserlis' theorem it enters the covariance of the estimates as if it were a covariance, but
/// never together with another mean.
void lag_kernel(const noise::Process& unit_process, const Pair&, std::span<const double> u, std::span<double> c);

inline constexpr std::int64_t kSmooth = 16;

/// Whether a process is a mean, not a random process.
[[nodiscard]] bool deterministic(const noise::Process&);

}  // namespace gyrobudget::inline v0::allan::detail
