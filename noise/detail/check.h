// SPDX-License-Identifier: MIT
// Arguments are refused in one voice: what, its value, its limit. All throw std::invalid_argument.
#pragma once

#include <limits>
#include <string_view>

namespace gyrobudget::inline v0::noise::detail {

void require(bool valid, std::string_view what, double value, std::string_view limit);
/// Positive and finite [s]. Inline: spectra ask at every frequency.
inline void require_interval(double dt) {
  if (!(dt > 0 && dt <= std::numeric_limits<double>::max()))
    require(false, "sample interval dt", dt, "positive and finite (s)");
}

}  // namespace gyrobudget::inline v0::noise::detail
