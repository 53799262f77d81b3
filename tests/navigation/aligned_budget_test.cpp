// SPDX-License-Identifier: MIT
// Budgets of scenes that align themselves on the pad: what the alignment leaves is its sensors' doing.
#include "gyrobudget/earth/frames.h"
#include "gyrobudget/earth/paths.h"
#include "gyrobudget/navigation/scene_budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace gyrobudget;  // NOLINT
using Eigen::Vector3d;
using navigation::Budget;
using navigation::BudgetQuestion;
using navigation::BudgetScene;
using navigation::CoreMatrix;
using navigation::Scenario;
using noise::ErrorSource;

namespace {

constexpr double kMicroG = 9.80665e-6;
constexpr double kDegreePerHour = earth::kDegree / 3600;
constexpr double kPad = 60;

/// Every kind of error, none so large that linear theory fails.
noise::SensorModel fibre_optic() {
  noise::SensorModel sensor;
  sensor.gyro.white = 0.003 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 0.02 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 0.5 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 0.05 * kDegreePerHour;
  sensor.gyro.misalignment = 1e-4;
  sensor.gyro.powered_on_before = 120;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 5e-4;
  sensor.accelerometer->rate_random_walk = 5 * kMicroG;
  sensor.accelerometer->turn_on_bias = 100 * kMicroG;
  sensor.accelerometer->misalignment = 1e-4;
  return sensor;
}

Scenario on_the_pad() {
  Scenario scenario;
  scenario.site = earth::alcantara().position;
  scenario.sensor = fibre_optic();
  scenario.alignment.attitude = navigation::SelfAlignment{.duration = kPad, .heading = std::nullopt};
  return scenario;
}

earth::Trajectory short_climb() {
  earth::Climb climb;
  climb.acceleration = 8;
  climb.duration = 20;
  return earth::climb(climb);
}

BudgetQuestion at(std::vector<double> times) {
  BudgetQuestion question;
  question.step = 1;
  question.growth_points = 0;
  question.at = std::move(times);
  question.gravity = 20 * kMicroG;
  question.deflection = 1e-4;
  return question;
}

const CoreMatrix& covariance_of(const Budget& budget, std::string_view source, std::size_t i) {
  const auto line = std::ranges::find(budget.lines, source, &Budget::Line::name);
  if (line == budget.lines.end()) throw std::invalid_argument("no source " + std::string(source));
  return line->covariance[i];
}

}  // namespace

// Where the filter has seen nothing yet, each source's line is its part of the coarse alignment: closed forms.
TEST(AlignedBudget, StartsFromWhatEachSourceDoesToTheCoarseAlignment) {
  const BudgetScene scene = budget_scene(on_the_pad(), short_climb(), at({-kPad}));
  const Budget budget = error_budget(scene.timeline, scene.sources, scene.design);
  ASSERT_EQ(budget.times.front(), -kPad);
  const auto attitude = [&](std::string_view source) {
    return navigation::local_sigmas(covariance_of(budget, source, 0), scene.C_enu).attitude;
  };
  const noise::SensorModel sensor = fibre_optic();
  const double L = earth::alcantara().position.latitude, c = earth::wgs84::kEarthRate * std::cos(L);
  constexpr double g = 9.7803, P = 120;
  constexpr double kSame = 1e-3;  // gravity at the pad
  EXPECT_NEAR(attitude("gyro.arw").z() / (sensor.gyro.white / (c * std::sqrt(kPad))), 1, kSame);
  EXPECT_NEAR(attitude("gyro.turn_on_bias").z() / ((*sensor.gyro.turn_on_bias)[0] / c), 1, kSame);
  // The walk has gone on for P before the record, over which its mean moves by K sqrt(T/3).
  EXPECT_NEAR(attitude("gyro.rrw").z() / (sensor.gyro.rate_random_walk * std::sqrt(P + kPad / 3) / c), 1,
              kSame);
  for (const int level : {0, 1}) {
    EXPECT_LT(attitude("gyro.arw")[level], 1e-9 * attitude("gyro.arw").z() + 1e-10);
    const auto& a = *sensor.accelerometer;
    EXPECT_NEAR(attitude("accelerometer.turn_on_bias")[level] / ((*a.turn_on_bias)[0] / g), 1, kSame);
    EXPECT_NEAR(attitude("accelerometer.accel_rw")[level] / (a.rate_random_walk * std::sqrt(kPad / 3) / g), 1,
                kSame);
    EXPECT_NEAR(attitude("accelerometer.vrw")[level] / (a.white / (g * std::sqrt(kPad))), 1, kSame);
    EXPECT_NEAR(attitude("deflection")[level] / 1e-4, 1, kSame);
  }
  EXPECT_THROW((void)attitude("initial.heading"), std::invalid_argument);
  EXPECT_THROW((void)attitude("initial.level"), std::invalid_argument);
}

