// SPDX-License-Identifier: MIT
#include "gyrobudget/navigation/monte_carlo.h"

#include "gyrobudget/earth/frames.h"
#include "gyrobudget/earth/paths.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gyrobudget;  // NOLINT
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::CoreMatrix;
using navigation::MonteCarlo;
using navigation::Source;
using navigation::Timeline;

namespace {

constexpr double kDegreePerHour = earth::kDegree / 3600;

noise::SensorModel mems() {
  noise::SensorModel sensor;
  sensor.gyro.white = 0.15 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 0.70 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 4.32 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 1 * kDegreePerHour;
  sensor.gyro.scale_factor = 3e-4;
  sensor.gyro.misalignment = 5e-4;
  sensor.gyro.powered_on_before = 600;
  return sensor;
}

Matrix3d pad_axes() { return earth::LocalFrame::east_north_up(earth::alcantara().position).C_el(); }

}  // namespace

// The whole chain against linear covariance, source by source: the ascent from Alcantara.
TEST(MonteCarloOfAnAscent, AgreesWithTheBudget) {
  const auto path = earth::ascent({});
  Timeline::Options options;
  options.step = 0.25;
  const Timeline timeline(path, {}, options);
  navigation::SensorStates::Options states;
  states.scene_length = path.duration();
  const navigation::InitialErrors initial{.velocity = {0.01, 0.01, 0.01}, .level = 1e-4, .heading = 1e-3};
  auto sources = navigation::sensor_sources(mems(), states).sources;
  for (auto& source : initial_sources(initial, pad_axes())) sources.push_back(source);
  const auto budget = error_budget(timeline, sources);

  MonteCarlo::Options mc;
  mc.runs = 200;
  const auto flown = monte_carlo(timeline, mems(), initial, pad_axes(), {}, {}, mc);
  const auto band = navigation::sigma_ratio_band(mc.runs, 0.999);
  const auto linear = navigation::local_sigmas(budget.total.back(), pad_axes());
  const auto found = navigation::local_sigmas(flown.covariance(0), pad_axes());
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(band.holds(found.position[i] / linear.position[i]))
        << i << " " << found.position[i] / linear.position[i];
    EXPECT_TRUE(band.holds(found.velocity[i] / linear.velocity[i])) << i;
    EXPECT_TRUE(band.holds(found.attitude[i] / linear.attitude[i])) << i;
  }
  const auto nees = navigation::chi_square_mean_band(9, mc.runs, 0.999);
  EXPECT_TRUE(nees.holds(flown.mean_nees(0, budget.total.back()))) << flown.mean_nees(0, budget.total.back());
}
