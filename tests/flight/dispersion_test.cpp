// SPDX-License-Identifier: MIT
#include "gyrobudget/flight/dispersion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::flight {
namespace {

const Dispersion kAll{.impulse = 0.01,
                      .burn_time = 0.01,
                      .mass = 0.005,
                      .inertia = 0.05,
                      .axial_drag = 0.1,
                      .normal_force = 0.1,
                      .pressure_ahead = 0.2,
                      .thrust_misalignment = 1e-3,
                      .wind = 5,
                      .gust = 0.1};

TEST(Dispersion, WithoutAnyTheFlightIsTheSame) {
  Flight plan;
  const Flight same = disperse(plan, {}, 1, 7);
  EXPECT_TRUE(Dispersion{}.none());
  EXPECT_FALSE(kAll.none());
  EXPECT_EQ(same.vehicle.lift_off_mass, plan.vehicle.lift_off_mass);
  EXPECT_EQ(same.vehicle.axial_drag.points(), plan.vehicle.axial_drag.points());
  EXPECT_EQ(same.world.wind.steady, plan.world.wind.steady);
  EXPECT_EQ(same.faults.thrust_misalignment, plan.faults.thrust_misalignment);
}

// Mean and standard deviation over n runs, each within 4.9 sigma of its own spread: false alarm 1e-6 each.
TEST(Dispersion, HasTheSigmasAskedFor) {
  constexpr int kRuns = 5000;
  constexpr double kSigmas = 4.9;
  const Flight plan;
  struct Quantity {
    double sigma;
    double (*of)(const Flight& drawn);
    double sum = 0, squares = 0;
  };
  Quantity all[] = {
      {kAll.impulse,
       [](const Flight& f) { return f.vehicle.specific_impulse / vlm1().specific_impulse - 1; }},
      {kAll.burn_time, [](const Flight& f) { return f.vehicle.burn_time / vlm1().burn_time - 1; }},
      {kAll.mass, [](const Flight& f) { return f.vehicle.lift_off_mass / vlm1().lift_off_mass - 1; }},
      {kAll.inertia, [](const Flight& f) { return f.vehicle.yaw_inertia(0) / vlm1().yaw_inertia(0) - 1; }},
      {kAll.axial_drag, [](const Flight& f) { return f.vehicle.axial_drag(1) / vlm1().axial_drag(1) - 1; }},
      {kAll.normal_force,
       [](const Flight& f) { return f.vehicle.normal_force_slope / vlm1().normal_force_slope - 1; }},
      {kAll.pressure_ahead, [](const Flight& f) { return f.vehicle.pressure_ahead - vlm1().pressure_ahead; }},
      {kAll.thrust_misalignment, [](const Flight& f) { return f.faults.thrust_misalignment[0]; }},
      {kAll.thrust_misalignment, [](const Flight& f) { return f.faults.thrust_misalignment[1]; }},
      {kAll.wind, [](const Flight& f) { return f.world.wind.steady.x(); }},
      {kAll.wind, [](const Flight& f) { return f.world.wind.steady.y(); }},
  };
  for (int run = 0; run < kRuns; ++run) {
    const Flight drawn = disperse(plan, kAll, 3, static_cast<std::uint64_t>(run));
    for (Quantity& q : all) {
      const double x = q.of(drawn);
      q.sum += x;
      q.squares += x * x;
    }
  }
  for (const Quantity& q : all) {
    EXPECT_LT(std::abs(q.sum / kRuns), kSigmas * q.sigma / std::sqrt(kRuns)) << &q - all;
    EXPECT_NEAR(std::sqrt(q.squares / kRuns) / q.sigma, 1, kSigmas / std::sqrt(2.0 * kRuns)) << &q - all;
  }
}

TEST(Dispersion, EachQuantityHasNumbersOfItsOwn) {
  Dispersion windless = kAll;
  windless.wind = 0;
  const Flight with = disperse({}, kAll, 1, 4), without = disperse({}, windless, 1, 4);
  EXPECT_NE(with.world.wind.steady, without.world.wind.steady);
  EXPECT_EQ(with.vehicle.lift_off_mass, without.vehicle.lift_off_mass);
  EXPECT_EQ(with.faults.thrust_misalignment, without.faults.thrust_misalignment);
  EXPECT_NE(disperse({}, kAll, 1, 5).vehicle.lift_off_mass, with.vehicle.lift_off_mass);
  EXPECT_NE(disperse({}, kAll, 2, 4).vehicle.lift_off_mass, with.vehicle.lift_off_mass);
}

TEST(Dispersion, RefusesWhatCouldLeaveAVehicleThatCannotBe) {
  EXPECT_THROW((void)disperse({}, {.impulse = -0.1}, 1, 1), std::invalid_argument);
  EXPECT_THROW((void)disperse({}, {.wind = std::numeric_limits<double>::infinity()}, 1, 1),
               std::invalid_argument);
  EXPECT_THROW((void)disperse({}, {.axial_drag = 0.12}, 1, 1), std::invalid_argument);
  EXPECT_THROW((void)disperse({}, {.mass = 0.07}, 1, 1), std::invalid_argument);  // 12 of 28 t are propellant
  EXPECT_NO_THROW((void)disperse({}, {.mass = 0.06}, 1, 1));
}

TEST(Dispersion, MisalignedThrustLeavesTheAttitudeOffset) {
  Flight plan;
  plan.faults.thrust_misalignment = {2e-3, 0};
  AttitudeControl control(plan.vehicle, plan.world.site, {});
  PerfectNavigator navigator;
  const FlightRecord record = fly(plan, control, navigator);
  // The loop holds against it with the nozzle turned back by as much; at 40 s all else is small.
  const FlightPoint& p = record.points[400];
  EXPECT_NEAR(p.deflection[0], -2e-3, 1e-3);
  const double off = p.truth.q_eb.angularDistance(control.reference(p.t));
  // w^2 off = (F arm/I) misalignment, for a loop that asks w^2 off / gain of the nozzle.
  const double expected = 2e-3 / (control.gain(p.t)[0] * 2.5 * 2.5);
  EXPECT_NEAR(off, expected, 0.25 * expected);
}

}  // namespace
}  // namespace gyrobudget::flight
