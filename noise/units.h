// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::noise {

/// Exponents of radian, metre and second, doubled so that sqrt(h) and 1/sqrt(Hz) are whole numbers.
/// deg/sqrt(h) is {angle 2, length 0, time -1}. Angle counts as a dimension of its own: it tells a rate from a
/// frequency and an angle random walk from a number.
struct Dimension {
  std::int8_t angle = 0;
  std::int8_t length = 0;
  std::int8_t time = 0;
  friend constexpr bool operator==(const Dimension&, const Dimension&) = default;
};

/// A unit: how many SI units (rad, m, s) one of it is, and its dimension. An SI value is number * to_si.
struct Unit {
  double to_si = 1;
  Dimension dimension;
};

namespace dimension {
inline constexpr Dimension kNumber{0, 0, 0};
inline constexpr Dimension kTime{0, 0, 2};
inline constexpr Dimension kFrequency{0, 0, -2};
inline constexpr Dimension kAngle{2, 0, 0};
inline constexpr Dimension kAngularRate{2, 0, -2};
inline constexpr Dimension kVelocity{0, 2, -2};
inline constexpr Dimension kSpecificForce{0, 2, -4};
}  // namespace dimension

/// Reads a unit as datasheets, ROS, Kalibr, MATLAB and CSV headers write it. [expand: grammar]
/// @throws std::invalid_argument naming what was not understood, and the nearest known spelling.
[[nodiscard]] Unit parse_unit(std::string_view text);

/// Reads "5.4e-4 deg/sqrt(h)" and returns it in SI.
/// @throws std::invalid_argument where the number or unit is unreadable, the unit is missing, or its dimension is not
/// `expected`; the message says what was found, what was expected, and gives units that would do.
[[nodiscard]] double parse_quantity(std::string_view text, const Dimension& expected);

/// Number with `digits` significant digits in the given unit, e.g. quantity_text(8.24e-9, "deg/h", 3) == "0.00170 deg/h".
[[nodiscard]] std::string quantity_text(double si, std::string_view unit, int digits = 4);

/// SI value in another unit: si / parse_unit(unit).to_si.
[[nodiscard]] double from_si(double si, std::string_view unit);

}  // namespace gyrobudget::inline v0::noise
