// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/budget/monte_carlo.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../navigation/sensors.h"

using namespace gyrobudget;  // NOLINT
using budget::MonteCarlo;
using budget::Source;
using budget::Timeline;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::CoreMatrix;

namespace {

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
  const budget::InitialErrors initial{.velocity = {0.01, 0.01, 0.01}, .level = 1e-4, .heading = 1e-3};
  auto sources = budget::sensor_sources(tests::mems_imu(), states).sources;
  for (auto& source : initial_sources(initial, pad_axes())) sources.push_back(source);
  const auto budget = error_budget(timeline, sources);

  MonteCarlo::Options mc;
  mc.runs = 200;
  const auto flown = monte_carlo(timeline, tests::mems_imu(), initial, pad_axes(), {}, {}, mc);
  const auto band = navigation::sigma_ratio_band(mc.runs, 0.999);
  const auto linear = navigation::local_sigmas(budget.total.back(), pad_axes());
  const auto found = navigation::local_sigmas(flown.covariance(0), pad_axes());
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(band.holds(found.position[i] / linear.position[i]))
        << i << " " << found.position[i] / linear.position[i];
    EXPECT_TRUE(band.holds(found.velocity[i] / linear.velocity[i])) << i;
    EXPECT_TRUE(band.holds(found.attitude[i] / linear.attitude[i])) << i;
  }
  const auto nees = flown.nees(0, budget.total.back(), pad_axes());
  EXPECT_TRUE(navigation::chi_square_mean_band(nees.dof, mc.runs, 0.999).holds(nees.mean)) << nees.mean;
}

// A trajectory and fixes that do not fall on IMU samples: at 340 m/s, truth of another instant would be metres.
TEST(MonteCarlo, PutsTimesOnSamplesWithTheTruthOfThatInstant) {
  const auto path = earth::cruise({.speed = 340, .duration = 5.037});
  Timeline::Options options;
  options.report = {0.004, 2.0049};
  const auto place = [&](double t) {
    return navigation::PlannedFix{
        t, navigation::PositionFix{.p_eb_e = path.at(t).pose.p_eb_e, .sigma = Vector3d::Constant(0.01), .aid = 0}};
  };
  const Timeline timeline(path, {place(1.004), place(3.0149), place(5.036)}, options);
  budget::Design design;
  design.initial = 1e-6 * navigation::StateMatrix::Identity(navigation::kCoreStates, navigation::kCoreStates);
  MonteCarlo::Options mc;
  mc.runs = 1;
  mc.noisy_aid = -1;
  mc.filter.gate_false_alarm = 0;
  for (const bool aided : {false, true}) {
    const Timeline unaided(path, {}, options);
    const auto flown = monte_carlo(aided ? timeline : unaided, {}, {}, pad_axes(),
                                   aided ? std::optional(design) : std::nullopt, {}, mc);
    ASSERT_EQ(flown.errors.size(), 1U);
    ASSERT_EQ(flown.errors[0].size(), flown.times.size());
    constexpr double kStrapdown = 1e-5;  // [m] ideal sensors, 5 s at 100 Hz
    for (const auto& error : flown.errors[0]) EXPECT_LT(error.head<3>().norm(), kStrapdown) << aided;
  }
  mc.imu_interval = 6;
  EXPECT_THROW((void)monte_carlo(Timeline(path, {}, options), {}, {}, pad_axes(), {}, {}, mc), std::invalid_argument);
}

// The gyros' noise alone leaves the speed along a thrust that hardly turns without error of first order: what is found
// there is of second order, far above what the covariance has and far below a sigma.
TEST(MonteCarloOfAnAscent, NEESLeavesOutWhereTheFirstOrderHasNothing) {
  const auto path = earth::ascent({});
  Timeline::Options options;
  options.step = 0.25;
  const Timeline timeline(path, {}, options);
  navigation::SensorStates::Options states;
  states.scene_length = path.duration();
  noise::SensorModel gyros;
  gyros.gyro = tests::mems_imu().gyro;
  gyros.gyro.turn_on_bias.reset();
  gyros.gyro.scale_factor.reset();
  gyros.gyro.misalignment.reset();
  const CoreMatrix P = error_budget(timeline, budget::sensor_sources(gyros, states).sources).total.back();
  MonteCarlo::Options mc;
  mc.runs = 300;
  mc.imu_interval = 0.04;
  const auto flown = monte_carlo(timeline, gyros, {}, pad_axes(), {}, {}, mc);
  const auto nees = flown.nees(0, P, pad_axes());
  EXPECT_EQ(nees.dof, 8);
  ASSERT_EQ(nees.left_out.size(), 1U);
  EXPECT_GT(nees.left_out[0].found, 2 * nees.left_out[0].linear);
  EXPECT_LT(nees.left_out[0].found, 0.01);
  const auto band = navigation::chi_square_mean_band(8, mc.runs, 0.999);
  EXPECT_TRUE(band.holds(nees.mean)) << nees.mean;
  // All nine together would have called a right covariance wrong.
  double all = 0;
  for (const auto& run : flown.errors) all += navigation::nees(run[0], P) / mc.runs;
  EXPECT_GT(all, navigation::chi_square_mean_band(9, mc.runs, 0.999).upper);
  EXPECT_THROW((void)flown.nees(1, P, pad_axes()), std::out_of_range);
  EXPECT_THROW((void)MonteCarlo().covariance(0), std::invalid_argument);
}

// A start in motion is a start in motion: a cruise, errors of the sensors alone.
TEST(MonteCarloOfACruise, StartsAtTheTrajectorysSpeed) {
  const auto path = earth::cruise({.speed = 250, .duration = 20});
  const Timeline timeline(path, {}, {});
  MonteCarlo::Options options;
  options.runs = 1;
  const auto flown = monte_carlo(timeline, {}, {}, pad_axes(), {}, {}, options);
  EXPECT_LT(flown.errors[0].back().head<3>().norm(), 1e-3);
  EXPECT_NEAR(timeline.at(0).pose.v_eb_e.norm(), 250, 3);
}

// Gyros that cannot see Earth's rate find no heading: such runs are counted, not flown from the truth.
TEST(MonteCarloOnThePad, CountsRunsThatFoundNoHeading) {
  noise::SensorModel blind;
  blind.gyro.turn_on_bias = 1000 * tests::kDegreePerHour;
  Timeline::Options options;
  options.pad = 20;
  options.step = 1;
  const auto path = earth::ascent({});
  const Timeline timeline(path, {}, options);
  MonteCarlo::Options mc;
  mc.runs = 4;
  mc.self_alignment = true;
  const auto flown = monte_carlo(timeline, blind, {}, pad_axes(), {}, {}, mc);
  EXPECT_EQ(flown.unaligned, 4);
  EXPECT_EQ(flown.runs, 0);
  mc.heading_sigma = 0.01;
  EXPECT_EQ(monte_carlo(timeline, blind, {}, pad_axes(), {}, {}, mc).runs, 4);
}
