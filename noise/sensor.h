// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "per_axis.h"
#include "process.h"
#include "temperature.h"
#include "units.h"

namespace gyrobudget::inline v0::noise {

/// What an axis measures; it decides names and datasheet units, never the mathematics. Functions of a Term
/// throw std::invalid_argument for a value that is none.
enum class Signal { angular_rate, specific_force, dimensionless };

/// The unit in which datasheets quote a term: "deg/sqrt(h)" for the white noise of a gyro, "m/s/sqrt(h)" of
/// an accelerometer. Gauss-Markov and sinusoid: that of the signal.
[[nodiscard]] std::string_view datasheet_unit(Signal signal, Term term);
/// Unit for the deviation curve and the mean: deg/h, ug or 1.
[[nodiscard]] std::string_view datasheet_unit(Signal signal);
[[nodiscard]] Dimension dimension_of(Signal signal);             ///< of the signal itself
[[nodiscard]] Dimension dimension_of(Signal signal, Term term);  ///< of a term's coefficient
/// Name in files: arw, bias_instability, rrw, quantization, rate_ramp; vrw and accel_rw for accelerometers.
[[nodiscard]] std::string_view key(Signal signal, Term term);
/// Name for people: "angle random walk", "bias instability".
[[nodiscard]] std::string_view label(Signal signal, Term term);

/// A Gauss-Markov process on each axis of a triad, independent of one another; an axis of sigma 0 has none.
struct TriadGaussMarkov {
  PerAxis sigma;
  double correlation_time = 1;
  [[nodiscard]] constexpr GaussMarkov on(std::size_t axis) const { return {sigma[axis], correlation_time}; }
};

/// A sinusoid of one frequency and phase on each axis of a triad; an axis of amplitude 0 has none.
struct TriadSinusoid {
  PerAxis amplitude;
  double frequency = 1;
  double phase = 0;
  [[nodiscard]] constexpr Sinusoid on(std::size_t axis) const { return {amplitude[axis], frequency, phase}; }
};

/// A noise process on three axes, independent and alike but for their size.
struct TriadProcess {
  Process process;   ///< with the largest coefficient of the three
  PerAxis relative;  ///< coefficient of each axis over that; 1 where all are alike
};

/// One sensor triad's errors, SI, one sigma each. Zero or empty means the sensor has none of it. What each of
/// them does to a reading stands in imu.h.
struct ErrorModel {
  PerAxis quantization;      ///< Q
  PerAxis white;             ///< N
  PerAxis bias_instability;  ///< B
  PerAxis rate_random_walk;  ///< K
  PerAxis rate_ramp;         ///< R
  std::vector<TriadGaussMarkov> gauss_markov;
  std::vector<TriadSinusoid> sinusoids;
  // What a static log cannot give; kept as read, used by flight and budget. Of the axis that errs.
  std::optional<PerAxis> turn_on_bias;             ///< std [signal]
  std::optional<PerAxis> scale_factor;             ///< std [1]
  std::optional<PerAxis> misalignment;             ///< std of each angle [rad]
  std::optional<PerAxis> g_sensitivity;            ///< std of each coefficient [signal/(m/s^2)], gyros
  std::optional<PerAxis> g2_sensitivity;           ///< std [signal/(m/s^2)^2]
  std::optional<PerAxis> vibration_rectification;  ///< std [signal/(m/s^2 rms)^2]
  /// The low pass of what is sensed and of white noise. Noise comes to samples as its `sampling` says; what is sensed
  /// as if held, which a sensor file means for both.
  std::optional<FrontEnd> filter;
  std::optional<double> delay;                  ///< [s]
  std::optional<double> range;                  ///< [signal]
  std::optional<TemperatureModel> temperature;  ///< bias by temperature; nothing where none is known
  // Epoch of the noise: what it is at the start of a scene depends on when it was known last.
  std::optional<double> powered_on_before;  ///< [s] before the scene; empty: at its start
  std::optional<double> calibrated_over;    ///< [s] up to the scene; empty: not calibrated

  /// The non-zero noise processes of an axis: 0, 1, 2 for x, y, z. White noise is FilteredWhite behind a filter.
  [[nodiscard]] std::vector<Process> processes(std::size_t axis) const;
  /// Those that any axis has, of all axes at once; white noise as it is at low frequencies, whatever the filter.
  [[nodiscard]] std::vector<TriadProcess> triad_processes() const;
  /// Whether all three axes have the same noise.
  [[nodiscard]] bool axes_are_alike() const;
  /// The coefficient of Q, N, B, K or R. @throws std::invalid_argument for G and S, which are lists.
  [[nodiscard]] PerAxis& operator[](Term);
  [[nodiscard]] const PerAxis& operator[](Term) const;
};

/// A sensor as its file describes it; `accelerometer` left out means ideal.
struct SensorModel {
  std::string name;
  ErrorModel gyro;
  std::optional<ErrorModel> accelerometer;
  std::array<double, 3> lever_arm = {};  ///< from the IMU to the centre of mass, body axes [m]
};

}  // namespace gyrobudget::inline v0::noise
