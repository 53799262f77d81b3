// SPDX-License-Identifier: MIT
// What other tools call a sensor's noise.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <string>
#include <string_view>
#include <vector>

#include "kalibr.h"

namespace gyrobudget::inline v0::sensor_file {

/// "kalibr", "openvins", "vins", "orb_slam3", "gtsam", "px4_sitl", "kf_gins", "navego", "matlab",
/// "imu_utils", "px4_ekf2", "pyins".
[[nodiscard]] std::vector<std::string> form_names();

/// A sensor in the form of another tool: its keys and units, white noise and a random walk (kalibr.h says which walk
/// stands where none is resolved: it is never 0), each with a comment of what it is and where it comes from. Forms that
/// take one number have the largest of the three axes, the others each axis. With N and K of the sensor, fs the rate:
///
///   kalibr, openvins, orb_slam3   N [rad/s/sqrt(Hz)], K [rad/s^2/sqrt(Hz)]; their code multiplies by sqrt(fs)
///   vins                          N sqrt(fs), K sqrt(fs): sigmas of a sample
///   gtsam                         N^2, K^2: variances of density
///   px4_sitl                      N, K of the plugin of the IMU in Gazebo classic
///   px4_ekf2                      N sqrt(100 Hz), K sqrt(100 Hz): sigmas of a prediction of EKF2
///   imu_utils                     N, and the minimum of the curve as gyr_w (minimum.h), mean and each axis; no K
///   kf_gins                       N [deg/sqrt(h), m/s/sqrt(h)]; a Gauss-Markov bias of time T driven by K:
///                                 K sqrt(T/2) [deg/h, mGal], T = 4 h, or ten times the horizon if longer
///   navego, pyins                 N, K of each axis
///   matlab                        imuSensor's N, K and B of each axis, double-sided; K and B where they are resolved,
///                                 or their limits
///
/// What a form has no place for is told in comments, and what the sensor does not state is a comment to fill in.
/// Sources: the code and documentation of each tool, as of 2026.
/// @param form  one of form_names()
/// @throws std::invalid_argument for another name, and a rate or horizon that is not positive and finite.
[[nodiscard]] std::string form_text(std::string_view form, const noise::SensorModel& model,
                                    const KalibrOptions& options);

}  // namespace gyrobudget::inline v0::sensor_file
