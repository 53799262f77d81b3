// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/noise/sensor.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::sensor_file {

/// A sensor file as it was read.
struct SensorFile {
  noise::SensorModel model;
  std::vector<std::string> warnings;  ///< its own, for whoever uses its numbers
  std::vector<std::string> notes;     ///< how it was read, where it can be read in two ways
};

struct ReadOptions {
  /// Of the samples whose sigmas a file of VINS or imu_utils gives [Hz]; unset: they are read as densities.
  std::optional<double> rate_hz;
};

/// Reads a sensor file (YAML, every value with its unit):
///
///     name: IFOG, closed loop, 2018
///     warning: [the fan was on]               # said by whoever uses the numbers; one text, or a list
///     gyro:
///       arw: 5.4e-4 deg/sqrt(h)               # noise::key names the terms of each signal; as all values that are
///       bias_instability: 1.7e-3 deg/h        # not said to be one: for all axes, or for each,
///       rrw: 4.32e-2 deg/h/sqrt(h)            # [4e-2 deg/h/sqrt(h), 4e-2 deg/h/sqrt(h), 9e-2 deg/h/sqrt(h)]
///       # bias_stability: 5e-3 deg/h          # in place of bias_instability: the minimum of the curve (minimum.h)
///       quantization: 0.1 arcsec
///       rate_ramp: 1e-4 deg/h/h
///       gauss_markov: [{sigma: 0.1 deg/h, correlation_time: 300 s}]             # one correlation time
///       sinusoid: [{amplitude: 2 deg/h, frequency: 50 mHz, phase: 0 deg}]       # one frequency, one phase
///       turn_on_bias: 0.01 deg/h
///       scale_factor: 10 ppm
///       misalignment: 20 arcsec
///       g_sensitivity: 0.1 deg/h/g            # gyros only
///       g2_sensitivity: 0.02 deg/h/g^2
///       vibration_rectification: 0.05 deg/h/g^2
///       filter: {kind: second_order, bandwidth: 100 Hz}  # low pass of what is sensed and of white noise; one, as all
///       delay: 2 ms                           # that follow. first_order, second_order or moving_average
///       range: 400 deg/s
///       temperature:                          # bias over it; for all axes, or [x, y, z]
///         reference: 30 degC                  # where this bias is none
///         linear: 5 deg/h/K
///         quadratic: -0.1 deg/h/K^2
///         rate: 20 deg/h/(K/min)
///       powered_on_before: 1 h                # the scene; its noise has run since
///       calibrated_over: 10 min               # the last before the scene, whose mean is taken off
///     accelerometer:                          # the same with vrw, accel_rw
///       vrw: 0.05 m/s/sqrt(h)
///     lever_arm: [0.1 m, 0 m, -0.02 m]        # from the IMU to the centre of mass, forward, right, down
///
/// What is left out is taken as zero, and an accelerometer that is left out as ideal; noise::not_stated tells that from
/// what the file states to be zero (`scale_factor: 0 ppm`, `accelerometer: ideal`). noise/imu.h says what each of them
/// does. `bandwidth: 100 Hz` with `filter_order: 2` is an older way to write the filter; left out, the order is 1.
/// Three forms of others are read too, as SI numbers without units:
/// - Kalibr's imu.yaml, also below imu0 (OpenVINS, %YAML:1.0): noise_density is N, random_walk is K, B is zero.
/// - VINS' gyr_n, gyr_w, acc_n, acc_w at the top level: with a rate fs, sigmas of a sample as its code takes them,
///   N = n / sqrt(fs), K = w / sqrt(fs); else densities, N = n, K = w.
/// - imu_utils' file (Gyr: gyr_n, gyr_w of x-axis, y-axis and z-axis, or of avg-axis): w is the minimum of the Allan
///   deviation, so B = w / sqrt(2 ln 2 / pi); n is N, and with a rate N sqrt(fs), as some of its versions write it.
/// The last two do not tell which they hold: `notes` then says what was taken, and what the other reading would be.
///
/// @throws InputError with file:line:column, what was found, what was expected; an unknown key gets the nearest name.
/// std::invalid_argument for a rate that is not positive and finite.
[[nodiscard]] SensorFile read_sensor_file(const std::string& path, const ReadOptions& options = {});
/// All keys of a sensor file as one commented example, which read_sensor reads.
[[nodiscard]] std::string_view sensor_help();
/// Its model alone, for files that have one reading and no warning to pass on.
[[nodiscard]] noise::SensorModel read_sensor(const std::string& path);

/// The sensor file of a model in datasheet units; read_sensor of it gives the model back bit for bit, with the fewest
/// digits that do (in SI where the datasheet unit cannot). A value that is the same for all axes is written once.
/// `comment`, one or more lines, goes on top.
[[nodiscard]] std::string sensor_yaml(const noise::SensorModel&, std::string_view comment = {},
                                      std::span<const std::string> warnings = {});

}  // namespace gyrobudget::inline v0::sensor_file
