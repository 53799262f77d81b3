// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "generate.h"
#include "model.h"

namespace gyrobudget::inline v0::noise {

/// Coefficients of the bias instability's filter.
struct FilterCoefficients {
  std::vector<double> numerator = {1};
  std::vector<double> denominator = {1, -0.5};  ///< fractal_coefficients(1)
};

/// The 1/f^alpha filter cut short after `taps` past samples: numerator 1, denominator (1 - z^-1)^(alpha/2).
/// @throws std::invalid_argument unless 0 <= taps <= 1e7 and 0 <= alpha < 2, beyond which the filter is not
/// stable.
[[nodiscard]] FilterCoefficients fractal_coefficients(std::int64_t taps, double alpha = 1);

/// Model 2 of Nunes et al.: a triad with the semantics of MATLAB's imuSensor and gyroparams (accelparams
/// without acceleration_bias), under their names. At sample rate fs, with BW = fs/2 (double_sided, their
/// default) or fs (single_sided), T the temperature, a the acceleration, u, v, w independent standard normal:
///
///     n = NoiseDensity sqrt(BW) u + BiasInstability H(v) + RandomWalk/sqrt(BW) (w_0 + w_1 + ...)
///     z = M/100 x + ConstantBias + n + (T - 25) TemperatureBias + AccelerationBias a
///     r = clamp(z (1 + (T - 25)/100 TemperatureScaleFactor), +-MeasurementRange)
///     y = Resolution round(r / Resolution)
///
/// H is the rational filter of bias_instability_coefficients, at rest before sample 0; products of
/// three-vectors are by axis, M is a matrix. The random walk is zero at sample 0.
///
/// PSD of n: N^2 + BiasInstability^2 dt |H(z)|^2 + K^2 dt^2 / (4 sin^2(pi f dt)), with N and K below.
///
/// Where it departs from IEEE Std 952:
/// - double_sided (the default) makes N = NoiseDensity/sqrt(2), -29.29 %, and K = RandomWalk sqrt(2), +41.42 %.
///   The minimum of the Allan deviation, a function of N K, does not move, the tau of it halves. single_sided:
///   N and K.
/// - The default filter remembers one sample: its 1/f noise ends at tau = 3 dt and goes on as white noise of
///   N = 2 BiasInstability sqrt(dt). There is no floor. For one, use fractal_coefficients(p) and what
///   autoregressive_flicker says of p. Its level does not depend on the sample rate, nor on the noise type.
/// - H starts at rest: see ModelMoments.
/// - Resolution adds white noise of Resolution/sqrt(12) a sample where the noise exceeds it, and a dead zone
///   where not.
struct ImuSensor {
  enum class NoiseType { double_sided, single_sided };
  using Vector = std::array<double, 3>;
  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();

  double measurement_range = kUnlimited;  ///< [signal], >= 0
  double resolution = 0;                  ///< [signal], step of the reading; 0: none
  Vector constant_bias = {};              ///< [signal]
  /// M [%], by rows: element (i, j) is what axis i sees of the truth along j.
  std::array<Vector, 3> axes_misalignment = {{{100, 0, 0}, {0, 100, 0}, {0, 0, 100}}};
  Vector noise_density = {};     ///< [signal/sqrt(Hz)]
  Vector bias_instability = {};  ///< [signal]
  Vector random_walk = {};       ///< [signal sqrt(Hz)]
  NoiseType noise_type = NoiseType::double_sided;
  FilterCoefficients bias_instability_coefficients = {};
  Vector temperature_bias = {};          ///< [signal/K]
  Vector temperature_scale_factor = {};  ///< [%/K]
  Vector acceleration_bias = {};         ///< [signal/(m/s^2)]

  /// The noise of an axis (0, 1, 2) sampled at dt [s], at 25 degC, before range and resolution.
  /// @throws std::invalid_argument for another axis, dt not positive and finite.
  [[nodiscard]] Model model(int axis, double dt) const;
};

/// What a triad is exposed to at one sample.
struct ImuInput {
  ImuSensor::Vector signal = {};        ///< true rate [rad/s], or specific force [m/s^2] of an accelerometer
  ImuSensor::Vector acceleration = {};  ///< [m/s^2], for acceleration_bias
  double temperature = 25;              ///< [degC]
};

/// The deterministic part: what the triad reads where `noise` is what its axes add.
[[nodiscard]] ImuSensor::Vector read(const ImuSensor& sensor, const ImuInput& input, const ImuSensor::Vector& noise);

/// Readings of a triad, endless and in constant memory. Axis i draws from stream key.stream | i << 46.
class ImuGenerator {
 public:
  /// Readings every dt [s].
  /// @throws std::invalid_argument for dt not positive and finite, values that are not finite (range: NaN or
  /// negative), a negative resolution, what require_valid refuses of the filter, key.stream >= 2^46.
  ImuGenerator(ImuSensor sensor, double dt, StreamKey key);

  /// The reading at each of `inputs`; the bytes do not depend on how the record is cut into calls.
  /// @throws std::invalid_argument for spans of different lengths.
  void next(std::span<const ImuInput> inputs, std::span<ImuSensor::Vector> readings);
  /// Leaves out `samples` samples of the noise.
  void skip(std::uint64_t samples);

 private:
  ImuSensor sensor_;
  std::vector<Generator> axes_;
  std::array<std::vector<double>, 3> noise_;
};

}  // namespace gyrobudget::inline v0::noise
