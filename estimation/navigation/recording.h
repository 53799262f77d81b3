// SPDX-License-Identifier: MIT
// What was recorded: IMU samples and fixes of aids, with their stamps.
#pragma once

#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "errors.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {

/// An IMU's increments over intervals that follow one another without holes.
struct ImuLog {
  /// Interval k is from stamps[k] to stamps[k + 1] [ns]; one more than increments, ascending.
  std::vector<std::int64_t> stamps;
  std::vector<noise::ImuIncrement> increments;
  std::vector<bool> bridged;    ///< interval k holds no sample: it was filled
  std::int64_t gaps = 0;        ///< runs of bridged intervals
  double longest_gap = 0;       ///< [s]
  double bridged_seconds = 0;   ///< in all
  double typical_interval = 0;  ///< median of the samples' [s]
};

/// What a sample is: over the interval that its stamp ends or begins.
enum class SampleKind {
  increment,  ///< integrals of rate [rad] and specific force [m/s]
  mean,       ///< means of both over the interval
  instant,    ///< values at the stamp itself
};
enum class StampAt { end, start };

/// Samples as a log tells them; NaN where one is missing.
struct ImuSamples {
  std::vector<std::int64_t> stamps;         ///< one for each sample [ns]
  std::vector<noise::ImuIncrement> values;  ///< increments, or rates
  SampleKind gyro = SampleKind::increment;
  SampleKind accelerometer = SampleKind::increment;
  StampAt stamp = StampAt::end;
  std::vector<double> temperature;  ///< of the sensor, one for each sample or none [degC]; NaN where missing
};

/// Takes the sensor file's bias over temperature off samples that have a temperature: means of 10 s of it, and straight
/// lines between these. Does nothing without a temperature, or without `temperature` in the sensor file.
/// @return whether it took anything off
/// @throws RecordingError for temperatures that are not as many as samples.
bool take_off_temperature(ImuSamples& samples, const noise::SensorModel& sensor);

/// Intervals from samples. A sample's own interval is the time between stamps, up to 1.5 times the median of
/// those; beyond that there is a gap before it, and its interval is the median. Gaps, and samples with a number
/// missing, are bridged by rates that run straight from the last sample to the next. Values at instants are
/// integrated by the trapezoidal rule.
/// @throws RecordingError for fewer than 2 samples, lists of different length, times that do not
/// ascend (naming the sample, from 0), or no sample that is complete.
[[nodiscard]] ImuLog imu_log(const ImuSamples& samples);

/// One measurement of an aid.
struct Fix {
  std::int64_t stamp = 0;  ///< on the clock of the IMU [ns]
  /// p_eb_e [m]; v_eb_n in north, east, down [m/s]; height in x [m]. Not of attitudes.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();  ///< of attitudes
  /// What is white of this fix alone, one sigma, in place of Aid::sigma and in its components; positive, finite.
  std::optional<Eigen::Vector3d> sigma = {};
};

/// A log and, for each aid of a scene by its number, its fixes, ascending; none for rest.
struct Recording {
  std::int64_t origin = 0;  ///< stamp of time 0 of the scene [ns]
  ImuLog imu;
  std::vector<std::vector<Fix>> fixes;
};

}  // namespace gyrobudget::inline v0::navigation
