// SPDX-License-Identifier: MIT
// The sensors that tests of budgets and Monte Carlo share.
#pragma once

#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/earth/attitude.h"

namespace gyrobudget::tests {

inline constexpr double kMicroG = 9.80665e-6;
inline constexpr double kDegreePerHour = earth::kDegree / 3600;

/// A tactical MEMS IMU: gyro noise of Nunes et al., table I, the rest as its class is quoted. Switched on ten minutes
/// before the scene.
inline noise::SensorModel mems_imu() {
  noise::SensorModel sensor;
  sensor.gyro.white = 0.15 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 0.7 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 4.32 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 10 * kDegreePerHour;
  sensor.gyro.scale_factor = 5e-4;
  sensor.gyro.misalignment = 1e-3;
  sensor.gyro.powered_on_before = 600;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 1e-3;
  sensor.accelerometer->bias_instability = 50 * kMicroG;
  sensor.accelerometer->turn_on_bias = 1000 * kMicroG;
  sensor.accelerometer->scale_factor = 5e-4;
  sensor.accelerometer->misalignment = 1e-3;
  return sensor;
}

/// A fibre-optic IMU, from the same table.
inline noise::SensorModel ifog_imu() {
  noise::SensorModel sensor;
  sensor.gyro.white = 5.4e-4 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 1.7e-3 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 4.32e-2 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 0.01 * kDegreePerHour;
  sensor.gyro.scale_factor = 1e-5;
  sensor.gyro.misalignment = 5e-5;
  sensor.gyro.powered_on_before = 600;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 5e-5;
  sensor.accelerometer->bias_instability = 5 * kMicroG;
  sensor.accelerometer->turn_on_bias = 100 * kMicroG;
  sensor.accelerometer->scale_factor = 1e-4;
  sensor.accelerometer->misalignment = 5e-5;
  return sensor;
}

}  // namespace gyrobudget::tests
