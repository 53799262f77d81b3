// SPDX-License-Identifier: MIT
// The closed loop: against a planar point mass written down independently, between families of integrators,
// margins against the loop itself, and what goes wrong.
#include "gyrobudget/vehicle/flight/fly.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/vector.h"
#include "gyrobudget/vehicle/flight/margins.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "allocations.h"

namespace gyrobudget::flight {
namespace {

using earth::kDegree;
using Eigen::Vector2d;
using Eigen::Vector3d;

FlightRecord fly_perfect(const Flight& plan, const AttitudeControl::Options& options = {}) {
  AttitudeControl control(plan.vehicle, plan.world.site, options);
  PerfectNavigator navigator;
  return fly(plan, control, navigator);
}

/// End in downrange, crossrange, up.
Vector3d end_of(const Flight& plan, const FlightRecord& record) {
  return earth::LocalFrame::launch_plane(plan.world.site, plan.azimuth).from_ecef(record.end.truth.p_eb_e);
}

// --- an independent planar point mass -----------------------------------------------------------------

struct Planar {
  double height, downrange, speed;
};

double between(const LookupTable& table, double x) {  // straight between the points, whatever the table does
  const auto& p = table.points();
  if (x <= p.front().first) return p.front().second;
  for (std::size_t k = 1; k < p.size(); ++k)
    if (x <= p[k].first)
      return p[k - 1].second + (p[k].second - p[k - 1].second) * (x - p[k - 1].first) / (p[k].first - p[k - 1].first);
  return p.back().second;
}

/// Over a flat Earth that does not turn, nose along the program, drag against the velocity; Euler-midpoint.
Planar planar_flight(const Vehicle& v) {
  double mean = 0;
  for (int k = 0; k < 100000; ++k) mean += between(v.thrust_shape, (k + 0.5) * 1e-5) * 1e-5;
  struct State {
    double x, h, vx, vh, m;
  };
  const auto rate = [&](const State& s, double t) {
    const double shape = between(v.thrust_shape, t / v.burn_time) / mean;
    const Air air = standard_atmosphere::at(s.h);
    const double thrust = v.mean_thrust() * shape - v.exit_area * air.pressure;
    const double pitch = t < 8 ? std::numbers::pi / 2 : (90 - 40 * (t - 8) / 75) * kDegree;
    const double speed = std::hypot(s.vx, s.vh);
    const double drag =
        0.5 * air.density * speed * v.reference_area * between(v.axial_drag, speed / air.speed_of_sound);
    return State{s.vx, s.vh, (thrust * std::cos(pitch) - drag * s.vx) / s.m,
                 (thrust * std::sin(pitch) - drag * s.vh) / s.m - 9.78, -v.propellant / v.burn_time * shape};
  };
  const auto moved = [](const State& s, const State& d, double h) {
    return State{s.x + h * d.x, s.h + h * d.h, s.vx + h * d.vx, s.vh + h * d.vh, s.m + h * d.m};
  };
  State s{0, 0, 0, 0, v.lift_off_mass};
  constexpr int kSteps = 20000;
  const double dt = v.burn_time / kSteps;
  for (int k = 0; k < kSteps; ++k) {
    const double t = k * dt;
    s = moved(s, rate(moved(s, rate(s, t), dt / 2), t + dt / 2), dt);
  }
  return {s.h, s.x, std::hypot(s.vx, s.vh)};
}

TEST(Flight, PlanarPointMassGivesTheKnownFigures) {
  constexpr double kGravity = 100;  // [m]; what 9.81 instead of the equator's 9.78 m/s^2 is worth
  const Planar flown = planar_flight(vlm1());
  EXPECT_NEAR(flown.height, 22.9e3, kGravity);
  EXPECT_NEAR(flown.downrange, 11.4e3, kGravity);
  EXPECT_NEAR(flown.speed, 640, 3);
  EXPECT_NEAR(std::hypot(flown.height, flown.downrange), 25.6e3, kGravity);
  const Planar paper = planar_flight(vlm1_paper());
  EXPECT_NEAR(std::hypot(paper.height, paper.downrange), 29.2e3, kGravity);
}

TEST(Flight, SixDegreesOfFreedomStayNearThePointMass) {
  Flight plan;
  const FlightRecord record = fly_perfect(plan);
  EXPECT_EQ(record.ended, Ended::complete) << record.account;
  EXPECT_EQ(record.end.t, 83);
  const Planar planar = planar_flight(plan.vehicle);
  // Earth's turning, its shape, the spline of drag and the lean of the nose are worth less than a percent.
  EXPECT_NEAR(record.end.flow.height / planar.height, 1, 0.01);
  EXPECT_NEAR(end_of(plan, record).x() / planar.downrange, 1, 0.01);
  EXPECT_NEAR(record.end.truth.v_eb_e.norm() / planar.speed, 1, 0.01);
  EXPECT_LT(std::abs(end_of(plan, record).y()), 5);
  EXPECT_LT(record.limited, 0.01);
  EXPECT_EQ(record.points.size(), 831U);
  // Attitude is the program's; the loop is quiet.
  const AttitudeControl control(plan.vehicle, plan.world.site, {});
  for (const FlightPoint& p : record.points) {
    if (p.t < 12 || p.t > 82) continue;
    EXPECT_LT(p.truth.q_eb.angularDistance(control.reference(p.t)), 0.1 * kDegree) << p.t;
  }
}

TEST(Flight, RateFeedbackLagsByTwiceDampingOverFrequency) {
  Flight plan;
  plan.world.atmosphere = false;  // whose moment adds its own error
  const FlightRecord lagging = fly_perfect(plan, {.feedback = RateFeedback::rate});
  const AttitudeControl control(plan.vehicle, plan.world.site, {});
  const double rate = 40 * kDegree / 75;
  for (const FlightPoint& p : lagging.points) {
    if (p.t < 14 || p.t > 75) continue;
    EXPECT_NEAR(p.truth.q_eb.angularDistance(control.reference(p.t)) / (2 * 0.7 / 2.5 * rate), 1, 0.03) << p.t;
  }
  plan.world.atmosphere = true;
  const Vector3d late = end_of(plan, fly_perfect(plan, {.feedback = RateFeedback::rate}));
  EXPECT_NEAR((late - end_of(plan, fly_perfect(plan))).norm(), 183, 2);  // the size of the paper's 0.20 km
}

TEST(Flight, TwoFamiliesAgreeToAMicrometreAtBurnout) {
  for (const bool bends : {false, true}) {
    Flight plan;
    AttitudeControl::Options options;
    if (bends) {
      plan.vehicle.bending = Bending{};
      options.notches = {Notch{plan.vehicle.bending->frequency}};
    }
    const auto with = [&](const Integration& integration) {
      plan.integration = integration;
      return end_of(plan, fly_perfect(plan, options));
    };
    const Vector3d truth = with({Method::fehlberg78, 0.01, 1e-13});
    EXPECT_LT((with({Method::dormand_prince, 0.01, 1e-13}) - truth).norm(), 1e-6) << bends;
    // The default: bending takes its error from 1e-6 m to less than a millimetre.
    EXPECT_LT((with({}) - truth).norm(), bends ? 1e-3 : 1e-6) << bends;
  }
}

TEST(Flight, RepeatsItselfToTheLastBit) {
  Flight plan;
  plan.vehicle.bending = Bending{};
  plan.duration = 10;
  EXPECT_EQ(end_of(plan, fly_perfect(plan)), end_of(plan, fly_perfect(plan)));
}

TEST(Flight, AllocatesNothingInItsLoop) {
  Flight plan;
  plan.vehicle.bending = Bending{};
  const auto counted = [&](double duration) {
    plan.duration = duration;
    const long before = allocations();
    (void)fly_perfect(plan, {.notches = {Notch{plan.vehicle.bending->frequency}}});
    return allocations() - before;
  };
  EXPECT_EQ(counted(2), counted(20));
}

TEST(Flight, IncrementsSumUpToWhatTheImuDid) {
  // Attitude from the increments alone, first order with half the step's turn: the rest is third order.
  Flight plan;
  plan.duration = 20;
  plan.keep_increments = true;
  plan.vehicle.bending = Bending{};
  const FlightRecord record = fly_perfect(plan, {.notches = {Notch{plan.vehicle.bending->frequency}}});
  ASSERT_EQ(record.increments.size(), 2000U);
  Eigen::Quaterniond q = record.points.front().truth.q_eb;  // inertial axes are Earth's at time 0
  for (const noise::ImuIncrement& increment : record.increments)
    q = q * earth::exp_rotation(earth::vector(increment.angle));
  const Eigen::Quaterniond q_ie = earth::exp_rotation({0, 0, earth::wgs84::kEarthRate * 20});
  EXPECT_LT(q.angularDistance(q_ie * record.end.truth.q_eb), 1e-7);
}

// --- margins ------------------------------------------------------------------------------------------

struct Case {
  bool bends;
  double slope;
  double mode_factor;
};

TEST(Margins, MeetTheDemandsOverTheFlight) {
  Flight plan;
  plan.record_every = 100;
  const FlightRecord record = fly_perfect(plan);
  for (const Case c : {Case{false, 0, 1}, Case{true, -0.47, 1}, Case{true, -0.47, 0.9}, Case{true, -0.47, 1.1}}) {
    Vehicle v = plan.vehicle;
    AttitudeControl::Options options;
    if (c.bends) {
      v.bending = Bending{.slope_at_imu = c.slope};
      options.notches = {Notch{v.bending->frequency}};
    }
    const AttitudeControl control(v, plan.world.site, options);
    for (const FlightPoint& p : record.points) {
      if (p.t > 10 && p.flow.thrust < 0.2 * v.mean_thrust()) continue;
      const Margins m = margins(v, control, {p.t, p.flow.thrust, p.flow.dynamic_pressure, c.mode_factor});
      EXPECT_TRUE(m.stable) << p.t << " " << c.mode_factor;
      EXPECT_GT(m.gain_up, 2) << p.t << " " << c.mode_factor;
      EXPECT_LT(m.gain_down, 0.5) << p.t << " " << c.mode_factor;
      EXPECT_GT(m.phase, (c.bends ? 37 : 42) * kDegree) << p.t << " " << c.mode_factor;
      EXPECT_LT(m.phase, 50 * kDegree) << p.t << " " << c.mode_factor;
    }
  }
}

/// A controller whose nozzle commands are a factor too strong.
struct Stronger {
  AttitudeControl control;
  double factor;
  Command command(const Seen& seen) {
    Command c = control.command(seen);
    c.pitch *= factor;
    c.yaw *= factor;
    return c;
  }
};

/// Largest pitch rate in the last second of 15 s from an upset of 0.001 degrees, where all stays constant.
double echo(const Vehicle& v, double factor) {
  Flight plan;
  plan.vehicle = v;
  plan.world.atmosphere = false;
  plan.pitch = 90.001 * kDegree;
  plan.duration = 15;
  plan.record_every = 1;
  AttitudeControl::Options options{.pitch = 90 * kDegree};
  Stronger control{AttitudeControl(v, plan.world.site, options), factor};
  PerfectNavigator navigator;
  const FlightRecord record = fly(plan, control, navigator);
  double largest = 0;
  for (const FlightPoint& p : record.points)
    if (p.t > 14) largest = std::max(largest, std::abs(p.command.pitch));
  return largest;
}

TEST(Margins, AreThoseAtWhichTheFlightBeginsToOscillate) {
  Vehicle v = vlm1();
  v.thrust_shape = 1;
  v.propellant = 120;  // so that nothing changes
  v.specific_impulse *= 100;
  v.centre_of_mass = 7;
  v.imu_station = 7;
  v.actuator.rate_limit = 100;
  for (const bool bends : {false, true}) {
    if (bends) v.bending = Bending{.frequency = 3, .damping = 0.05, .slope_at_imu = -0.1};
    const AttitudeControl control(v, earth::alcantara().position, {.pitch = 90 * kDegree});
    const Margins m = margins(v, control, {5, v.mean_thrust(), 0});
    ASSERT_TRUE(m.stable);
    const double calm = echo(v, m.gain_up * 0.93), wild = echo(v, m.gain_up * 1.07);
    EXPECT_LT(calm, 2e-6) << m.gain_up;  // a tenth of what it began with
    EXPECT_GT(wild, 100 * calm) << m.gain_up;
  }
}

TEST(Margins, TellAnUnstableLoop) {
  Vehicle v = vlm1();
  v.bending = Bending{.slope_at_imu = 0.47};
  const AttitudeControl control(v, earth::alcantara().position, {});  // no filter
  EXPECT_FALSE(margins(v, control, {20, 4.4e5, 8000}).stable);
  v.bending.reset();
  const AttitudeControl rigid(v, earth::alcantara().position, {});
  EXPECT_TRUE(margins(v, rigid, {20, 4.4e5, 8000}).stable);
  EXPECT_FALSE(margins(v, rigid, {20, 4.4e5, 3e5}).stable);  // air stronger than the nozzle
  v.pressure_ahead = -3;                                     // with fins
  const AttitudeControl finned(v, earth::alcantara().position, {});
  EXPECT_TRUE(margins(v, finned, {20, 4.4e5, 8000}).stable);
}

// --- what goes wrong ----------------------------------------------------------------------------------

void expect_sound(const FlightRecord& record) {
  EXPECT_FALSE(record.account.empty());
  for (const FlightPoint& p : record.points) {
    EXPECT_TRUE(p.truth.p_eb_e.allFinite() && p.truth.v_eb_e.allFinite() && p.truth.q_eb.coeffs().allFinite());
    EXPECT_TRUE(p.seen.p_eb_e.allFinite() && p.seen.v_eb_e.allFinite() && p.seen.q_eb.coeffs().allFinite());
    EXPECT_TRUE(p.deflection.allFinite() && std::isfinite(p.flow.angle_of_attack));
  }
}

TEST(Extremes, StuckNozzleEndsInTumbling) {
  Flight plan;
  plan.faults = {.nozzle_stuck_at = 30, .nozzle_stuck_offset = Vector2d(1 * kDegree, 0)};
  const FlightRecord record = fly_perfect(plan);
  expect_sound(record);
  EXPECT_EQ(record.ended, Ended::tumbling) << record.account;
  EXPECT_GT(record.end.t, 30);
  EXPECT_LT(record.end.t, 83);
}

TEST(Extremes, AStuckNozzleStaysWhereItIs) {
  Flight plan;
  plan.faults = {.nozzle_stuck_at = 5, .nozzle_stuck_offset = Vector2d(0.1 * kDegree, 0)};
  plan.duration = 7;
  ASSERT_GT(plan.vehicle.actuator.delay, 0);  // commands are on their way when it sticks
  plan.record_every = 1;
  const FlightRecord record = fly_perfect(plan);
  const Vector2d stuck = record.points[501].deflection;
  EXPECT_NEAR(stuck.x(), record.points[500].deflection.x() + 0.1 * kDegree, 1e-3 * kDegree);
  for (std::size_t k = 501; k < record.points.size(); ++k) EXPECT_EQ(record.points[k].deflection, stuck) << k;
}

TEST(Extremes, ThrustCutComesDown) {
  Flight plan;
  plan.faults.thrust_cut_at = 20;
  plan.duration = 200;
  const FlightRecord record = fly_perfect(plan);
  expect_sound(record);
  EXPECT_TRUE(record.ended == Ended::impact || record.ended == Ended::tumbling) << record.account;
  plan.vehicle.normal_force_slope = 0;  // without the air's moment it comes down as it is
  const FlightRecord steady = fly_perfect(plan);
  EXPECT_EQ(steady.ended, Ended::impact) << steady.account;
  EXPECT_EQ(burn_state(plan.vehicle, 20).mass > 16000, true);
}

TEST(Extremes, NeverLeavesThePadWithoutThrust) {
  Flight plan;
  plan.faults.thrust_cut_at = 0;
  const FlightRecord record = fly_perfect(plan);
  expect_sound(record);
  EXPECT_EQ(record.ended, Ended::impact) << record.account;
  EXPECT_LT(record.end.t, 1);
}

// Of the VLM-1 at ignition: the arm of the gimbal grows by 3 m as the propellant goes, which begins at 1.05 of a shape
// whose mean over the burn is that of its table.
const double kCentreOfMassRate = 3 / vlm1().burn_time * 1.05 / vlm1().thrust_shape.integral(1);  // [m/s]

TEST(Flight, BeginsWithTheBodyAtRestAndNotItsCentreOfMass) {
  const FlightRecord record = fly_perfect({});
  EXPECT_LT(record.points.front().truth.v_eb_e.norm(), 1e-9);
  EXPECT_NEAR(record.points.front().flow.speed, kCentreOfMassRate, 1e-9);
}

TEST(Extremes, WindOf100MetresASecond) {
  for (const Vector3d& wind : {Vector3d(100, 0, 0), Vector3d(-100, 0, 0), Vector3d(0, 100, 0)}) {
    Flight plan;
    plan.world.wind.steady = wind;
    const FlightRecord record = fly_perfect(plan);
    expect_sound(record);
    const double forward = kCentreOfMassRate / 100;
    EXPECT_NEAR(record.points.front().flow.speed, 100 * std::hypot(1, forward), 1e-6);
    EXPECT_NEAR(record.points.front().flow.angle_of_attack, 90 * kDegree - forward, 1e-6);
    if (record.ended == Ended::complete && wind.y() > 0) {
      EXPECT_GT(end_of(plan, record).y(), 50);
    }
  }
}

TEST(Extremes, GustAndShearAreFlownThrough) {
  Flight plan;
  plan.world.wind.east = LookupTable::linear({{0, 0}, {10000, 40}, {20000, 10}});
  plan.world.wind.gust = {9000, 300, {0, 9, 0}};
  const FlightRecord record = fly_perfect(plan);
  expect_sound(record);
  EXPECT_EQ(record.ended, Ended::complete) << record.account;
}

TEST(Extremes, LaunchFromThePoleIsLikeAnyOther) {
  for (const double latitude : {90.0, -90.0, 89.9999}) {
    Flight plan;
    plan.world.site = earth::Geodetic::from_degrees(latitude, 0, 0);
    plan.world.wind.steady = {5, 5, 0};
    const FlightRecord record = fly_perfect(plan);
    expect_sound(record);
    EXPECT_EQ(record.ended, Ended::complete) << record.account;
    EXPECT_NEAR(record.end.flow.height, 22.9e3, 700);
  }
}

/// Attitude from spoiled gyros, by their increments.
struct SpoiledGyro {
  PerfectNavigator truth;
  earth::Pose told;
  Eigen::Quaterniond q_ib;
  noise::ImuIncrement last;
  double t = 0;
  double saturation = 1e9;  ///< [rad/s]
  bool dead_pitch = false;
  bool begun = false;

