// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/noise/sensor.h"

#include <string>
#include <string_view>

namespace gyrobudget::inline v0::sensor_file {

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
///       turn_on_bias: 0.01 deg/h              # for all axes, or [0.01 deg/h, 0.01 deg/h, 0.02 deg/h]
///       scale_factor: 10 ppm                  # so too, as are the next four
///       misalignment: 20 arcsec
///       g_sensitivity: 0.1 deg/h/g            # gyros only
///       g2_sensitivity: 0.02 deg/h/g^2
///       vibration_rectification: 0.05 deg/h/g^2
///       bandwidth: 100 Hz
///       filter_order: 2                       # of the bandwidth's low pass, 1 or 2; left out: 1
///       delay: 2 ms
///       range: 400 deg/s
///       temperature:                          # bias over it; for all axes, or [x, y, z]
///         reference: 30 degC                  # where this bias is none
///         linear: 5 deg/h/K
///         quadratic: -0.1 deg/h/K^2
///         rate: 20 deg/h/(K/min)
///       powered_on_before: 1 h                # the scene; its noise has run since
///       calibrated_over: 10 min               # the last before the scene, whose mean is taken off
///     accelerometer:                          # the same with vrw, accel_rw; left out: ideal
///       vrw: 0.05 m/s/sqrt(h)
///     lever_arm: [0.1 m, 0 m, -0.02 m]        # from the IMU to the centre of mass, forward, right, down
///
/// What is left out is zero; noise/imu.h says what each of them does. Three forms of others are read too, as
/// continuous-time SI numbers without units:
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

}  // namespace gyrobudget::inline v0::sensor_file
