// SPDX-License-Identifier: MIT
// The flight in closed loop with navigation in it.
#include "gyrobudget/estimation/closed_loop/study.h"

#include "gyrobudget/estimation/closed_loop/inertial_navigator.h"

#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "../../vehicle/flight/allocations.h"

namespace gyrobudget::closed_loop {
namespace {

using Eigen::Vector3d;

static_assert(flight::Navigator<InertialNavigator>);

constexpr double kDegreePerHour = earth::kDegree / 3600;

noise::SensorModel mems() {
  noise::SensorModel sensor;
  sensor.gyro.white = 0.15 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 0.70 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 4.32 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 1 * kDegreePerHour;
  sensor.gyro.powered_on_before = 600;
  return sensor;
}

navigation::Scenario strapdown_scene(const noise::SensorModel& sensor) {
  navigation::Scenario scene;
  scene.sensor = sensor;
  scene.alignment.level_sigma = 1e-4;
  scene.alignment.heading_sigma = 1e-3;
  return scene;
}

const flight::Dispersion kDispersion{
    .impulse = 0.005, .mass = 0.002, .axial_drag = 0.1, .thrust_misalignment = 1e-3, .wind = 5};

TEST(ClosedLoop, NavigationErrsAsTheOpenLoopBudgetSays) {
  const Study s = study({}, {}, strapdown_scene(mems()), {.runs = 200});
  ASSERT_EQ(s.sensors.complete(), 200);
  EXPECT_TRUE(s.vehicle.outcomes.empty());
  const auto found = navigation::local_sigmas(s.sensors.navigation_error(), s.C_enu);
  const auto linear = navigation::local_sigmas(s.budget->total.back(), s.C_enu);
  // Nine axes, false alarm 1e-3 in all.
  const auto band = navigation::sigma_ratio_band(200, 1 - 1e-3 / 9);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(band.holds(found.position[i] / linear.position[i])) << i;
    EXPECT_TRUE(band.holds(found.velocity[i] / linear.velocity[i])) << i;
    EXPECT_TRUE(band.holds(found.attitude[i] / linear.attitude[i])) << i;
  }
}

// The attitude loop steers by what navigation tells, so the true attitude is off by as much: biases and a wrong start,
// which the loop follows, without noise, which it does not.
TEST(ClosedLoop, SensorsDisperseTheFlightByTheirAttitudeError) {
  noise::SensorModel biased;
  biased.gyro.turn_on_bias = 10 * kDegreePerHour;
  const Study s = study({}, {}, strapdown_scene(biased), {.runs = 10});
  for (const Outcome& o : s.sensors.outcomes) {
    const Vector3d navigation = s.C_launch.transpose() * o.navigation.tail<3>();
    EXPECT_LT((o.attitude - navigation).norm(), 0.05 * navigation.norm());
    EXPECT_GT(o.position.norm(), 0.5);
  }
}

TEST(ClosedLoop, TheSameForOneThreadAndTwo) {
  const auto fly = [](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    return study({}, kDispersion, strapdown_scene(mems()), {.runs = 6, .seed = 5});
  };
  const Study one = fly(1), two = fly(2);
  for (const auto member : {&Study::sensors, &Study::vehicle, &Study::all}) {
    const auto &a = (one.*member).outcomes, &b = (two.*member).outcomes;
    ASSERT_EQ(a.size(), 6U);
    ASSERT_EQ(b.size(), 6U);
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].position, b[k].position);
      EXPECT_EQ(a[k].navigation, b[k].navigation);
    }
  }
}

TEST(ClosedLoop, RunKHasTheSameSensorsAndTheSameVehicleInEachKind) {
  const Study few = study({}, kDispersion, strapdown_scene(mems()), {.runs = 2});
  const Study more = study({}, kDispersion, strapdown_scene(mems()), {.runs = 4});
  EXPECT_EQ(few.all.outcomes[1].position, more.all.outcomes[1].position);
  // To first order departures add up.
  for (const auto& [a, b, both] :
       {std::tuple{more.sensors.outcomes[2], more.vehicle.outcomes[2], more.all.outcomes[2]}})
    EXPECT_LT((a.position + b.position - both.position).norm(),
              0.1 * std::min(a.position.norm(), b.position.norm()) + 0.5);
}

TEST(ClosedLoop, IdealSensorsFlyTheNominalFlight) {
  const Study s = study({}, {}, {}, {.runs = 3});
  ASSERT_TRUE(s.flown);
  EXPECT_TRUE(s.sensors.outcomes.empty());  // nothing to vary
  constexpr double kNavigation = 2e-6;      // [m]; as the strapdown's own test
  EXPECT_LT((s.flown->end.truth.p_eb_e - s.nominal.end.truth.p_eb_e).norm(), kNavigation);
}

