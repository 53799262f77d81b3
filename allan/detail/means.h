// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "phase.h"

namespace gyrobudget::inline v0::allan::detail {

/// Mean of the m samples from `first` on, about the record's own mean; NaN where fewer than half of them exist.
[[nodiscard]] inline double mean_of(const Phase& phase, std::int64_t first, std::int64_t m) {
  constexpr double kLeastPart = 0.5;
  const std::uint32_t missing = phase.missing ? phase.missing[first + m] - phase.missing[first] : 0;
  const double existing = static_cast<double>(m) - missing;
  if (m < 1 || existing < kLeastPart * static_cast<double>(m)) return std::numeric_limits<double>::quiet_NaN();
  return (phase.x[first + m] - phase.x[first]) / existing;
}

}  // namespace gyrobudget::inline v0::allan::detail
