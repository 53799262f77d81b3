// SPDX-License-Identifier: MIT
// What is beyond attitude: following a trajectory, and the point mass.
#include "gyrobudget/vehicle/flight/guidance.h"

#include "gyrobudget/vehicle/flight/point_mass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::flight {
namespace {

using Eigen::Vector3d;

AttitudeControl control_of(const Flight& plan) { return {plan.vehicle, plan.world.site, {}}; }

FlightRecord fly_attitude(const Flight& plan) {
  AttitudeControl control = control_of(plan);
  PerfectNavigator navigator;
  return fly(plan, control, navigator);
}
FlightRecord fly_trajectory(const Flight& plan, const FlightRecord& nominal) {
  TrajectoryControl control(control_of(plan), waypoints(nominal), {});
  PerfectNavigator navigator;
  return fly(plan, control, navigator);
}

/// Miss of the nominal end, along the nominal velocity and across it.
struct Miss {
  double along, across;
};
Miss miss(const FlightRecord& record, const FlightRecord& nominal) {
  const Vector3d gap = record.end.truth.p_eb_e - nominal.end.truth.p_eb_e;
  const Vector3d way = nominal.end.truth.v_eb_e.normalized();
  return {gap.dot(way), (gap - way * way.dot(gap)).norm()};
}

TEST(Guidance, ChangesNothingOnTheNominalTrajectory) {
  const Flight plan;
  const FlightRecord nominal = fly_attitude(plan);
  const Miss off = miss(fly_trajectory(plan, nominal), nominal);
  EXPECT_LT(std::hypot(off.along, off.across), 0.1);
}

TEST(Guidance, TakesOutWhatWindDoesAcrossTheTrajectory) {
  Flight plan;
  const FlightRecord nominal = fly_attitude(plan);
  plan.world.wind.steady = {0, 10, 0};
  const FlightRecord drifted = fly_attitude(plan), guided = fly_trajectory(plan, nominal);
  ASSERT_EQ(guided.ended, Ended::complete) << guided.account;
  EXPECT_GT(miss(drifted, nominal).across, 200);
  EXPECT_LT(miss(guided, nominal).across, 0.2 * miss(drifted, nominal).across);
}

TEST(Guidance, InterpolatesItsWaypointsSmoothly) {
  const Flight plan;
  const FlightRecord nominal = fly_attitude(plan);
  Flight fine = plan;
  fine.record_every = 1;
  const FlightRecord all = fly_attitude(fine);
  const TrajectoryControl control(control_of(plan), waypoints(nominal), {});
  for (const FlightPoint& p : all.points) {
    EXPECT_LT((control.reference(p.t).p_eb_e - p.truth.p_eb_e).norm(), 1e-3) << p.t;
    EXPECT_LT((control.reference(p.t).v_eb_e - p.truth.v_eb_e).norm(), 0.02) << p.t;
  }
  const Waypoint later = control.reference(93);
  EXPECT_LT((later.p_eb_e - nominal.end.truth.p_eb_e - 10 * nominal.end.truth.v_eb_e).norm(), 1e-6);
}

TEST(Guidance, RefusesMisuse) {
  const Flight plan;
  const AttitudeControl control = control_of(plan);
  const Waypoint a{0, Vector3d::Zero(), Vector3d::Zero()}, b{1, Vector3d::Zero(), Vector3d::Zero()};
  EXPECT_THROW(TrajectoryControl(control, {a}, {}), std::invalid_argument);
  EXPECT_THROW(TrajectoryControl(control, {b, a}, {}), std::invalid_argument);
  EXPECT_THROW(TrajectoryControl(control, {a, b}, {.frequency = 0}), std::invalid_argument);
}

TEST(PointMass, IsNearTheWholeFlight) {
  Flight plan;
  plan.vehicle.imu_station = 7;  // where the whole flight's centre of mass begins
  const AttitudeControl control = control_of(plan);
  const FlightRecord point = fly_point_mass(plan, control), whole = fly_attitude(plan);
  EXPECT_EQ(point.ended, Ended::complete);
  EXPECT_EQ(point.end.t, 83);
  EXPECT_LT((point.end.truth.p_eb_e - whole.end.truth.p_eb_e).norm(), 150);
  EXPECT_NEAR(point.highest_pressure / whole.highest_pressure, 1, 0.01);
}

TEST(PointMass, ConvergesWithItsStep) {
  const Flight plan;
  const AttitudeControl control = control_of(plan);
  const auto end = [&](double step) { return fly_point_mass(plan, control, step).end.truth.p_eb_e; };
  EXPECT_LT((end(0.1) - end(0.005)).norm(), 2e-3);
}

TEST(PointMass, ComesDownWithoutThrust) {
  Flight plan;
  plan.faults.thrust_cut_at = 20;
  plan.duration = 300;
  const FlightRecord record = fly_point_mass(plan, control_of(plan));
  EXPECT_EQ(record.ended, Ended::impact) << record.account;
  EXPECT_THROW((void)fly_point_mass(plan, control_of(plan), 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::flight
