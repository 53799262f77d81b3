// SPDX-License-Identifier: MIT
// What a study of flights comes to, by hand-made studies.
#include "gyrobudget/estimation/closed_loop/summary.h"

#include "gyrobudget/estimation/closed_loop/flight_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include <Eigen/Geometry>

namespace gyrobudget::closed_loop {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = earth::kDegree;

// The nose in the launch plane's axes, turned by hand.
TEST(FlightFrame, AttitudeIsRegularOnThePad) {
  const Eigen::Matrix3d C = earth::LocalFrame::launch_plane({0.1, 0.2, 0}, 0.3).C_el();
  const auto body = [&](double pitch, double yaw, double roll) {
    const Eigen::Matrix3d C_lb =
        (Eigen::AngleAxisd(pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) *
         Eigen::AngleAxisd(roll, Vector3d::UnitX()))
            .toRotationMatrix();
    return Eigen::Quaterniond(C * Vector3d(1, -1, -1).asDiagonal() * C_lb);
  };
  constexpr double kRounding = 1e-14;
  for (const double pitch : {90.0, 50.0, 120.0, -10.0})
    for (const double yaw : {0.0, 0.4, -30.0})
      for (const double roll : {0.0, 5.0, -170.0}) {
        const LaunchAttitude a = launch_attitude(body(pitch * kDegree, yaw * kDegree, roll * kDegree), C);
        EXPECT_NEAR(a.pitch, pitch * kDegree, kRounding);
        EXPECT_NEAR(a.yaw, yaw * kDegree, kRounding);
        EXPECT_NEAR(a.roll, roll * kDegree, kRounding);
      }
}

TEST(ClosedLoopSummary, TheEllipseHasItsAzimuthFromNorth) {
  // Major axis along 30 degrees from north, whatever the launch plane.
  for (const double launch : {0.0, 90.0, 200.0}) {
    const double left_of_downrange = (launch - 30) * kDegree;
    const Eigen::Vector2d axis(std::cos(left_of_downrange), std::sin(left_of_downrange));
    Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
    P.topLeftCorner<2, 2>() = Eigen::Matrix2d::Identity() * 4 + axis * axis.transpose() * 5;
    const Ellipse e = ellipse(P, launch * kDegree);
    EXPECT_NEAR(e.semi_major, 3, 1e-12);
    EXPECT_NEAR(e.semi_minor, 2, 1e-12);
    EXPECT_NEAR(e.azimuth / kDegree, 30, 1e-9);
  }
}

TEST(ClosedLoopSummary, TheLeastMarginsAreFound) {
  MarginsAt m;
  m.points = {{.t = 1, .gain_up = 10, .gain_down = 0, .phase = 1, .stable = true},
              {.t = 2, .gain_up = 4, .gain_down = 0.5, .phase = 0.53, .stable = true},
              {.t = 3, .gain_up = 5, .gain_down = 0.1, .phase = 0.6, .stable = true}};
  const auto least = least_margins(m);
  ASSERT_EQ(least.size(), 1U);
  EXPECT_NEAR(least[0].gain_up_db, 20 * std::log10(4), 1e-12);
  EXPECT_EQ(least[0].gain_up_at, 2);
  EXPECT_NEAR(least[0].gain_down_db, 20 * std::log10(2), 1e-12);
  EXPECT_NEAR(least[0].phase_deg, 0.53 / kDegree, 1e-12);  // 30.4 degrees
  EXPECT_TRUE(least[0].met());
  EXPECT_TRUE(margins_met(m));
  EXPECT_FALSE(margins_met({})) << "there is no loop";
  for (const auto& [member, value] : {std::pair{&flight::Margins::phase, 0.52},
                                      {&flight::Margins::gain_up, 1.99},
                                      {&flight::Margins::gain_down, 0.51}}) {
    auto worse = m;
    worse.points[2].*member = value;
    EXPECT_FALSE(least_margins(worse)[0].met());
    EXPECT_FALSE(margins_met(worse));
  }
  m.points[0].stable = false;
  EXPECT_FALSE(least_margins(m)[0].met());
}

TEST(ClosedLoopSummary, NavigationIsCheckedAxisByAxis) {
  Study s;
  s.C_enu = s.C_launch = Eigen::Matrix3d::Identity();
  EXPECT_FALSE(navigation_check(s)) << "there is no budget";
  EXPECT_TRUE(s.too_short());
  budget::Budget budget;
  navigation::CoreMatrix P = navigation::CoreMatrix::Zero();
  P.diagonal() << 1, 4, 0, 1, 1, 1, 1, 1, 1;
  budget.total = {P};
  s.budget = budget;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_FALSE(navigation_check(s)) << "fewer than two flights";
    Outcome o;
    o.navigation << 2, 2, 1, 1, 1, 1, 0, 0, 0;
    o.navigation *= sign;
    s.sensors.outcomes.push_back(o);
  }
  s.sensors.outcomes.push_back({.ended = flight::Ended::tumbling});  // does not count
  const auto check = navigation_check(s);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->runs, 2);
  EXPECT_DOUBLE_EQ(check->position_ratio[0], 2);
  EXPECT_DOUBLE_EQ(check->position_ratio[1], 1);
  EXPECT_TRUE(std::isnan(check->position_ratio[2])) << "the covariance has nothing there";
  EXPECT_DOUBLE_EQ(check->position, 3 / std::sqrt(5.0));
  EXPECT_DOUBLE_EQ(check->velocity, 1);
  EXPECT_EQ(check->attitude, 0);
  EXPECT_TRUE(check->holds(1));
  EXPECT_FALSE(check->holds(check->high * 1.01));
  EXPECT_FALSE(check->holds(check->low * 0.99));
}

