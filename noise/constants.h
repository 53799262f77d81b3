// SPDX-License-Identifier: MIT
// Numbers that are agreed, not measured, and that more than one library needs.
#pragma once

#include <cstdint>

namespace gyrobudget::inline v0::noise {

/// Time stamps are whole nanoseconds, durations are seconds.
inline constexpr double kNanosecond = 1e-9;  ///< [s]
inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// Standard gravity, exact by the 3rd CGPM (1901) [m/s^2]; with the digits of long double for products of units.
inline constexpr long double kStandardGravityLong = 9.80665L;
inline constexpr double kStandardGravity = static_cast<double>(kStandardGravityLong);

}  // namespace gyrobudget::inline v0::noise