TEST(ClosedLoop, NoiseThatIsSmallBindsNoLimitOfTheNozzle) {
  const Study s = study({}, {}, strapdown_scene(mems()), {.margins = false});
  ASSERT_TRUE(s.flown);
  EXPECT_TRUE(s.margins.points.empty());
  EXPECT_LT(s.flown->largest_deflection, 2 * earth::kDegree);  // of 3
  EXPECT_LT(s.flown->limited, 0.005) << "of the periods: the last, where the gains are capped";
}

TEST(ClosedLoop, AidsKeepTheErrorDown) {
  navigation::Scenario scene = strapdown_scene(mems());
  scene.aids.push_back({.name = "gnss", .sigma = Vector3d(2, 2, 4), .lever_arm = {1, 0, 0.5}});
  scene.aids.push_back({.name = "gnss.velocity",
                        .kind = navigation::Aid::Kind::velocity,
                        .sigma = Vector3d::Constant(0.05),
                        .lever_arm = {1, 0, 0.5}});
  const Study s = study({}, {}, scene, {.runs = 40});
  EXPECT_TRUE(s.aided);
  ASSERT_EQ(s.sensors.complete(), 40);
  const auto found = navigation::local_sigmas(s.sensors.navigation_error(), s.C_enu);
  const auto linear = navigation::local_sigmas(s.budget->total.back(), s.C_enu);
  EXPECT_LT(linear.position.norm(), 3);
  const auto band = navigation::sigma_ratio_band(40, 1 - 1e-3 / 9);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(band.holds(found.position[i] / linear.position[i])) << i;
    EXPECT_TRUE(band.holds(found.velocity[i] / linear.velocity[i])) << i;
    EXPECT_TRUE(band.holds(found.attitude[i] / linear.attitude[i])) << i;
  }
}

// A record without points; the scene and the navigator are made before.
TEST(ClosedLoop, TheLoopWithTheFilterAllocatesNothing) {
  navigation::Scenario scene = strapdown_scene(mems());
  scene.aids.push_back({.name = "gnss", .sigma = Vector3d(2, 2, 4)});
  const auto counted = [&](double duration) {
    flight::Plan plan;
    plan.flight.duration = duration;
    plan.flight.record_every = 0;
    const auto budget = budget::budget_scene(scene, trajectory(fly_nominal(plan)), {});
    const budget::MonteCarlo::Options options{.filter = scene.filter};
    const budget::SimulatedScene simulated(budget.timeline, scene.sensor, budget.initial, budget.C_enu, budget.design,
                                           budget.aids, options);
    InertialNavigator navigator(simulated, 0);
    const long before = allocations();
    (void)fly(plan, plan.flight, {}, navigator);
    return allocations() - before;
  };
  EXPECT_EQ(counted(3), counted(12));
}

budget::SimulatedScene simulated(double duration) {
  const navigation::Scenario scene = strapdown_scene(mems());
  flight::Plan plan;
  plan.flight.duration = duration;
  const auto made = budget::budget_scene(scene, trajectory(fly_nominal(plan)), {});
  return {made.timeline, scene.sensor, made.initial, made.C_enu, made.design, made.aids, {}};
}

// The scene that it was made of is gone.
TEST(InertialNavigator, KeepsWhatItNavigates) {
  InertialNavigator navigator(simulated(3), 0);
  const Vector3d start = navigator.state().p_eb_e;
  navigator.step({.velocity = {-9.8 * 0.01, 0, 0}}, 0.01);
  EXPECT_LT((navigator.state().p_eb_e - start).norm(), 1);
  EXPECT_FALSE(navigator.diverged());
}

TEST(InertialNavigator, TellsNoNumberOnceItHasDiverged) {
  InertialNavigator navigator(simulated(3), 0);
  navigator.step({.velocity = {1e300, 0, 0}}, 0.01);
  EXPECT_TRUE(navigator.diverged());
  EXPECT_FALSE(navigator.state().p_eb_e.allFinite());
  navigator.step({}, 0.01);  // nor ever again
  EXPECT_FALSE(navigator.state().q_eb.coeffs().allFinite());
  // An increment that is no number is a mistake of who calls.
  InertialNavigator other(simulated(3), 0);
  EXPECT_THROW(other.step({.velocity = {std::numeric_limits<double>::quiet_NaN(), 0, 0}}, 0.01), std::invalid_argument);
}

TEST(ClosedLoop, WhatACallerThrowsPassesThrough) {
  class Mistake : public std::invalid_argument {
   public:
    using std::invalid_argument::invalid_argument;
  };
  Options options{.runs = 1, .margins = false};
  options.progress = [](int, int) -> bool { throw Mistake("of the caller"); };
  flight::Plan plan;
  plan.flight.duration = 5;
  EXPECT_THROW((void)study(plan, kDispersion, strapdown_scene(mems()), options), Mistake);
}