TEST(ClosedLoopSummary, WhatIsCountedAndWhatIsNot) {
  Study s;
  s.nominal.ended = flight::Ended::complete;
  EXPECT_FALSE(s.flew_to_the_end()) << "nothing flew with the sensors";
  EXPECT_EQ(&s.shown(), &s.nominal);
  s.flown.emplace();
  EXPECT_TRUE(s.flew_to_the_end());
  EXPECT_EQ(&s.shown(), &*s.flown);
  s.flown->ended = flight::Ended::impact;
  EXPECT_FALSE(s.flew_to_the_end());
  s.budget.emplace();
  s.asked = 3;
  EXPECT_FALSE(s.not_compared());
  s.nominal.ended = flight::Ended::overload;
  EXPECT_TRUE(s.not_compared());
  s.asked = 0;
  EXPECT_FALSE(s.not_compared());
}

TEST(ClosedLoopSummary, TheLimitsUsedAreThoseOfTheWholeRecord) {
  flight::Vehicle vehicle;
  vehicle.actuator.deflection_limit = 0.05;
  flight::FlightRecord record;
  record.largest_deflection = 0.02;
  record.limited = 0.25;
  const auto point = [](double t, double pressure, double mach, double angle) {
    flight::FlightPoint p{};
    p.t = t;
    p.flow.dynamic_pressure = pressure;
    p.flow.mach = mach;
    p.flow.angle_of_attack = angle;
    return p;
  };
  record.points = {point(1, 100, 0.5, 0.1), point(2, 300, 1.1, 0.01)};
  record.end = point(3, 200, 1.5, 0.2);
  const LimitsUsed used = limits_used(vehicle, record);
  EXPECT_EQ(used.pressure, 300);
  EXPECT_EQ(used.pressure_at, 2);
  EXPECT_EQ(used.mach, 1.1);
  EXPECT_DOUBLE_EQ(used.pressure_angle, 40);  // of the end
  EXPECT_EQ(used.deflection, 0.02);
  EXPECT_EQ(used.deflection_limit, 0.05);
  EXPECT_EQ(used.limited, 0.25);
}

}  // namespace
}  // namespace gyrobudget::closed_loop
