// SPDX-License-Identifier: MIT
// The bias of a sensor over its temperature, from a record at rest that has a temperature beside it.
#pragma once

#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::calibration {

/// One coefficient of the bias over temperature.
struct TemperatureCoefficient {
  double value = 0, lower = 0, upper = 0;  ///< with the 95 % interval
  bool fitted = false;                     ///< false: the record cannot tell it from the others; it is 0
};

/// b(t) = bias + linear (T - reference) + quadratic (T - reference)^2 + rate dT/dt, and what is left when it is taken
/// off.
struct Temperature {
  double reference = 0, lowest = 0, highest = 0;  ///< [degC]; the reference is the mean of the record
  TemperatureCoefficient bias;                    ///< at the reference [signal]
  TemperatureCoefficient linear;                  ///< [signal/K]
  TemperatureCoefficient quadratic;               ///< [signal/K^2]
  TemperatureCoefficient rate;                    ///< [signal/(K/s)]
  double p_value = 1;    ///< of no dependence: how likely noise alone would look so much like temperature
  double explained = 0;  ///< share of the variance of the means of 128 blocks
  bool removed = false;  ///< the p-value is below kTemperatureSeen: curve and fit are of the record without it
  fit::Result before;    ///< the fit of the record as it is

  /// Means of the blocks, for a picture.
  struct Point {
    double time_s = 0, temperature = 0;  ///< [s] from the first sample, [degC]
    double measured = 0, model = 0;      ///< [signal]
  };
  std::vector<Point> points;

  /// The model without the bias, at T [degC] and dT/dt [K/s].
  [[nodiscard]] double shift(double temperature, double slope) const {
    const double t = temperature - reference;
    return (linear.value + quadratic.value * t) * t + rate.value * slope;
  }
};

/// Noise alone is taken for temperature in one record of a thousand.
inline constexpr double kTemperatureSeen = 1e-3;
/// A temperature that ranges over less tells nothing [K].
inline constexpr double kLeastRange = 0.5;

/// A temperature as it is measured (slow, in steps, with gaps) at every sample: straight lines between block means.
class SmoothTemperature {
 public:
  /// @param temperature  [degC], NaN where missing. @param dt  sample interval [s]
  SmoothTemperature(std::span<const double> temperature, double dt);
  /// It has a number in enough blocks to speak of, and ranges over kLeastRange.
  [[nodiscard]] bool is_usable() const { return usable_; }
  [[nodiscard]] double at(double t) const;     ///< [degC]
  [[nodiscard]] double slope(double t) const;  ///< [K/s]
  /// Share of the variance of the slopes of blocks that is not the noise of the temperature itself.
  [[nodiscard]] double slope_reliability() const { return reliability_; }

 private:
  [[nodiscard]] std::size_t line_at(double t, double& part) const;

  double block_s_ = 1, reliability_ = 0;
  bool usable_ = false;
  std::vector<double> value_, slope_;  // at the middles of the blocks
};

/// Fits the bias to the means of 128 blocks by generalised least squares.
///
/// Differences of the means have the exact covariance of the noise (Toeplitz; allan/detail/lag_kernel.h). White noise
/// and what else was fitted are taken as `before` has them; of flicker and walk the levels are those that the
/// restricted likelihood of the differences allows beside the temperature, with the coefficients and their covariance
/// averaged over them: what is slow is temperature or noise, and the interval says how little the record tells of that.
/// Least squares without it claims intervals several times too narrow. Of 600 simulated records of an hour (white
/// noise, flicker and walk, 18 K) the 95 % intervals of bias, linear, quadratic and rate covered 95.8, 96.2, 96.5 and
/// 97.2 %. The bias holds its own noise since the first sample, where flicker and walk are zero.
///
/// A quadratic or a rate that the record cannot tell from the others (99.99 % of it is explained by them, as behind a
/// warm-up that is one exponential) is left at 0; so is a rate of a temperature that is too coarse to have a slope
/// (reliability below 0.9).
/// @param rate         samples [signal], NaN where missing
/// @param temperature  as long, usable
/// @param dt           [s]
/// @param before       the fit of them, with N
/// @return as above; `before` and `removed` are left to the caller. No coefficient is fitted where a block has under
/// half of its samples or the noise of `before` is none.
/// @throws std::invalid_argument for fewer than 1024 samples.
[[nodiscard]] Temperature fit_temperature(std::span<const double> rate, const SmoothTemperature& temperature, double dt,
                                          const fit::Result& before);

}  // namespace gyrobudget::inline v0::calibration
