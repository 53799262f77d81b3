// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"
#include "gyrobudget/noise/units.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::noise {

/// What an axis measures; it decides names and datasheet units, never the mathematics. Functions of a Term
/// throw std::invalid_argument for a value that is none.
enum class Signal { angular_rate, specific_force, dimensionless };

/// The unit in which datasheets quote a term: "deg/sqrt(h)" for the white noise of a gyro, "m/s/sqrt(h)" of
/// an accelerometer. Gauss-Markov and sinusoid: that of the signal.
[[nodiscard]] std::string_view datasheet_unit(Signal, Term);
/// Unit for the deviation curve and the mean: deg/h, ug or 1.
[[nodiscard]] std::string_view datasheet_unit(Signal);
[[nodiscard]] Dimension dimension_of(Signal);        ///< of the signal itself
[[nodiscard]] Dimension dimension_of(Signal, Term);  ///< of a term's coefficient
/// Name in files: arw, bias_instability, rrw, quantization, rate_ramp; vrw and accel_rw for accelerometers.
[[nodiscard]] std::string_view key(Signal, Term);
/// Name for people: "angle random walk", "bias instability".
[[nodiscard]] std::string_view label(Signal, Term);

/// One sensor triad's errors, SI, one sigma each. Zero or empty means the sensor has none of it.
struct ErrorModel {
  double quantization = 0;      ///< Q
  double white = 0;             ///< N
  double bias_instability = 0;  ///< B
  double rate_random_walk = 0;  ///< K
  double rate_ramp = 0;         ///< R
  std::vector<GaussMarkov> gauss_markov;
  std::vector<Sinusoid> sinusoids;
  // What a static log cannot give; kept as read, used by flight and budget.
  std::optional<double> turn_on_bias;   ///< std [signal]
  std::optional<double> scale_factor;   ///< std [1]
  std::optional<double> misalignment;   ///< std [rad]
  std::optional<double> g_sensitivity;  ///< std [signal/(m/s^2)]
  std::optional<double> bandwidth;      ///< [Hz]
  std::optional<double> range;          ///< [signal]

  /// The non-zero noise processes.
  [[nodiscard]] std::vector<Process> processes() const;
  /// The coefficient of Q, N, B, K or R. @throws std::invalid_argument for G and S, which are lists.
  [[nodiscard]] double& operator[](Term);
  [[nodiscard]] double operator[](Term) const;
};

/// A sensor as its file describes it; `accelerometer` left out means ideal.
struct SensorModel {
  std::string name;
  ErrorModel gyro;
  std::optional<ErrorModel> accelerometer;
};

}  // namespace gyrobudget::inline v0::noise