// Forwards, with what is gathered over the pad, and backwards through the alignment: one number.
TEST(AlignedBudget, ForwardAndBackwardAgreeOnThePadAndAfter) {
  const BudgetScene scene = budget_scene(on_the_pad(), short_climb(), at({-kPad, -25.5, 0, 10}));
  const auto gains = frozen_gains(scene.timeline, scene.design);
  const Budget budget = error_budget(scene.timeline, scene.sources, gains);
  constexpr double kRounding =
      1e-6;  // of a sigma's square, through Joseph updates of a start known to 5 sigma
  for (std::size_t i = 0; i < budget.times.size(); ++i) {
    const auto back = adjoint(scene.timeline, gains, budget.times[i]);
    for (const auto& source : scene.sources) {
      const CoreMatrix forward = covariance_of(budget, source.name, i);
      const CoreMatrix backward = state_response(back, scene.timeline, source);
      for (int k = 0; k < 9; ++k)
        EXPECT_NEAR(forward(k, k), backward(k, k), kRounding * forward(k, k) + 1e-12 * budget.total[i](k, k))
            << source.name << " at " << budget.times[i] << ", state " << k;
    }
  }
}

// One error at a time, alignment and filter on the same data as in the field: it is this error's line.
// 24 ratios at 1e-4 each: one false alarm in 400 seeds.
TEST(AlignedBudget, EachSourceAloneAgreesWithMonteCarlo) {
  const Scenario scenario = on_the_pad();
  BudgetQuestion question = at({-20});
  question.step =
      0.1;  // white noise between two zero-velocity updates moves position as it does velocity in finer steps
  const BudgetScene scene = budget_scene(scenario, short_climb(), question);
  const Budget budget = error_budget(scene.timeline, scene.sources, scene.design);
  constexpr double kRight = 1 - 1e-4;
  const auto fly = [&](std::string_view source, noise::ErrorSources gyro, noise::ErrorSources accelerometer) {
    navigation::MonteCarlo::Options options;
    options.runs = 250;
    options.imu_interval = 0.1;
    options.imu.gyro = gyro;
    options.imu.accelerometer = accelerometer;
    options.initial_errors = options.fix_noise = false;
    options.self_alignment = true;
    const auto flown = monte_carlo(scene.timeline, scenario.sensor, scene.initial, scene.C_enu, scene.design,
                                   scene.aids, options);
    const auto band = navigation::sigma_ratio_band(options.runs, kRight);
    for (std::size_t i = 0; i < budget.times.size(); ++i) {
      const auto found = navigation::local_sigmas(flown.covariance(i), scene.C_enu);
      const auto linear = navigation::local_sigmas(covariance_of(budget, source, i), scene.C_enu);
      // The axis that a source is felt in: heading and what it does across for gyros, level for accelerometers.
      const int axis = source.starts_with("gyro") ? 2 : 0;
      const double attitude = found.attitude[axis] / linear.attitude[axis];
      EXPECT_TRUE(band.holds(attitude)) << source << " at " << budget.times[i] << ", attitude " << attitude;
      const double position = found.position.norm() / linear.position.norm();
      EXPECT_TRUE(band.holds(position)) << source << " at " << budget.times[i] << ", position " << position;
    }
  };
  fly("gyro.arw", {ErrorSource::white}, {});
  fly("gyro.rrw", {ErrorSource::rate_random_walk}, {});
  fly("gyro.turn_on_bias", {ErrorSource::turn_on_bias}, {});
  fly("accelerometer.vrw", {}, {ErrorSource::white});
  fly("accelerometer.accel_rw", {}, {ErrorSource::rate_random_walk});
  fly("accelerometer.turn_on_bias", {}, {ErrorSource::turn_on_bias});
}

// A heading from outside keeps its own line; the sensors are charged with level alone.
TEST(AlignedBudget, AGivenHeadingStaysItsOwn) {
  Scenario scenario = on_the_pad();
  scenario.alignment.attitude = navigation::SelfAlignment{.duration = kPad, .heading = 0.0};
  scenario.alignment.heading_sigma = 1e-3;
  const BudgetScene scene = budget_scene(scenario, short_climb(), at({-kPad}));
  const Budget budget = error_budget(scene.timeline, scene.sources, scene.design);
  const auto attitude = [&](std::string_view source) {
    return navigation::local_sigmas(covariance_of(budget, source, 0), scene.C_enu).attitude;
  };
  EXPECT_NEAR(attitude("initial.heading").z(), 1e-3, 1e-12);
  EXPECT_EQ(attitude("gyro.turn_on_bias").norm(), 0);
  EXPECT_GT(attitude("accelerometer.turn_on_bias").x(), 5e-5);
}
