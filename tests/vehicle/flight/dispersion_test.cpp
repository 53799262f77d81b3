// SPDX-License-Identifier: MIT
#include "gyrobudget/vehicle/flight/dispersion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace gyrobudget::flight {
namespace {

const Dispersion kAll{.impulse = 0.01,
                      .burn_time = 0.01,
                      .mass = 0.005,
                      .inertia = 0.05,
                      .axial_drag = 0.1,
                      .normal_force = 0.1,
                      .pressure_ahead = 0.2,
                      .centre_of_mass = 0.1,
                      .thrust_misalignment = 1e-3,
                      .wind = 5,
                      .gust = 0.1};

/// To the last bit; what a dispersion changes, and how it flies.
void expect_same(const Flight& a, const Flight& b) {
  const Vehicle &x = a.vehicle, &y = b.vehicle;
  EXPECT_EQ(x.specific_impulse, y.specific_impulse);
  EXPECT_EQ(x.burn_time, y.burn_time);
  EXPECT_EQ(x.lift_off_mass, y.lift_off_mass);
  EXPECT_EQ(x.axial_drag.points(), y.axial_drag.points());
  EXPECT_EQ(x.normal_force_slope, y.normal_force_slope);
  EXPECT_EQ(x.pressure_ahead, y.pressure_ahead);
  EXPECT_EQ(x.centre_of_mass.points(), y.centre_of_mass.points());
  EXPECT_EQ(x.roll_inertia.points(), y.roll_inertia.points());
  EXPECT_EQ(x.pitch_inertia.points(), y.pitch_inertia.points());
  EXPECT_EQ(x.yaw_inertia.points(), y.yaw_inertia.points());
  EXPECT_EQ(a.faults.thrust_misalignment, b.faults.thrust_misalignment);
  EXPECT_EQ(a.world.wind.steady, b.world.wind.steady);
  EXPECT_EQ(a.world.wind.gust.peak, b.world.wind.gust.peak);
}

Flight gusty() {
  Flight plan;
  plan.world.wind.steady = {3, -2, 0};
  plan.world.wind.gust = {.height = 8000, .half_width = 500, .peak = {10, 0, 0}};
  plan.faults.thrust_misalignment = {1e-3, 0};
  return plan;
}

TEST(Dispersion, WithoutAnyTheFlightIsTheSame) {
  EXPECT_TRUE(Dispersion{}.none());
  EXPECT_FALSE(kAll.none());
  expect_same(disperse(gusty(), {}, 1, 7), gusty());
}

TEST(Dispersion, ARunIsTheSameInAnyOrder) {
  const Flight first = disperse(gusty(), kAll, 5, 11);
  (void)disperse(gusty(), kAll, 5, 12);
  expect_same(disperse(gusty(), kAll, 5, 11), first);
}

// Mean and standard deviation over n runs, each within 4.9 sigma of its own spread: false alarm 1e-6 each. No
// two quantities hang together: their correlation, of standard deviation 1/sqrt(n), so too.
TEST(Dispersion, HasTheSigmasAskedFor) {
  constexpr int kRuns = 10000;
  constexpr double kSigmas = 4.9;
  const Flight plan = gusty();
  struct Quantity {
    double sigma;
    double (*of)(const Flight& drawn);
    double sum = 0, squares = 0;
    std::vector<double> drawn;
  };
  Quantity all[] = {
      {kAll.impulse, [](const Flight& f) { return f.vehicle.specific_impulse / vlm1().specific_impulse - 1; }},
      {kAll.burn_time, [](const Flight& f) { return f.vehicle.burn_time / vlm1().burn_time - 1; }},
      {kAll.mass, [](const Flight& f) { return f.vehicle.lift_off_mass / vlm1().lift_off_mass - 1; }},
      {kAll.inertia, [](const Flight& f) { return f.vehicle.yaw_inertia(0) / vlm1().yaw_inertia(0) - 1; }},
      {kAll.axial_drag, [](const Flight& f) { return f.vehicle.axial_drag(1) / vlm1().axial_drag(1) - 1; }},
      {kAll.normal_force, [](const Flight& f) { return f.vehicle.normal_force_slope / vlm1().normal_force_slope - 1; }},
      {kAll.pressure_ahead, [](const Flight& f) { return f.vehicle.pressure_ahead - vlm1().pressure_ahead; }},
      {kAll.thrust_misalignment, [](const Flight& f) { return f.faults.thrust_misalignment[0] - 1e-3; }},
      {kAll.thrust_misalignment, [](const Flight& f) { return f.faults.thrust_misalignment[1]; }},
      {kAll.wind, [](const Flight& f) { return f.world.wind.steady.x() - 3; }},
      {kAll.wind, [](const Flight& f) { return f.world.wind.steady.y() + 2; }},
      {kAll.gust, [](const Flight& f) { return f.world.wind.gust.peak.x() / 10 - 1; }},
      {kAll.centre_of_mass, [](const Flight& f) { return f.vehicle.centre_of_mass(0.5) - 8.5; }},
  };
  for (int run = 0; run < kRuns; ++run) {
    const Flight drawn = disperse(plan, kAll, 3, static_cast<std::uint64_t>(run));
    for (Quantity& q : all) {
      const double x = q.of(drawn);
      q.sum += x;
      q.squares += x * x;
      q.drawn.push_back(x / q.sigma);
    }
  }
  for (const Quantity& q : all) {
    EXPECT_LT(std::abs(q.sum / kRuns), kSigmas * q.sigma / std::sqrt(kRuns)) << &q - all;
    EXPECT_NEAR(std::sqrt(q.squares / kRuns) / q.sigma, 1, kSigmas / std::sqrt(2.0 * kRuns)) << &q - all;
    for (const Quantity* other = all; other != &q; ++other) {
      const double correlation = std::inner_product(q.drawn.begin(), q.drawn.end(), other->drawn.begin(), 0.0) / kRuns;
      EXPECT_LT(std::abs(correlation), kSigmas / std::sqrt(kRuns)) << &q - all << " " << other - all;
    }
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
  EXPECT_THROW((void)disperse({}, {.wind = std::numeric_limits<double>::infinity()}, 1, 1), std::invalid_argument);
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
