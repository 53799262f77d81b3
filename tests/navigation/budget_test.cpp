// SPDX-License-Identifier: MIT
#include "gyrobudget/navigation/budget.h"

#include "gyrobudget/earth/attitude.h"
#include "gyrobudget/earth/frames.h"
#include "gyrobudget/earth/gravity.h"
#include "gyrobudget/earth/paths.h"
#include "gyrobudget/navigation/sensor_states.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace gyrobudget;  // NOLINT
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::CoreMatrix;
using navigation::Source;
using navigation::Timeline;

namespace {

constexpr double kForce = 16;  // [m/s^2]

// Upwards with a constant specific force.
earth::Trajectory climb(double duration) {
  earth::Climb climb;
  climb.acceleration = kForce - earth::normal_gravity(earth::to_ecef(climb.site)).norm();
  climb.duration = duration;
  return earth::climb(climb);
}

Source source(const noise::SensorModel& sensor, const navigation::SensorStates::Options& options) {
  const auto states = sensor_states(sensor, options);
  return {.name = "test", .model = states.model, .initial = states.initial};
}

// East-north-up sigmas of one source at the end.
navigation::LocalSigmas at_end(const earth::Trajectory& path, const Source& source, double step) {
  const auto frame = earth::LocalFrame::east_north_up(earth::alcantara().position);
  Timeline::Options options;
  options.step = step;
  const auto budget = error_budget(Timeline(path, {}, options), std::span(&source, 1));
  return navigation::local_sigmas(budget.total.back(), frame.C_el());
}

navigation::SensorStates::Options epoch_of(double length) {
  navigation::SensorStates::Options options;
  options.scene_length = length;
  return options;
}

}  // namespace

// Constant specific force along the vertical: each horizontal axis has f N sqrt(T^5/20), f K sqrt(T^7/252), f b T^3/6.
TEST(Budget, MeetsTheClosedFormsOfConstantForce) {
  constexpr double kScene = 10;  // [s]: what gravity's gradient adds is (T/800 s)^2/4, 4e-5; Earth's turn 7e-4/2
  constexpr double kPhysics = 4e-4;
  const auto path = climb(kScene);
  const struct {
    double noise::ErrorModel::* coefficient;
    double expected;
  } cases[] = {{&noise::ErrorModel::white, kForce * std::sqrt(std::pow(kScene, 5) / 20)},
               {&noise::ErrorModel::rate_random_walk, kForce * std::sqrt(std::pow(kScene, 7) / 252)}};
  for (const auto& c : cases) {
    noise::SensorModel sensor;
    sensor.gyro.*c.coefficient = 1;
    const auto sigma = at_end(path, source(sensor, epoch_of(kScene)), 0.02);
    EXPECT_NEAR(sigma.position.x() / c.expected, 1, kPhysics);
    EXPECT_NEAR(sigma.position.y() / c.expected, 1, kPhysics);
  }
  noise::SensorModel biased;
  biased.gyro.turn_on_bias = 1;
  EXPECT_NEAR(at_end(path, source(biased, epoch_of(kScene)), 0.02).position.x(),
              kForce * std::pow(kScene, 3) / 6, kPhysics * kForce * std::pow(kScene, 3) / 6);
}

// The error of a step falls with its square.
TEST(Budget, ConvergesWithTheSquareOfTheStep) {
  const auto path = earth::ascent({});
  noise::SensorModel sensor;
  sensor.gyro.white = 1e-5;
  sensor.gyro.rate_random_walk = 1e-7;
  const Source both = source(sensor, epoch_of(83));
  const double fine = at_end(path, both, 0.025).position.norm();
  const double error_1 = at_end(path, both, 1).position.norm() - fine;
  const double error_2 = at_end(path, both, 0.5).position.norm() - fine;
  printf("%g %g %g\n", fine, error_1, error_2);
  EXPECT_NEAR(error_1 / error_2, 4, 0.3);
}
TEST(Budget, Ascent) {
  const auto path = earth::ascent({});
  const double deg = earth::kDegree;
  for (int mems = 0; mems < 2; ++mems) {
    noise::SensorModel sensor;
    sensor.gyro.white = (mems ? 0.15 : 5.4e-4) * deg / 60;
    printf("ARW %g m\n", at_end(path, source(sensor, epoch_of(83)), 0.1).position.norm());
  }
  noise::SensorModel sensor;
  sensor.gyro.turn_on_bias = 0.01 * deg / 3600;
  printf("bias %g m\n", at_end(path, source(sensor, epoch_of(83)), 0.1).position.norm());
}
