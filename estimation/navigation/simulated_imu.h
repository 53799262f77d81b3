// SPDX-License-Identifier: MIT
// A whole IMU carried along a trajectory: what it delivers, interval by interval.
#pragma once

#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::navigation {

struct SimulatedImuOptions {
  double rate_hz = 100;
  std::uint64_t seed = 1;
  std::uint64_t run = 0;                                      ///< another turn-on: all that is drawn is drawn anew
  double vibration = 0;                                       ///< level [m/s^2 rms], for vibration rectification
  std::optional<noise::TemperatureProfile> temperature = {};  ///< from the start on; unset: at the reference
};

/// The centre of mass flies the trajectory, and the IMU sits at minus the sensor's lever arm from there, where it
/// senses w' x r + w x (w x r) more: the first integrated in closed form, the second by Simpson's rule over each
/// interval.
///
///     navigation::SimulatedImu imu(earth::ascent({}), sensor, {.rate_hz = 100});
///     for (const noise::ImuIncrement& y : imu.next(8000)) use(y.angle, y.velocity);
class SimulatedImu {
 public:
  /// @throws std::invalid_argument for what noise::Imu refuses.
  SimulatedImu(earth::Trajectory trajectory, const noise::SensorModel& sensor, const SimulatedImuOptions& options = {});

  /// What is measured over the next `count` intervals. Time stands still where the trajectory has ended. The numbers do
  /// not depend on how they are grouped into calls, nor on the number of threads.
  [[nodiscard]] std::vector<noise::ImuIncrement> next(std::size_t count);

  /// Leaves out intervals, in constant memory; what follows is what would have followed them.
  void skip(std::uint64_t intervals);

  /// The IMU as it is after the last interval.
  [[nodiscard]] const noise::Imu& imu() const { return imu_; }

 private:
  [[nodiscard]] std::vector<noise::ImuIncrement> ideal(std::size_t count);

  earth::Trajectory trajectory_;
  Eigen::Vector3d imu_at_;  ///< from the centre of mass [m, body axes]
  noise::Imu imu_;
  double rate_hz_;
  std::uint64_t at_ = 0;
};

}  // namespace gyrobudget::inline v0::navigation
