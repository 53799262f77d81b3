// SPDX-License-Identifier: MIT
// How temperature moves a bias, and how temperature goes.
#pragma once

#include <cstddef>
#include <vector>

#include "per_axis.h"

namespace gyrobudget::inline v0::noise {

/// The bias of each axis of a triad over its temperature T [degC],
///
///     b(t) = linear (T - reference) + quadratic (T - reference)^2 + rate dT/dt.
///
/// In fibre-optic gyros the rate is the largest part (D. Shupe, Appl. Opt. 19 (1980) 654).
struct TemperatureModel {
  double reference = 0;  ///< where this bias is none [degC]
  PerAxis linear;        ///< [signal/K]
  PerAxis quadratic;     ///< [signal/K^2]
  PerAxis rate;          ///< [signal/(K/s)]

  /// @param axis         0, 1, 2 for x, y, z
  /// @param temperature  [degC]
  /// @param slope        its derivative [K/s]
  [[nodiscard]] double bias(std::size_t axis, double temperature, double slope) const {
    const double t = temperature - reference;
    return (linear[axis] + quadratic[axis] * t) * t + rate[axis] * slope;
  }
};

/// A temperature over time.
class TemperatureProfile {
 public:
  /// The same throughout [degC].
  explicit TemperatureProfile(double constant) : from_(constant), to_(constant) {}
  /// to + (from - to) exp(-t/time_constant): something that was switched on.
  /// @throws std::invalid_argument for a time constant that is not above zero.
  TemperatureProfile(double from, double to, double time_constant_s);
  /// Straight lines between points, constant before the first and behind the last.
  /// @param time_s       ascending
  /// @param temperature  [degC]
  /// @throws std::invalid_argument for fewer than two points, lengths that differ, and times that do not ascend.
  TemperatureProfile(std::vector<double> time_s, std::vector<double> temperature);

  [[nodiscard]] double at(double t) const;     ///< [degC]
  [[nodiscard]] double slope(double t) const;  ///< [K/s]; at a point that of the line behind it

 private:
  [[nodiscard]] std::size_t line_at(double t) const;

  double from_ = 0, to_ = 0, time_constant_s_ = 0;
  std::vector<double> time_s_, temperature_;
};

}  // namespace gyrobudget::inline v0::noise
