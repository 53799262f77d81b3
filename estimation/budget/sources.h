// SPDX-License-Identifier: MIT
// The lines of a budget: each error of a sensor, of the start and of the world as a Source of its own.
#pragma once

#include "gyrobudget/estimation/navigation/sensor_states.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <string>
#include <string_view>
#include <vector>

#include "error_budget.h"

namespace gyrobudget::inline v0::budget {

/// gyro.arw, gyro.bias_instability, gyro.rrw, gyro.turn_on_bias, gyro.scale_factor, gyro.misalignment,
/// gyro.g_sensitivity, gyro.g2_sensitivity, gyro.vibration_rectification, gyro.gauss_markov,
/// gyro.temperature (of Options::temperature; not random: one sigma is the bias itself), accelerometer.vrw ...: what
/// the file has, each with the true model of sensor_states() since the scene's epoch. What linear covariance has no
/// state for (quantization, ramp, sinusoid, bandwidth, range) is in `left_out`.
struct SensorSources {
  std::vector<Source> sources;
  std::vector<navigation::SensorStates::LeftOut> left_out;
};
/// Uses of options do not matter here: a true error is there whether it is estimated or not.
/// @throws as sensor_states.
[[nodiscard]] SensorSources sensor_sources(const noise::SensorModel& sensor,
                                           const navigation::SensorStates::Options& options);

/// One sigma at the scene's start, where it is given and not found by alignment.
struct InitialErrors {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< east, north, up [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< east, north, up [m/s]
  double level = 0;                                    ///< about east and about north [rad]
  double heading = 0;                                  ///< about up [rad]
};
/// initial.position, initial.velocity, initial.level, initial.heading: those that are not zero.
[[nodiscard]] std::vector<Source> initial_sources(const InitialErrors& errors, const Eigen::Matrix3d& C_el);
/// What the source of that name stands for, and nothing else; all zero for a name that is none of them.
[[nodiscard]] InitialErrors only(const InitialErrors& errors, std::string_view source);
/// Their sum, as the core of a filter's P0.
[[nodiscard]] navigation::CoreMatrix initial_core(const InitialErrors& errors, const Eigen::Matrix3d& C_el);

inline constexpr std::string_view kUncompensatedEarthRate = "earth_rate_uncompensated";
/// A source of that name: a navigator that takes the gyros' rate as that against Earth. Not random: one sigma is
/// the error itself.
[[nodiscard]] Source uncompensated_earth_rate();

/// gravity_model: a vertical error of normal gravity, constant over the scene [m/s^2].
[[nodiscard]] Source gravity_error(double sigma);
/// deflection: of the vertical, constant, the same in each of two directions [rad]; 1e-4 rad is large.
[[nodiscard]] Source deflection_of_the_vertical(double sigma);

}  // namespace gyrobudget::inline v0::budget