TEST(ClosedLoop, PointsAreAsDenseAsAsked) {
  flight::Plan plan;
  plan.flight.duration = 5;
  const Study s = study(plan, {}, {}, {.margins = false, .record_rate = 20});
  ASSERT_TRUE(s.flown);
  EXPECT_NEAR(s.flown->points[1].t - s.flown->points[0].t, 0.05, 1e-9);
  const Study whole = study(plan, {}, {}, {.margins = false, .record_rate = 1e9});  // not more than every period
  EXPECT_NEAR(whole.flown->points[1].t - whole.flown->points[0].t, plan.flight.period, 1e-9);
}

// What the controller is told late is no error of navigation.
TEST(ClosedLoop, ADelayIsNoErrorOfNavigation) {
  flight::Plan plan;
  plan.flight.duration = 20;
  const Study prompt = study(plan, {}, strapdown_scene(mems()), {.runs = 2});
  plan.navigator_faults.delay = 0.05;
  const Study late = study(plan, {}, strapdown_scene(mems()), {.runs = 2});
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_TRUE(late.sensors.outcomes[k].counts());
    const double error = prompt.sensors.outcomes[k].navigation.head<3>().norm();
    EXPECT_NEAR(late.sensors.outcomes[k].navigation.head<3>().norm(), error, 0.05 * error);
  }
}

TEST(ClosedLoop, TheScenesVibrationReachesTheImu) {
  constexpr int kRuns = 40;
  noise::SensorModel sensor;
  sensor.gyro.vibration_rectification = 1 * kDegreePerHour / (9.80665 * 9.80665);
  navigation::Scenario scene;
  scene.sensor = sensor;
  scene.states.vibration = 5 * 9.80665;
  flight::Plan plan;
  plan.flight.duration = 30;
  const Study s = study(plan, {}, scene, {.runs = kRuns});
  const double found = navigation::local_sigmas(s.sensors.navigation_error(), s.C_enu).attitude.norm();
  const double linear = navigation::local_sigmas(s.budget->total.back(), s.C_enu).attitude.norm();
  EXPECT_TRUE(navigation::sigma_ratio_band(kRuns, 1 - 1e-3).holds(found / linear)) << found / linear;
}

TEST(ClosedLoop, LostFlightsAreCountedAndDoNotCount) {
  flight::Plan plan;
  plan.navigator_faults = {.dead_gyro = 1, .dead_gyro_at = 5};
  const Study s = study(plan, {}, strapdown_scene(mems()), {.runs = 4});
  EXPECT_EQ(s.nominal.ended, flight::Ended::complete);
  ASSERT_TRUE(s.flown);
  EXPECT_NE(s.flown->ended, flight::Ended::complete) << s.flown->account;
  EXPECT_EQ(s.sensors.lost(), 4);
  EXPECT_EQ(s.sensors.complete(), 0);
  EXPECT_EQ(s.sensors.spread(&Outcome::position).sigma(), Vector3d::Zero().eval());
}

TEST(ClosedLoop, AFlightThatEndsOnThePadHasAnAccount) {
  flight::Plan plan;
  plan.flight.faults.thrust_cut_at = 0;
  const Study s = study(plan, {}, strapdown_scene(mems()), {.runs = 4});
  EXPECT_EQ(s.nominal.ended, flight::Ended::complete);  // without faults
  ASSERT_TRUE(s.flown);
  EXPECT_EQ(s.flown->ended, flight::Ended::impact);
  EXPECT_EQ(s.sensors.lost(), 4);
}

TEST(ClosedLoop, AFlightTooShortToNavigateSaysSo) {
  flight::Plan plan;
  plan.flight.duration = 0.5;
  const Study s = study(plan, {}, strapdown_scene(mems()), {.runs = 4});
  EXPECT_TRUE(s.too_short());
  EXPECT_FALSE(s.flown);
  EXPECT_TRUE(s.sensors.outcomes.empty());
}

TEST(ClosedLoop, RefusedFixesAreCounted) {
  navigation::Scenario scene = strapdown_scene({});
  scene.gravity_sigma = 1e-3;  // of which a filter for ideal sensors knows nothing
  scene.aids.push_back({.name = "gnss", .sigma = Vector3d::Constant(0.01)});
  const Study s = study({}, {}, scene, {.runs = 2});
  for (const Outcome& o : s.sensors.outcomes) {
    EXPECT_EQ(o.fixes.given, 84);  // at 0, 1 ... 83 s
    EXPECT_GT(o.fixes.refused, 10);
  }
  EXPECT_EQ(s.sensors.fixes().given, 168);
  EXPECT_TRUE(s.sensors.fixes().beyond_chance());
}

TEST(ClosedLoop, StopsWhenAsked) {
  int calls = 0;
  const Study s =
      study({}, {}, strapdown_scene(mems()), {.runs = 50, .progress = [&](int, int) { return ++calls < 3; }});
  EXPECT_GE(s.runs, 3);
  EXPECT_LT(s.runs, 50);
  EXPECT_EQ(s.sensors.outcomes.size(), static_cast<std::size_t>(s.runs));
}

}  // namespace
}  // namespace gyrobudget::closed_loop
