// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/io/error.h"
#include "gyrobudget/noise/sensor.h"

#include <string>
#include <string_view>

namespace gyrobudget::inline v0::io {

/// Reads a sensor file (YAML, every value with its unit):
///
///     name: IFOG, closed loop, 2018
///     gyro:
///       arw: 5.4e-4 deg/sqrt(h)               # noise::key names the terms of each signal
///       bias_instability: 1.7e-3 deg/h
///       rrw: 4.32e-2 deg/h/sqrt(h)
///       quantization: 0.1 arcsec
///       rate_ramp: 1e-4 deg/h/h
///       gauss_markov: [{sigma: 0.1 deg/h, correlation_time: 300 s}]
///       sinusoid: [{amplitude: 2 deg/h, frequency: 50 mHz, phase: 0 deg}]
///       turn_on_bias: 0.01 deg/h
///       scale_factor: 10 ppm
///       misalignment: 20 arcsec
///       g_sensitivity: 0 deg/h/g
///       bandwidth: 100 Hz
///       range: 400 deg/s
///     accelerometer:                          # the same with vrw, accel_rw; left out: ideal
///       vrw: 0.05 m/s/sqrt(h)
///
/// What is left out is zero. Three forms of others are read too, as continuous-time SI numbers without units:
/// - Kalibr's imu.yaml, also below imu0 (OpenVINS, %YAML:1.0): noise_density is N, random_walk is K, B is zero.
/// - VINS' gyr_n, gyr_w, acc_n, acc_w at the top level: n is N, w is K.
/// - imu_utils' file (Gyr: avg-axis: gyr_n, gyr_w): n is N; w is the minimum of the Allan deviation, so
///   B = w / sqrt(2 ln 2 / pi). Some of its versions write n as the standard deviation of a sample, a factor
///   sqrt(rate) larger, which the file does not tell.
///
/// @throws InputError with file:line:column, what was found, what was expected; an unknown key gets the nearest name.
[[nodiscard]] noise::SensorModel read_sensor(const std::string& path);

/// The sensor file of a model in datasheet units; read_sensor of it gives the model back bit for bit, with the fewest
/// digits that do (in SI where the datasheet unit cannot). `comment`, one or more lines, goes on top.
[[nodiscard]] std::string sensor_yaml(const noise::SensorModel&, std::string_view comment = {});

/// Kalibr's imu.yaml: continuous-time densities, SI, two-sided. It has no place for bias instability and the other
/// terms: a comment says what was left out.
[[nodiscard]] std::string kalibr_yaml(const noise::SensorModel&, double update_rate_hz);

}  // namespace gyrobudget::inline v0::io
