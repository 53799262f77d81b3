// SPDX-License-Identifier: MIT
// Kalibr's imu.yaml.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <optional>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::sensor_file {

struct KalibrOptions {
  double update_rate_hz = 0;  ///< of the IMU
  /// Time over which the estimator that reads the file relies on a bias [s]: there a walk stands for 1/f noise.
  double horizon_s = 100;
  /// 95 % limits of coefficients that a record does not resolve, 0 for those that it does (calibration::SensorSummary);
  /// unset: all are.
  std::optional<noise::SensorModel> limits;
  std::string_view comment;  ///< at the head, one or more lines
};

/// Kalibr's imu.yaml: continuous-time densities, SI, two-sided, one number for each triad. Its estimator holds a bias
/// that never walks for constant, so no number is ever 0. Of each axis,
/// - noise_density is N, or its limit where it is not resolved;
/// - random_walk is K where it is resolved; else the walk that stands for bias instability over the horizon T, where
///   that is resolved: K_B = B sqrt(6 ln 2 / (pi T)), whose Allan deviation sqrt(K^2 T/3) at T is flicker's flat
///   sqrt(2 ln 2 / pi) B; else the limit of K;
/// and the file has the largest of the three axes, as what is claimed too small makes an estimator too sure. A comment
/// says which it is and how it was made. Where there is neither a value nor a limit, the line is a comment that asks
/// for one. What the form has no place for is told in comments.
/// @throws std::invalid_argument for an update rate or a horizon that is not positive and finite.
[[nodiscard]] std::string kalibr_yaml(const noise::SensorModel& model, const KalibrOptions& options);

/// The random walk that stands for flicker of coefficient b over a time [signal/sqrt(s)].
[[nodiscard]] double walk_of_flicker(double b, double horizon_s);

}  // namespace gyrobudget::inline v0::sensor_file
