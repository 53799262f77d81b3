// SPDX-License-Identifier: MIT
// One cell of a log as a number or as a time stamp.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "decimal.h"

namespace gyrobudget::inline v0::text {

enum class Cell {
  number,
  missing,  ///< empty, NaN, Inf, NA, null and the like
  text,     ///< anything else
  beyond,   ///< a number too large for the type
};

/// Stands for a stamp that is missing.
inline constexpr std::int64_t kNoStamp = std::numeric_limits<std::int64_t>::min();

/// A decimal number, correctly rounded; what is too small for double is zero or denormal, as strtod has it. Blanks and
/// quotes around it are allowed, a '+' too. NaN where it is not a number.
[[nodiscard]] Cell parse_number(std::string_view cell, bool decimal_comma, double& value);

/// A decimal number of units of `ns_per_unit` nanoseconds, exact (never through double) and rounded to the nearest
/// nanosecond, halves away from zero: "1403636579758555392" and "1.403636579758555392e9" keep all digits.
/// kNoStamp where it is not a number.
[[nodiscard]] Cell parse_stamp(std::string_view cell, bool decimal_comma, std::int64_t ns_per_unit, std::int64_t& ns);

// The usual numbers, fast, from text that may go on behind them. Each gives where the number ends, or null where it is
// of a kind, or so long, that only the whole cell tells what it is.

/// What std::from_chars has to read.
[[nodiscard]] const char* scan_unusual_number(const char* begin, const char* end, bool decimal_comma, double& value);
/// To the bit what std::from_chars gives.
[[nodiscard]] inline const char* scan_number(const char* begin, const char* end, bool decimal_comma, double& value) {
  Decimal decimal;
  const char* stop = scan_decimal(begin, end, decimal_comma ? ',' : '.', decimal);
  return stop && to_double(decimal, value) ? stop : scan_unusual_number(begin, end, decimal_comma, value);
}
[[nodiscard]] const char* scan_stamp(const char* begin, const char* end, bool decimal_comma, std::int64_t ns_per_unit,
                                     std::int64_t& ns);

}  // namespace gyrobudget::inline v0::text
