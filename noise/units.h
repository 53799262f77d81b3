// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::noise {

/// Exponents of radian, metre, second, kilogram and kelvin, doubled so that sqrt(h) and 1/sqrt(Hz) are whole numbers.
/// deg/sqrt(h) is {angle 2, length 0, time -1}. Angle counts as a dimension of its own: it tells a rate from
/// a frequency and an angle random walk from a number.
struct Dimension {
  std::int8_t angle = 0;
  std::int8_t length = 0;
  std::int8_t time = 0;
  std::int8_t mass = 0;
  std::int8_t temperature = 0;
  friend constexpr bool operator==(const Dimension&, const Dimension&) = default;
};

/// A unit: how many SI units (rad, m, s, kg, K) one of it is, and its dimension. An SI value is number * to_si.
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
inline constexpr Dimension kLength{0, 2, 0};
inline constexpr Dimension kVelocity{0, 2, -2};
inline constexpr Dimension kSpecificForce{0, 2, -4};
inline constexpr Dimension kArea{0, 4, 0};
inline constexpr Dimension kMass{0, 0, 0, 2};
inline constexpr Dimension kForce{0, 2, -4, 2};
inline constexpr Dimension kMoment{0, 4, -4, 2};
inline constexpr Dimension kInertia{0, 4, 0, 2};
inline constexpr Dimension kTemperature{0, 0, 0, 0, 2};
}  // namespace dimension

/// Reads a unit as datasheets, ROS, Kalibr, MATLAB and CSV headers write it: `deg/sqrt(h)`, `°/√h`,
/// `deg/rt-hr`, `(deg/h)/√Hz`, `rad s^-1`, `m s-2`, `mdps/rtHz`, `µg`, `deg per root hour`.
///
/// Grammar, blanks free between tokens (UTF-8; unicode signs as their ASCII forms):
///
///     unit     = factor { ("*" | "·" | "." | "-" | "/" | "per" | blank) factor }     left to right: a/b c is (a/b) c
///     factor   = ( name | "(" unit ")" | "1" ) [ power ]  |  root factor
///     root     = ("sqrt" | "root" | "rt" | "√") [ "-" ]                         joined too: rtHz, sqrthr
///     power    = ("^" | "**") exponent | "^(" exponent ")"
///              | exponent directly behind (s-1, m/s2) | superscripts
///     exponent = whole or half number: 2, -1, 0.5, 1.5, 1/2, -3/2, ½
///
/// Names: rad deg ° rev; arcmin ′ ', arcsec ″ " as; s sec min h hr day d; Hz; m ft in; g Gal; dps dph rpm
/// meru; kg t N Nm Pa; K °C C celsius kelvin; % ppm ppb; 1, dimensionless; plurals and long forms. SI prefixes p n u µ
/// m k M go before rad deg dps g s sec m Hz Gal as N Nm Pa (cm too). Prefixes and one-letter names are case-sensitive
/// (mg is not Mg, G is not g); other names are not (DEG/HR).
///
/// Where a spelling has two readings: g is standard gravity 9.80665 m/s^2, never gram, but kg is kilogram;
/// min and " are minute of time and second of arc; ms is millisecond, `m s` metre second; h is hour; `^1/2` is
/// a square root, as no unit is halved; °C is the step of a kelvin: where its zero matters stands with the value.
/// Counts, LSB and volts are refused: they have no size until a scale gives them one.
///
/// to_si is the exact factor rounded to double.
/// @throws std::invalid_argument naming what was not understood, and the nearest known spelling; also for
/// more than 200 bytes, quarter powers, and units beyond the range of double.
[[nodiscard]] Unit parse_unit(std::string_view text);

/// Reads "5.4e-4 deg/sqrt(h)" and returns it in SI. The number is a finite decimal, the unit is parse_unit's;
/// the blank between them may be left out.
/// @throws std::invalid_argument where the number or unit is unreadable, the unit is missing, or its
/// dimension is not `expected`; the message says what was found, what was expected, and gives units that
/// would do.
[[nodiscard]] double parse_quantity(std::string_view text, const Dimension& expected);

/// Units that people would use for a quantity, for messages: "deg/sqrt(h), deg/h/sqrt(Hz), rad/s/sqrt(Hz)".
[[nodiscard]] std::string example_units(const Dimension& dimension);

/// Number with `digits` significant digits in the given unit, e.g. quantity_text(8.24e-9, "deg/h", 3) ==
/// "0.00170 deg/h". The unit "1" is not printed. Zero is "0", not a number "nan".
[[nodiscard]] std::string quantity_text(double si, std::string_view unit, int digits = 4);

/// SI value in another unit: si / parse_unit(unit).to_si.
[[nodiscard]] double from_si(double si, std::string_view unit);

}  // namespace gyrobudget::inline v0::noise
