// SPDX-License-Identifier: MIT
// Trajectories against closed forms (rest, coning, spin, flight along the equator), against an independent
// integration of what they sense in inertial axes, and increments against the integrals they stand for.
#include "gyrobudget/vehicle/earth/trajectory.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "points.h"

namespace gyrobudget::earth {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kG = 9.80665;

Quaterniond attitude(Uniform& uniform) { return exp_rotation(uniform.vector(1.8)); }

Matrix3d C_en(const Geodetic& g) { return C_e_ned(g.latitude, g.longitude); }

struct Case {
  std::string name;
  Trajectory trajectory;
};

std::vector<Case> all_paths() {
  const Vibration vibration{1 * kDegree, 5, 0.5 * kDegree, 0.2 * kG, 7};
  std::vector<Case> cases;
  cases.push_back({"rest", stand({.duration = 10})});
  cases.push_back({"spin", stand({.spin = {3, -6, 6}, .duration = 10})});
  cases.push_back(
      {"coning", stand({.vibration = {.coning_angle = 1 * kDegree, .coning_frequency = 5}, .duration = 10})});
  cases.push_back(
      {"vibration at the pole", stand({.position = {pi / 2, 1, 0}, .vibration = vibration, .duration = 10})});
  cases.push_back({"cruise", cruise({.duration = 10})});
  cases.push_back({"S-turns", cruise({.azimuth = 0.3,
                                      .speed = 300,
                                      .turn_acceleration = 0.5 * kG,
                                      .turn_period = 20,
                                      .vibration = vibration,
                                      .duration = 10})});
  cases.push_back({"over the pole", cruise({.start = {pi / 2 - 4e-4, 0, 1e4}, .azimuth = 0, .duration = 10})});
  cases.push_back({"date line", cruise({.start = {0.2, pi - 2e-4, 1e4}, .speed = 300, .duration = 10})});
  cases.push_back({"climb", climb({.vibration = vibration, .duration = 10})});
  cases.push_back({"ascent", ascent({})});
  cases.push_back({"ascent to the north", ascent({.azimuth = 0})});
  return cases;
}

// --- At rest ---------------------------------------------------------------------------------------------

TEST(Stand, AtRestSensesEarthAlone) {
  Uniform uniform(1);
  for (const Geodetic& place : many_points(300)) {
    const Quaterniond q_nb = attitude(uniform);
    const Trajectory rest = stand({.position = place, .q_nb = q_nb, .duration = 100});
    const Matrix3d C_be = (C_en(place) * q_nb.toRotationMatrix()).transpose();
    const Vector3d f = -C_be * normal_gravity(to_ecef(place));
    const Vector3d w = C_be * Vector3d(0, 0, wgs84::kEarthRate);
    const TrajectoryPoint p = rest.at(uniform(0, 100));
    ASSERT_EQ(p.pose.p_eb_e, to_ecef(place));
    ASSERT_EQ(p.pose.v_eb_e, Vector3d::Zero());
    ASSERT_LE((p.sensed.f_ib_b - f).norm(), 16 * kEpsilon * 9.8);
    ASSERT_LE((p.sensed.w_ib_b - w).norm(), 16 * kEpsilon * wgs84::kEarthRate);
    const noise::ImuIncrement one = rest.increment(3.5, 3.75);
    ASSERT_LE((vector(one.velocity) - f / 4).norm(), 16 * kEpsilon * 9.8);
    ASSERT_LE((vector(one.angle) - w / 4).norm(), 16 * kEpsilon * wgs84::kEarthRate);
  }
}

/// Integral over [a, b] of C_cb', C_c that of the classical coning quaternion, by hand.
Matrix3d coning_integral(double angle, double w, double a, double b) {
  const double c = std::cos(angle / 2);
  const double s = std::sin(angle / 2);
  const double T = b - a;
  const double cos1 = (std::sin(w * b) - std::sin(w * a)) / w;
  const double sin1 = -(std::cos(w * b) - std::cos(w * a)) / w;
  const double cos2 = (std::sin(2 * w * b) - std::sin(2 * w * a)) / (2 * w);
  const double sin2 = -(std::cos(2 * w * b) - std::cos(2 * w * a)) / (2 * w);
  // q = (c, 0, s cos, s sin): C = [[1 - 2 s^2, -2 c s sin, 2 c s cos],
  //                               [2 c s sin, 1 - 2 s^2 sin^2, 2 s^2 sin cos],
  //                               [-2 c s cos, 2 s^2 sin cos, 1 - 2 s^2 cos^2]]
  Matrix3d C;
  C << (1 - 2 * s * s) * T, -2 * c * s * sin1, 2 * c * s * cos1,  //
      2 * c * s * sin1, T - s * s * (T - cos2), s * s * sin2,     //
      -2 * c * s * cos1, s * s * sin2, T - s * s * (T + cos2);
  return C.transpose();
}

TEST(Stand, ConingIncrementsAreTheClosedForm) {
  for (const double frequency : {0.1, 5.0, 50.0})
    for (const double angle : {1e-6, 1 * kDegree, 60 * kDegree}) {
      const Trajectory coning =
          stand({.vibration = {.coning_angle = angle, .coning_frequency = frequency}, .duration = 100});
      const double w = 2 * pi * frequency;
      const Geodetic place = alcantara().position;
      const Vector3d w_ie_n = earth_rate_ned(place.latitude);
      const Vector3d f_n = -C_en(place).transpose() * normal_gravity(to_ecef(place));
      for (const double dt : {1e-3, 0.01, 0.1, 1.0, 0.37})
        for (const double start : {0.0, 0.123, 98.0}) {
          const double a = start;
          const double b = start + dt;
          const double span = b - a;
          const Matrix3d C = coning_integral(angle, w, a, b);
          const Vector3d own(-2 * std::pow(std::sin(angle / 2), 2) * w * span,
                             std::sin(angle) * (std::cos(w * b) - std::cos(w * a)),
                             std::sin(angle) * (std::sin(w * b) - std::sin(w * a)));
          const noise::ImuIncrement one = coning.increment(a, b);
          // Phases up to 2 pi 5000 round by eps each; the closed form divides by w what it takes from them.
          const double phase = kEpsilon * (8 + w * b);
          ASSERT_LE((vector(one.angle) - own - C * w_ie_n).norm(),
                    4 * angle * phase * (1 + w * span) + 8 * kEpsilon * w * dt * angle)
              << frequency << " " << angle << " " << dt;
          ASSERT_LE((vector(one.velocity) - C * f_n).norm(),
                    20 * (phase * std::min(angle, 1.0) / w + 16 * kEpsilon * dt));
        }
    }
}

TEST(Stand, SpinIncrementsAreTheClosedForm) {
  const Vector3d axis = Vector3d(1, -2, 2) / 3;
  const double rate = 10 * pi;  // five turns a second
  const Geodetic place{0.8, -2, 100};
  const Trajectory spin = stand({.position = place, .spin = rate * axis, .duration = 1000});
  const Vector3d w_ie_n = earth_rate_ned(place.latitude);
  const Vector3d f_n = -C_en(place).transpose() * normal_gravity(to_ecef(place));
  for (const double dt : {1e-3, 0.01, 0.1, 1.0}) {
    const double a = 17.3;
    const double b = a + dt;
    const double span = b - a;
    // exp(-[axis] x) = I - sin x [axis] + (1 - cos x) [axis]^2, integrated.
    const Matrix3d K = skew(axis);
    const Matrix3d C = span * Matrix3d::Identity() + (std::cos(rate * b) - std::cos(rate * a)) / rate * K +
                       (span - (std::sin(rate * b) - std::sin(rate * a)) / rate) * K * K;
    const noise::ImuIncrement one = spin.increment(a, b);
    const double phase = kEpsilon * (8 + rate * b) / rate;
    EXPECT_LE((vector(one.angle) - rate * span * axis - C * w_ie_n).norm(), 16 * kEpsilon * rate * dt + 1e-4 * phase);
    EXPECT_LE((vector(one.velocity) - C * f_n).norm(), 10 * (16 * kEpsilon * dt + 4 * phase));
  }
}

TEST(Stand, UncorrectedScullingIsHalfTheProduct) {
  const double angle = 0.01;
  const double acceleration = 2;
  const Trajectory still = stand({.duration = 10});
  const Trajectory sculling =
      stand({.vibration = {.sculling_angle = angle, .sculling_acceleration = acceleration, .sculling_frequency = 5},
             .duration = 10});
  // f_z = -g cos(roll) - sin(roll) f_y, with f_y = -acceleration sin, averaged over whole periods.
  const double mean = (sculling.increment(0, 10).velocity[2] - still.increment(0, 10).velocity[2]) / 10;
  EXPECT_NEAR(mean, angle * acceleration / 2 + 9.78 * angle * angle / 4, 1e-3 * angle * acceleration);
}

// --- Moving ----------------------------------------------------------------------------------------------

TEST(Cruise, EastAlongTheEquatorIsAnOrbit) {
  for (const double speed : {0.0, 250.0, 1000.0}) {
    const double r = wgs84::kEquatorialRadius + 1e4;
    const Trajectory flight = cruise({.start = {0, 0.5, 1e4}, .speed = speed, .duration = 36000});
    const double rate = wgs84::kEarthRate + speed / r;
    const double pull = normal_gravitation({r, 0, 0}).norm();
    for (double t = 0; t <= 36000; t += 1800) {
      const TrajectoryPoint p = flight.at(t);
      const double longitude = 0.5 + speed / r * t;
      ASSERT_LE((p.pose.p_eb_e - r * Vector3d(std::cos(longitude), std::sin(longitude), 0)).norm(),
                1e-8 + kEpsilon * speed * t);
      ASSERT_NEAR(p.pose.v_eb_e.norm(), speed, 1e-11);
      ASSERT_LE((p.sensed.w_ib_b - Vector3d(0, -rate, 0)).norm(), 1e-17);
      ASSERT_LE((p.sensed.f_ib_b - Vector3d(0, 0, rate * rate * r - pull)).norm(), 1e-13);
    }
    const noise::ImuIncrement whole = flight.increment(0, 36000);
    ASSERT_NEAR(whole.angle[1], -rate * 36000, 1e-12);
    ASSERT_NEAR(whole.velocity[2], (rate * rate * r - pull) * 36000, 1e-8);
  }
}

TEST(Cruise, KeepsHeightLevelAndSpeedOverThePole) {
  const Trajectory flight = cruise({.start = {1.2, 0.4, 9000}, .azimuth = 0, .speed = 300, .duration = 3600 * 4});
  for (double t = 0; t <= flight.duration(); t += 60) {
    const TrajectoryPoint p = flight.at(t);
    const Geodetic here = to_geodetic(p.pose.p_eb_e);
    ASSERT_NEAR(here.height, 9000, 1e-8);
    ASSERT_NEAR(p.pose.v_eb_e.norm(), 300, 3);
    const Matrix3d C_eb = p.pose.q_eb.toRotationMatrix();
    ASSERT_LE((C_eb.col(2) + up_e(here.latitude, here.longitude)).norm(), 1e-14);
    ASSERT_LE((p.pose.v_eb_e / p.pose.v_eb_e.norm() - C_eb.col(0)).norm(), 1e-12);
  }
}

TEST(Cruise, TurnsAsHardAsAskedAndCoordinated) {
  const double acceleration = 0.5 * kG;
  const Trajectory flight =
      cruise({.azimuth = 1, .speed = 300, .turn_acceleration = acceleration, .turn_period = 60, .duration = 60});
  double hardest = 0;
  for (double t = 0; t <= 60; t += 0.1) {
    const TrajectoryPoint p = flight.at(t);
    const Geodetic here = to_geodetic(p.pose.p_eb_e);
    ASSERT_NEAR(here.height, 10000, 1e-8);
    const Matrix3d C_bn = p.pose.q_eb.toRotationMatrix().transpose() * C_en(here);
    // Forward is along the track, and sideways only what gravity's 9.78 beside 9.807, heading off the centre
    // line and Coriolis leave.
    ASSERT_NEAR((p.pose.q_eb.conjugate() * p.pose.v_eb_e).normalized().x(), 1, 1e-5);
    ASSERT_LE(std::abs(p.sensed.f_ib_b.y()), 0.06 * acceleration) << t;
    const Vector3d f_n = C_bn.transpose() * p.sensed.f_ib_b;
    hardest = std::max(hardest, f_n.head<2>().norm());
  }
  EXPECT_NEAR(hardest, acceleration, 0.02 * acceleration);
  // A positive acceleration first turns left: the left wing down.
  const TrajectoryPoint early = flight.at(1);
  const Geodetic here = to_geodetic(early.pose.p_eb_e);
  EXPECT_LT(to_euler(Quaterniond(C_en(here)).conjugate() * early.pose.q_eb).roll, -0.01);
}

TEST(Climb, GoesStraightUp) {
  const Climb options{.acceleration = 12, .duration = 60};
  const Trajectory flight = climb(options);
  const auto pad = LocalFrame::launch_plane(options.site, options.azimuth);
  for (double t = 0; t <= 60; t += 1) {
    const TrajectoryPoint p = flight.at(t);
    const Vector3d local = pad.from_ecef(p.pose.p_eb_e);
    ASSERT_NEAR(local.z(), 6 * t * t, 4e-9);
    ASSERT_LE(local.head<2>().norm(), 4e-9);
    ASSERT_NEAR(p.sensed.f_ib_b.x(), 12 + normal_gravity(p.pose.p_eb_e).norm(), 1e-5);
    // Climbing, the body gains on nothing to the east: Coriolis 2 omega v cos L pushes it there.
    const Vector3d f_l = pad.C_el().transpose() * (p.pose.q_eb * p.sensed.f_ib_b);
    ASSERT_NEAR(f_l.x(), 2 * wgs84::kEarthRate * 12 * t * std::cos(options.site.latitude), 1e-4);
  }
}

TEST(Ascent, LastsAsLongAsItMay) {
  const Trajectory longest = ascent({.duration = kLongestAscent});
  EXPECT_TRUE(longest.at(kLongestAscent).pose.v_eb_e.allFinite());
  EXPECT_THROW((void)ascent({.duration = std::nextafter(kLongestAscent, 1e6)}), std::invalid_argument);
}

TEST(Ascent, FollowsItsProgram) {
  const Trajectory flight = ascent({});
  const auto pad = LocalFrame::launch_plane(alcantara().position, pi / 2);
  EXPECT_EQ(flight.duration(), 83);
  const auto euler = [&](double t) {
    Matrix3d C_plane;  // downrange, right, down
    C_plane << pad.C_el().col(0), -pad.C_el().col(1), -pad.C_el().col(2);
    return to_euler(Quaterniond(C_plane).conjugate() * flight.at(t).pose.q_eb);
  };
  EXPECT_NEAR(euler(0).pitch, pi / 2, 1e-14);
  EXPECT_NEAR(euler(7.9).pitch, pi / 2, 1e-14);
  EXPECT_NEAR(euler(8 + 37.5).pitch, 70 * kDegree, 1e-14);
  EXPECT_NEAR(euler(83).pitch, 50 * kDegree, 1e-14);
  EXPECT_NEAR(euler(60).yaw, 0, 1e-14);
  EXPECT_NEAR(euler(60).roll, 0, 1e-14);
  EXPECT_NEAR(flight.at(0).sensed.f_ib_b.x(), 13, 1e-14);
  EXPECT_NEAR(flight.at(77).sensed.f_ib_b.x(), 19, 1e-13);
  EXPECT_NEAR(flight.at(80).sensed.f_ib_b.x(), 9.5, 1e-13);
  EXPECT_NEAR(flight.at(83).sensed.f_ib_b.x(), 0, 1e-13);
  // Integrals of the program by hand: (13 + 19)/2 77 + 19/2 6.
  EXPECT_NEAR(flight.increment(0, 83).velocity[0], 16 * 77 + 57, 1e-10);
  EXPECT_LE(vector(flight.increment(0, 83).velocity).tail<2>().norm(), 1e-12);
  EXPECT_EQ(flight.at(0).pose.v_eb_e, Vector3d::Zero());
  const Vector3d end = pad.from_ecef(flight.at(83).pose.p_eb_e);
  EXPECT_GT(end.x(), 5e3);
  EXPECT_GT(end.z(), 1e4);
  // To the east Earth's rate falls on pitch: 0.347 degrees in all, against the body that follows the plane.
  EXPECT_NEAR((flight.increment(0, 83).angle[1] + 40 * kDegree) / kDegree, -0.3465, 5e-4);
}

// --- Every path ------------------------------------------------------------------------------------------

struct InertialState {
  Vector3d p, v;
  Quaterniond q_ib;
};

/// p'' = C_ib f + gravitation, q' = q (0, w)/2, by the classical Runge-Kutta method in inertial axes.
InertialState derivative(const InertialState& s, const TrajectoryPoint& at) {
  const Inertial inertial;
  const Matrix3d C_ie = inertial.C_ie(at.t);
  const auto& [f_ib_b, w_ib_b] = at.sensed;
  const Quaterniond rate(0, w_ib_b.x() / 2, w_ib_b.y() / 2, w_ib_b.z() / 2);
  return {s.v, s.q_ib.normalized() * f_ib_b + C_ie * normal_gravitation(C_ie.transpose() * s.p), s.q_ib * rate};
}

InertialState plus(const InertialState& s, double h, const InertialState& d) {
  return {s.p + h * d.p, s.v + h * d.v, Quaterniond(Eigen::Vector4d(s.q_ib.coeffs() + h * d.q_ib.coeffs()))};
}

TEST(EveryPath, IsWhatItsSensorsIntegrateTo) {
  // The method errs by (w h)^5/120 a step at w = 75 rad/s, and the longest path lasts 83 s.
  constexpr double kStep = 1e-3;
  constexpr double kPosition = 2e-5;  // [m]
  constexpr double kAttitude = 1e-8;  // [rad]
  const Inertial inertial;
  for (const Case& c : all_paths()) {
    const TrajectoryPoint start = c.trajectory.at(0);
    const Moving moving = inertial.from_ecef({start.pose.p_eb_e, start.pose.v_eb_e}, 0);
    InertialState s{moving.p, moving.v, start.pose.q_eb};
    const int steps = static_cast<int>(std::lround(c.trajectory.duration() / kStep));
    TrajectoryPoint now = start;
    for (int k = 0; k < steps; ++k) {
      const double h = kStep;
      const TrajectoryPoint middle = c.trajectory.at((k + 0.5) * kStep);
      // Where a rate jumps at the end of the step, the step belongs to what was before.
      const double end = std::min((k + 1) * kStep, c.trajectory.duration());
      const TrajectoryPoint next = c.trajectory.at(std::nextafter(end, 0));
      const InertialState d1 = derivative(s, now);
      const InertialState d2 = derivative(plus(s, h / 2, d1), middle);
      const InertialState d3 = derivative(plus(s, h / 2, d2), middle);
      const InertialState d4 = derivative(plus(s, h, d3), next);
      s = plus(plus(plus(plus(s, h / 6, d1), h / 3, d2), h / 3, d3), h / 6, d4);
      s.q_ib.normalize();
      now = c.trajectory.at(end);
    }
    const Moving end = inertial.to_ecef({s.p, s.v}, now.t);
    EXPECT_LE((end.p - now.pose.p_eb_e).norm(), kPosition) << c.name;
    EXPECT_LE((end.v - now.pose.v_eb_e).norm(), kPosition) << c.name;
    const Quaterniond q_eb = Quaterniond(inertial.C_ie(now.t).transpose()) * s.q_ib;
    EXPECT_LE(log_rotation(q_eb.conjugate() * now.pose.q_eb).norm(), kAttitude) << c.name;
  }
}

TEST(EveryPath, VelocityIsTheDerivativeOfPosition) {
  constexpr double h = 1e-3;  // errs by h^2/6 of the jerk, at most 2 m/s^2 (44 rad/s)
  for (const Case& c : all_paths())
    for (const double t : {0.5, 3.3, 7.0, 9.9}) {
      const Vector3d numeric = (c.trajectory.at(t + h).pose.p_eb_e - c.trajectory.at(t - h).pose.p_eb_e) / (2 * h);
      EXPECT_LE((numeric - c.trajectory.at(t).pose.v_eb_e).norm(), 2e-5) << c.name;
    }
}

TEST(EveryPath, IncrementsAddUpInWhateverPieces) {
  for (const Case& c : all_paths()) {
    const double T = 10;
    const noise::ImuIncrement whole = c.trajectory.increment(0, T);
    for (const double interval : {0.001, 0.01, 0.1, 0.7, 5.0}) {
      noise::ImuIncrement sum;
      const auto all = c.trajectory.increments(interval);
      const std::size_t count = std::min(all.size(), static_cast<std::size_t>(std::floor(T / interval * (1 + 1e-12))));
      for (std::size_t k = 0; k < count; ++k) {
        vector(sum.velocity) += vector(all[k].velocity);
        vector(sum.angle) += vector(all[k].angle);
      }
      const noise::ImuIncrement rest = c.trajectory.increment(std::min(T, static_cast<double>(count) * interval), T);
      const double rounding = 4 * kEpsilon * std::sqrt(static_cast<double>(count) + 100);  // of a running sum
      EXPECT_LE((vector(sum.velocity) + vector(rest.velocity) - vector(whole.velocity)).norm(), rounding * 200)
          << c.name << " " << interval;
      EXPECT_LE((vector(sum.angle) + vector(rest.angle) - vector(whole.angle)).norm(),
                rounding * (1 + vector(whole.angle).norm()))
          << c.name;
    }
  }
}

/// A plain strapdown in inertial axes with the two-sample coning and sculling terms and the rotation to
/// second order (Savage 1998, parts 1 and 2).
TEST(EveryPath, IncrementsNavigateBackToIt) {
  // At 2 kHz the terms left out, of the order (w dt)^4, move a vibrating body by less than this in 10 s.
  constexpr double kInterval = 5e-4;
  constexpr double kPosition = 1e-4;  // [m]
  const Inertial inertial;
  for (const Case& c : all_paths()) {
    const auto imu = c.trajectory.increments(kInterval);
    const TrajectoryPoint start = c.trajectory.at(0);
    Moving s = inertial.from_ecef({start.pose.p_eb_e, start.pose.v_eb_e}, 0);
    Quaterniond q_ib = start.pose.q_eb;
    Vector3d last_gain_i = q_ib * vector(imu.front().velocity);
    noise::ImuIncrement last = imu.front();
    const std::size_t count = std::min<std::size_t>(imu.size(), 20000);
    for (std::size_t k = 0; k < count; ++k) {
      const noise::ImuIncrement& now = imu[k];
      const auto a = vector(now.angle), v = vector(now.velocity);
      const auto last_a = vector(last.angle), last_v = vector(last.velocity);
      const Vector3d turn = a + last_a.cross(a) / 12;
      const Vector3d gain = v + a.cross(v) / 2 + a.cross(a.cross(v)) / 6 + (last_a.cross(v) + last_v.cross(a)) / 12;
      const Matrix3d C_ie = inertial.C_ie((static_cast<double>(k) + 0.5) * kInterval);
      const Vector3d half_way = s.p + kInterval / 2 * s.v;
      const Vector3d pull = C_ie * normal_gravitation(C_ie.transpose() * half_way);
      const Vector3d gain_i = q_ib * gain;
      const Vector3d change = gain_i + kInterval * pull;
      // Specific force rises or falls over the interval: its first moment is about that of a line.
      const Vector3d slope = (gain_i - last_gain_i) * (kInterval / 12);
      s.p += kInterval * (s.v + change / 2) - slope;
      s.v += change;
      q_ib = (q_ib * exp_rotation(turn)).normalized();
      last = now;
      last_gain_i = gain_i;
    }
    const double t = static_cast<double>(count) * kInterval;
    const TrajectoryPoint truth = c.trajectory.at(t);
    const Moving end = inertial.to_ecef(s, t);
    EXPECT_LE((end.p - truth.pose.p_eb_e).norm(), kPosition) << c.name;
  }
}

// --- Refusals --------------------------------------------------------------------------------------------

TEST(Trajectory, RefusesTimesOutside) {
  const Trajectory rest = stand({.duration = 10});
  EXPECT_THROW(static_cast<void>(rest.at(-1e-9)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.at(10.001)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.at(std::nan(""))), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.increment(2, 1)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.increment(9, 11)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.increments(0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.increments(-1)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(rest.increments(1e-12)), std::invalid_argument);
  EXPECT_THROW(Trajectory(nullptr), std::invalid_argument);
  // What no body does: faster than light, shaking above 1e6 rad/s, turning beyond what a double holds.
  EXPECT_THROW((void)cruise({.speed = 1e9, .duration = 10}), std::invalid_argument);
  EXPECT_THROW((void)cruise({.speed = 1e300, .duration = 10}), std::invalid_argument);
  EXPECT_THROW((void)stand({.vibration = {.coning_angle = 1, .coning_frequency = 1e200}, .duration = 1}),
               std::invalid_argument);
  EXPECT_THROW((void)cruise({.turn_acceleration = 1e200, .turn_period = 10, .duration = 9}).increment(0, 1),
               std::invalid_argument);
  EXPECT_EQ(rest.increment(3, 3).angle, noise::Vector3{});
  EXPECT_EQ(rest.increments(0.1).size(), 100U);
  EXPECT_EQ(rest.increments(3).size(), 3U);
  EXPECT_EQ(rest.increments(11).size(), 0U);
}

TEST(Trajectory, RefusesOptionsByName) {
  const double nan = std::nan("");
  const auto message = [](auto make) -> std::string {
    try {
      static_cast<void>(make());
      return "accepted";
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
  };
  EXPECT_NE(message([&] { return stand({.position = {2, 0, 0}}); }).find("latitude"), std::string::npos);
  EXPECT_NE(message([&] { return stand({.q_nb = Quaterniond(2, 0, 0, 0)}); }).find("q_nb"), std::string::npos);
  EXPECT_NE(message([&] { return stand({.vibration = {.coning_frequency = -1}}); }).find("coning frequency"),
            std::string::npos);
  EXPECT_NE(message([&] { return cruise({.speed = nan}); }).find("speed"), std::string::npos);
  EXPECT_NE(message([&] { return cruise({.turn_acceleration = 1, .turn_period = 0}); }).find("period"),
            std::string::npos);
  EXPECT_NE(message([&] { return climb({.duration = 0}); }).find("duration"), std::string::npos);
  EXPECT_NE(message([&] { return ascent({.pitch_over_at = 90}); }).find("90"), std::string::npos);
  EXPECT_NE(message([&] { return ascent({.tail_off = nan}); }).find("tail-off"), std::string::npos);
  EXPECT_NE(message([&] { return ascent({.duration = 1e12}); }).find("86400"), std::string::npos);
}

}  // namespace
}  // namespace gyrobudget::earth
