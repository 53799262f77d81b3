// SPDX-License-Identifier: MIT
// Budgets of scenes that align themselves on the pad: what the alignment leaves is its sensors' doing.
#include "gyrobudget/estimation/budget/alignment_time.h"
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/budget/scene_runs.h"
#include "gyrobudget/estimation/navigation/alignment.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "../navigation/sensors.h"

using namespace gyrobudget;  // NOLINT
using budget::Budget;
using budget::BudgetQuestion;
using budget::BudgetScene;
using Eigen::Vector3d;
using navigation::CoreMatrix;
using navigation::Scenario;
using tests::kDegreePerHour;
using tests::kMicroG;

namespace {

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
  const auto line = std::ranges::find(budget.lines, source, &Budget::Contribution::name);
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
  EXPECT_NEAR(attitude("gyro.arw").z() / (sensor.gyro.white[0] / (c * std::sqrt(kPad))), 1, kSame);
  EXPECT_NEAR(attitude("gyro.turn_on_bias").z() / ((*sensor.gyro.turn_on_bias)[0] / c), 1, kSame);
  // The walk has gone on for P before the record, over which its mean moves by K sqrt(T/3).
  EXPECT_NEAR(attitude("gyro.rrw").z() / (sensor.gyro.rate_random_walk[0] * std::sqrt(P + kPad / 3) / c), 1, kSame);
  for (const int level : {0, 1}) {
    EXPECT_LT(attitude("gyro.arw")[level], 1e-9 * attitude("gyro.arw").z() + 1e-10);
    const auto& a = *sensor.accelerometer;
    EXPECT_NEAR(attitude("accelerometer.turn_on_bias")[level] / ((*a.turn_on_bias)[0] / g), 1, kSame);
    EXPECT_NEAR(attitude("accelerometer.accel_rw")[level] / (a.rate_random_walk[0] * std::sqrt(kPad / 3) / g), 1,
                kSame);
    EXPECT_NEAR(attitude("accelerometer.vrw")[level] / (a.white[0] / (g * std::sqrt(kPad))), 1, kSame);
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
  constexpr double kRounding = 1e-6;  // of a sigma's square, through Joseph updates of a start known to 5 sigma
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
  Scenario scenario = on_the_pad();
  // The P0 of a gyro that has wandered for two minutes lets more noise take the heading beyond linear theory.
  scenario.sensor.accelerometer->white = 1e-4;
  BudgetQuestion question = at({-20});
  question.step =
      0.1;  // white noise between two zero-velocity updates moves position as it does velocity in finer steps
  const BudgetScene scene = budget_scene(scenario, short_climb(), question);
  const Budget budget = error_budget(scene.timeline, scene.sources, scene.design);
  constexpr double kRight = 1 - 1e-4;
  const auto expect_line = [&](std::string_view source) {
    budget::MonteCarlo::Options options;
    options.runs = 250;
    options.imu_interval = 0.1;
    const auto flown =
        fly_alone(scene, scenario, *std::ranges::find(scene.sources, source, &budget::Source::name), options);
    ASSERT_TRUE(flown);
    const auto band = navigation::sigma_ratio_band(options.runs, kRight);
    for (std::size_t i = 0; i < budget.times.size(); ++i) {
      const auto found = navigation::local_sigmas(flown->covariance(i), scene.C_enu);
      const auto linear = navigation::local_sigmas(covariance_of(budget, source, i), scene.C_enu);
      // The axis that a source is felt in: heading and what it does across for gyros, level for accelerometers.
      const int axis = source.starts_with("gyro") ? 2 : 0;
      const double attitude = found.attitude[axis] / linear.attitude[axis];
      EXPECT_TRUE(band.holds(attitude)) << source << " at " << budget.times[i] << ", attitude " << attitude;
      const double position = found.position.norm() / linear.position.norm();
      EXPECT_TRUE(band.holds(position)) << source << " at " << budget.times[i] << ", position " << position;
    }
  };
  for (const auto* source : {"gyro.arw", "gyro.rrw", "gyro.turn_on_bias", "accelerometer.vrw", "accelerometer.accel_rw",
                             "accelerometer.turn_on_bias"})
    expect_line(source);
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

// Gyrocompass of white noise N: heading N/(c sqrt(T)), which goes to crossrange by what a unit of heading does there,
// beside what the noise does in flight. Both factors come from budgets of a given start.
TEST(AlignmentTime, OfWhiteNoiseIsItsClosedForm) {
  Scenario scenario = on_the_pad();
  scenario.sensor = {};
  scenario.sensor.gyro.white = 0.03 * earth::kDegree / 60;
  const earth::Trajectory path = earth::ascent({});
  BudgetQuestion question;
  question.step = 1;
  question.growth_points = 0;

  Scenario given = scenario;
  given.alignment.attitude = earth::Euler{};
  given.alignment.heading_sigma = 1;
  const BudgetScene unaided = budget_scene(given, path, question);
  const Budget factors = error_budget(unaided.timeline, unaided.sources);
  const Eigen::Matrix<double, 3, Eigen::Dynamic> axes = unaided.C_launch.col(1);
  const auto variance = [&](std::string_view source) {
    return (axes.transpose() * covariance_of(factors, source, 0).block<3, 3>(0, 0) * axes).trace();
  };
  const double by_heading = variance("initial.heading"), in_flight = variance("gyro.arw");
  const double c = earth::wgs84::kEarthRate * std::cos(earth::alcantara().position.latitude);
  constexpr double kWanted = 300;
  const double heading = scenario.sensor.gyro.white[0] / (c * std::sqrt(kWanted));
  const double limit = std::sqrt(heading * heading * by_heading + in_flight);
  const auto found = alignment_time(scenario, path, question, path.duration(), axes, limit);
  ASSERT_TRUE(found.met);
  constexpr double kPhysics = 0.03;  // bisection to 1 %, sway of the pad, the filter's looser start
  EXPECT_NEAR(found.duration / kWanted, 1, kPhysics);
  EXPECT_LE(found.sigma, limit);

  // White noise alone: the longer the better, and never better than in flight.
  const auto never = alignment_time(scenario, path, question, path.duration(), axes, std::sqrt(in_flight));
  EXPECT_FALSE(never.met);
  EXPECT_EQ(never.duration, budget::kLongestAlignment);
  // A walk that grows beside it: there is a best duration in between.
  scenario.sensor.gyro.rate_random_walk = 5 * kDegreePerHour / 60;
  const auto best = alignment_time(scenario, path, question, path.duration(), axes, std::sqrt(in_flight));
  EXPECT_FALSE(best.met);
  EXPECT_LT(best.duration, budget::kLongestAlignment / 2);
  EXPECT_GT(best.duration, budget::kShortestAlignment);

  EXPECT_THROW((void)alignment_time(given, path, question, path.duration(), axes, 1), std::invalid_argument);
  EXPECT_THROW((void)alignment_time(scenario, path, question, path.duration(), axes, 0), std::invalid_argument);
}

// A rest aid that is out says nothing then, on the pad as in flight.
TEST(AlignedBudget, ARestAidsOutagesHoldOnThePad) {
  Scenario scenario = on_the_pad();
  navigation::Aid rest;
  rest.name = "rest";
  rest.kind = navigation::Aid::Kind::rest;
  rest.sigma = Vector3d::Constant(1e-3);
  rest.valid.to = 8;
  scenario.aids = {rest};
  EXPECT_EQ(budget_scene(scenario, short_climb(), at({})).timeline.fixes().size(), 60u);
  scenario.aids[0].outages = {{-30.5, -10.5}};
  EXPECT_EQ(budget_scene(scenario, short_climb(), at({})).timeline.fixes().size(), 40u);
  scenario.aids[0].outages = {{-100, 100}};
  EXPECT_TRUE(budget_scene(scenario, short_climb(), at({})).timeline.fixes().empty());
}

// The mean that a simulated IMU has of its ramp over the record is the bias that the alignment counts with.
TEST(Alignment, CountsTheMeanOfARamp) {
  constexpr double kRamp = 1e-10, kTime = 60, kDt = 0.1;
  for (const double before : {0.0, 100.0}) {
    noise::SensorModel sensor;
    sensor.gyro.rate_ramp = kRamp;
    sensor.gyro.powered_on_before = before;
    noise::Imu imu(sensor, kDt, {});
    double angle = 0;
    for (int k = 0; k < static_cast<int>(kTime / kDt); ++k) angle += imu.next({}).angle[1];
    const double c = earth::wgs84::kEarthRate;
    navigation::AlignmentOptions options;
    options.sensor = sensor;
    options.latitude = 0;
    const auto found =
        navigation::align(navigation::StaticMeans{Vector3d(0, 0, -9.78), Vector3d(c, 0, 0), kTime}, options);
    constexpr double kSample = 0.01;  // the ramp is counted from a sample's start, or its end
    EXPECT_NEAR(found.parts.bias.z() / (angle / kTime / c), 1, kSample) << before;
  }
}