  void know(const earth::Pose& pose) {
    truth.know(pose);
    if (!begun) q_ib = pose.q_eb;
    begun = true;
    told = {pose.p_eb_e, pose.v_eb_e, earth::exp_rotation({0, 0, -earth::wgs84::kEarthRate * t}) * q_ib};
  }
  void step(const noise::ImuIncrement& exact, double dt) {
    last = exact;
    for (double& angle : last.angle) angle = std::clamp(angle, -saturation * dt, saturation * dt);
    if (dead_pitch) last.angle[1] = 0;
    q_ib = q_ib * earth::exp_rotation(earth::vector(last.angle));
    t += dt;
  }
  [[nodiscard]] const noise::ImuIncrement& sensed() const { return last; }
  [[nodiscard]] const earth::Pose& state() const { return told; }
};

TEST(Extremes, SaturatedAndDeadGyrosHaveAnAccount) {
  for (const bool dead : {false, true}) {
    Flight plan;
    AttitudeControl control(plan.vehicle, plan.world.site, {});
    SpoiledGyro navigator;
    navigator.dead_pitch = dead;
    if (!dead) navigator.saturation = 0.2 * kDegree;  // below the program's 0.53 degrees/s
    const FlightRecord record = fly(plan, control, navigator);
    expect_sound(record);
    EXPECT_NE(record.ended, Ended::complete) << record.account;
  }
}

struct LateNavigator {
  std::deque<earth::Pose> poses;
  void know(const earth::Pose& pose) {
    poses.push_back(pose);
    if (poses.size() > 1000) poses.pop_front();
  }
  void step(const noise::ImuIncrement& /*exact*/, double /*dt*/) {}
  [[nodiscard]] const earth::Pose& state() const { return poses.front(); }
};

TEST(Extremes, NavigationTenSecondsLate) {
  Flight plan;
  AttitudeControl control(plan.vehicle, plan.world.site, {});
  LateNavigator navigator;
  const FlightRecord record = fly(plan, control, navigator);
  expect_sound(record);
  EXPECT_NE(record.ended, Ended::complete) << record.account;
}

struct BrokenNavigator : PerfectNavigator {
  int steps = 0;
  earth::Pose pose;
  void step(const noise::ImuIncrement& /*exact*/, double /*dt*/) { ++steps; }
  void know(const earth::Pose& truth) {
    pose = truth;
    if (steps >= 100) pose.q_eb.w() = NAN;
  }
  [[nodiscard]] const earth::Pose& state() const { return pose; }
};

TEST(Extremes, NonsenseFromNavigationEndsTheFlight) {
  Flight plan;
  AttitudeControl control(plan.vehicle, plan.world.site, {});
  BrokenNavigator navigator;
  const FlightRecord record = fly(plan, control, navigator);
  expect_sound(record);
  EXPECT_EQ(record.ended, Ended::not_finite);
  EXPECT_NEAR(record.end.t, 1, 1e-9);
}

// A body that leaves what can be computed ends its flight; a mistake in who steers it is none of that.
TEST(Extremes, AMistakeOfTheControllerIsNoEndOfTheFlight) {
  struct Mistaken {
    Command command(const Seen& seen) const {
      if (seen.t > 1) throw std::invalid_argument("of the controller");
      return {};
    }
  } controller;
  Flight plan;
  PerfectNavigator navigator;
  EXPECT_THROW((void)fly(plan, controller, navigator), std::invalid_argument);
}

TEST(Flight, KnowsHowLongItIsToLast) {
  Flight plan;
  EXPECT_EQ(asked_duration(plan), plan.vehicle.burn_time);
  plan.duration = 20;
  EXPECT_EQ(asked_duration(plan), 20);
  EXPECT_FALSE(ends_early(plan, 20 - 0.9 * plan.period));
  EXPECT_TRUE(ends_early(plan, 20 - 1.1 * plan.period));
}

TEST(Flight, RefusesMisuse) {
  Flight plan;
  plan.period = 0;
  EXPECT_THROW((void)fly_perfect(plan), SetupError);
  plan.period = 0.01;
  plan.duration = -1;
  EXPECT_THROW((void)fly_perfect(plan), std::invalid_argument);
  const auto refused = [](const AttitudeControl::Options& options) {
    EXPECT_THROW(AttitudeControl(vlm1(), earth::alcantara().position, options), std::invalid_argument);
  };
  refused({.frequency = 0});
  refused({.notches = {Notch{60}}});
  refused({.notches = std::vector<Notch>(5, Notch{7})});
}

}  // namespace
}  // namespace gyrobudget::flight
