// SPDX-License-Identifier: MIT
// The strapdown as navigator of the closed loop: it meets the concept as it is.
#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/vehicle/flight/fly.h"

#include <gtest/gtest.h>

namespace gyrobudget::flight {
namespace {

using navigation::Strapdown;

static_assert(Navigator<Strapdown>);
static_assert(Navigator<PerfectNavigator>);
static_assert(Controller<AttitudeControl>);

struct Flown {
  FlightRecord perfect, strapdown;
};

Flown fly_both(Flight plan, const AttitudeControl::Options& options) {
  AttitudeControl first(plan.vehicle, plan.world.site, options);
  PerfectNavigator perfect;
  const FlightRecord with_truth = fly(plan, first, perfect);
  AttitudeControl second(plan.vehicle, plan.world.site, options);
  const earth::Pose pad = pose_on_pad(plan);
  Strapdown strapdown(pad, {.order = Strapdown::kHighestOrder});  // whose error is below rounding, bending included
  return {with_truth, fly(plan, second, strapdown)};
}

constexpr double kNavigation = 2e-6;  // [m]; rounding of 8300 steps at 6400 km, 1 nm each, is a tenth of it
constexpr double kAttitude = 1e-9;    // [rad]

TEST(Strapdown, InTheLoopWithAnIdealSensorReproducesThePerfectFlight) {
  const Flown flown = fly_both({}, {});
  ASSERT_EQ(flown.strapdown.ended, Ended::complete);
  const FlightPoint& end = flown.strapdown.end;
  EXPECT_LT((end.seen.p_eb_e - end.truth.p_eb_e).norm(), kNavigation);
  EXPECT_LT(end.seen.q_eb.angularDistance(end.truth.q_eb), kAttitude);
  EXPECT_LT((end.truth.p_eb_e - flown.perfect.end.truth.p_eb_e).norm(), kNavigation);
}

TEST(Strapdown, FollowsABendingVehicle) {
  Flight plan;
  plan.vehicle.bending = Bending{};
  const Flown flown = fly_both(plan, {.notches = {Notch{plan.vehicle.bending->frequency}}});
  ASSERT_EQ(flown.strapdown.ended, Ended::complete);
  const FlightPoint& end = flown.strapdown.end;
  EXPECT_LT((end.seen.p_eb_e - end.truth.p_eb_e).norm(), kNavigation);
  EXPECT_LT((end.truth.p_eb_e - flown.perfect.end.truth.p_eb_e).norm(), kNavigation);
}

}  // namespace
}  // namespace gyrobudget::flight
