// SPDX-License-Identifier: MIT
// What a datasheet calls in-run bias stability: the minimum of the Allan deviation.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

namespace gyrobudget::inline v0::sensor_file {

/// Minimum over averaging times of the Allan deviation of white noise N, flicker B and rate random walk K (IEEE 952,
/// two-sided): sigma^2 = N^2/tau + (2 ln 2/pi) B^2 + K^2 tau/3 is least at tau = sqrt(3) N/K, where
///
///     minimum^2 = 2 N K / sqrt(3) + (2 ln 2/pi) B^2
///
/// so that it is 0.664 B where N or K is 0 (then as a limit, of long or short tau). Flicker is taken as flat.
/// @param n  [SI], as b and k: not negative
[[nodiscard]] inline double curve_minimum(double n, double b, double k) {
  return std::sqrt(2 * n * k / std::numbers::sqrt3 + 2 * std::numbers::ln2 / std::numbers::pi * b * b);
}

/// The B whose curve has this minimum; none where N and K alone have a higher one.
[[nodiscard]] inline std::optional<double> flicker_of_minimum(double minimum, double n, double k) {
  constexpr double kRounding = 1e-9;  // of a minimum that was computed from N and K alone
  const double rest = minimum * minimum - 2 * n * k / std::numbers::sqrt3;
  if (rest < -kRounding * minimum * minimum) return {};
  return std::sqrt(std::fmax(rest, 0) / (2 * std::numbers::ln2 / std::numbers::pi));
}

}  // namespace gyrobudget::inline v0::sensor_file
