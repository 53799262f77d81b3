// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

namespace gyrobudget::inline v0::allan {

/// The power-law noise that dominates at one averaging factor, S_y(f) ~ f^alpha.
struct Identified {
  int alpha = 0;    ///< 2, 1, 0, -1, -2
  double lag1 = 0;  ///< lag-1 autocorrelation after differencing
  int differences = 0;
  noise::Term term = noise::Term::white;  ///< Q for alpha 2 and 1, N for 0, B for -1, K for -2
};

/// Lag-1 autocorrelation identification (Riley & Greenhall 2004) of the rate record averaged by m.
[[nodiscard]] Identified identify_noise(std::span<const double> rate, std::int64_t m);

}  // namespace gyrobudget::inline v0::allan
