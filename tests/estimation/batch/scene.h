// SPDX-License-Identifier: MIT
// A turning flight with simulated sensors and fixes: the truth of the batch's tests.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"
#include "gyrobudget/estimation/navigation/simulated_imu.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <cmath>
#include <cstdint>
#include <random>

namespace gyrobudget::tests {

inline constexpr double kImuInterval = 0.01;  // s

/// White noise and a bias that walks: every kind of term a batch tells apart, few of them.
inline noise::SensorModel small_imu() {
  noise::SensorModel sensor;
  sensor.gyro.white = 1e-5;
  sensor.gyro.rate_random_walk = 1e-6;
  sensor.gyro.turn_on_bias = 5e-5;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 1e-3;
  sensor.accelerometer->turn_on_bias = 5e-3;
  return sensor;
}

/// S-turns of 0.3 g at 30 m/s.
inline earth::Trajectory turns(double duration) {
  return earth::cruise({.speed = 30, .turn_acceleration = 3, .turn_period = 10, .duration = duration});
}

struct Scene {
  earth::Trajectory truth;
  navigation::Scenario scenario;
  navigation::Recording recording;
};

/// A position aid every half second, 0.5 m, and a start drawn from its own sigmas; `run` draws all anew.
inline Scene scene(double duration, std::uint64_t run, double heading_sigma = 1e-3,
                   const Eigen::Vector3d& lever_arm = Eigen::Vector3d::Zero(), double lever_sigma = 0) {
  Scene s{turns(duration), {}, {}};
  s.scenario.sensor = small_imu();
  navigation::SimulatedImu imu(s.truth, s.scenario.sensor, {.rate_hz = 1 / kImuInterval, .seed = 11, .run = run});
  const auto steps = static_cast<std::size_t>(std::llround(duration / kImuInterval));
  s.recording.imu.increments = imu.next(steps);
  s.recording.imu.typical_interval = kImuInterval;
  for (std::size_t k = 0; k <= steps; ++k)
    s.recording.imu.stamps.push_back(std::llround(static_cast<double>(k) * kImuInterval * 1e9));
  s.recording.imu.bridged.assign(steps, false);

  std::mt19937_64 generator(run);
  std::normal_distribution<double> normal;
  const auto three = [&] {
    const double x = normal(generator), y = normal(generator), z = normal(generator);
    return Eigen::Vector3d(x, y, z);
  };
  navigation::Aid aid;
  aid.name = "gnss.position";
  aid.sigma.setConstant(0.5);
  aid.lever_arm_sigma.setConstant(lever_sigma);
  s.scenario.aids = {aid};
  s.recording.fixes.resize(1);
  for (int k = 1; k <= std::llround(2 * duration); ++k) {
    const earth::TrajectoryPoint at = s.truth.at(std::min(0.5 * k, duration));
    navigation::Fix fix;
    fix.stamp = 500'000'000LL * k;
    fix.value = at.pose.p_eb_e + at.pose.q_eb * lever_arm + 0.5 * three();
    s.recording.fixes[0].push_back(fix);
  }

  const earth::Pose start = s.truth.at(0).pose;
  earth::Geodetic place = earth::to_geodetic(start.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  place = earth::to_geodetic(start.p_eb_e + 0.5 * three());
  navigation::AlignmentPlan& plan = s.scenario.alignment;
  plan.position = place;
  plan.velocity = Eigen::Vector3d(C_en.transpose() * (start.v_eb_e + 0.05 * three()));
  const Eigen::Vector3d off = Eigen::Vector3d(1e-3, 1e-3, heading_sigma).cwiseProduct(three());
  const Eigen::Quaterniond q_nb = Eigen::Quaterniond(C_en).conjugate() * start.q_eb;
  plan.attitude = earth::to_euler((earth::exp_rotation(off) * q_nb).normalized());
  plan.position_sigma = Eigen::Vector3d::Constant(0.5);
  plan.velocity_sigma = Eigen::Vector3d::Constant(0.05);
  plan.level_sigma = 1e-3;
  plan.heading_sigma = heading_sigma;
  return s;
}

}  // namespace gyrobudget::tests
