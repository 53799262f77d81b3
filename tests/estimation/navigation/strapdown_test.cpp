// SPDX-License-Identifier: MIT
// Truth is closed forms (coning, sculling, Schuler, Foucault), earth's trajectories with exact increments,
// and an explicit Runge-Kutta of another make (Boost.Odeint) where neither serves.
#include "gyrobudget/estimation/navigation/strapdown.h"

#include "gyrobudget/noise/normal.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "odes.h"

namespace {

using namespace gyrobudget;
using earth::Geodetic;
using earth::kDegree;
using earth::Trajectory;
using earth::TrajectoryPoint;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using navigation::Strapdown;
using noise::ImuIncrement;
using std::numbers::pi;

constexpr double kG = 9.80665;

struct Error {
  double position, velocity;
  Vector3d attitude;  ///< in body axes
};

Error error_of(const Strapdown& strapdown, const TrajectoryPoint& truth) {
  const earth::Pose& s = strapdown.state();
  return {(s.p_eb_e - truth.pose.p_eb_e).norm(), (s.v_eb_e - truth.pose.v_eb_e).norm(),
          earth::log_rotation(truth.pose.q_eb.conjugate() * s.q_eb)};
}

/// Error at the end of `truth`, from its start in steps of dt.
Error flown(const Trajectory& truth, double dt, const Strapdown::Options& options = {}) {
  Strapdown strapdown(truth.at(0).pose, options);
  const auto imu = truth.increments(dt);
  for (const ImuIncrement& increment : imu) strapdown.step(increment, dt);
  return error_of(strapdown, truth.at(std::min(dt * static_cast<double>(imu.size()), truth.duration())));
}

Trajectory standing(const earth::Vibration& vibration, double duration) {
  earth::Stand stand;
  stand.vibration = vibration;
  stand.duration = duration;
  return earth::stand(stand);
}

/// 300 m/s, S-turns at 0.5 g with 5 degrees of bank a second, 1 degree of coning and 0.2 g of sculling at 5
/// Hz.
Trajectory moving(double duration) {
  earth::Cruise cruise;
  cruise.speed = 300;
  cruise.turn_acceleration = 0.5 * kG;
  cruise.turn_period = 33;
  cruise.vibration = {.coning_angle = kDegree,
                      .coning_frequency = 5,
                      .sculling_angle = kDegree,
                      .sculling_acceleration = 0.2 * kG,
                      .sculling_frequency = 5};
  cruise.duration = duration;
  return earth::cruise(cruise);
}

// --- Coning and sculling -----------------------------------------------------------------------------------

constexpr double kStep = 0.01;

/// Drift left over by an order, relative to the coning rate 2 sin^2(a/2) w, at x = w dt.
double coning_left(int order, double x) {
  constexpr double duration = 20;
  const double w = x / kStep;
  const Trajectory truth = standing({.coning_angle = kDegree, .coning_frequency = w / (2 * pi)}, duration);
  const double rate = 2 * std::pow(std::sin(kDegree / 2), 2) * w;
  return flown(truth, kStep, {.order = order}).attitude.norm() / (rate * duration);
}

TEST(StrapdownConing, OrdersOneToThreeDriftAsTheTextbookSays) {
  // A cone turns each increment by x about the x axis: |a_k| = 2 a sin(x/2), and a_(k-j) x a_k rectifies to
  // |a_k|^2 sin(j x). True rectification per step is a^2/2 (x - sin x); order 2 takes a_(k-1) x a_k/12 of
  // it, order 3 a_(k-1) x a_k/6 - a_(k-2) x a_k/24 (Savage, 7.1.1.1.1; Ignagni, J. Guidance 19:424, 1996).
  // Beside a^2/2 x.
  for (const double x : {0.3, 0.6, 1.2}) {
    const double none = 1 - std::sin(x) / x;
    const double square = 8 * (1 - std::cos(x)) / 2 / x;
    const double two = none - square * std::sin(x) / 12;
    const double three = none - square * (std::sin(x) / 6 - std::sin(2 * x) / 24);
    constexpr double kTolerance = 4e-3;  // a^2 and what the ends of 20 s leave
    EXPECT_NEAR(coning_left(1, x) / none, 1, kTolerance) << x;
    EXPECT_NEAR(coning_left(2, x) / std::abs(two), 1, 10 * kTolerance) << x;
    EXPECT_NEAR(coning_left(3, x) / std::abs(three), 1, 10 * kTolerance) << x;
  }
}

TEST(StrapdownConing, EvenOrderFallsWithTwoMorePowersOfTheStep) {
  // Relative to the coning rate an even order n leaves x^(n + 2), an odd one x^(n + 1).
  for (const auto& [order, power] : {std::pair{1, 2}, {2, 4}, {3, 4}, {4, 6}, {5, 6}, {6, 8}, {7, 8}}) {
    const double fall = std::log2(coning_left(order, 0.3) / coning_left(order, 0.15));
    EXPECT_NEAR(fall, power, 0.5) << order;
  }
}

constexpr double kSwing = 0.5 * kDegree;
constexpr double kShake = 2;  // [m/s^2]

/// False acceleration along the vertical that an order leaves of sculling, at x = w dt [m/s^2].
double sculling_left(int order, double x) {
  constexpr double duration = 20;
  const Trajectory truth =
      standing({.sculling_angle = kSwing, .sculling_acceleration = kShake, .sculling_frequency = x / kStep / (2 * pi)},
               duration);
  Strapdown strapdown(truth.at(0).pose, {.order = order});
  for (const ImuIncrement& increment : truth.increments(kStep)) strapdown.step(increment, kStep);
  const Geodetic& place = earth::alcantara().position;
  const Vector3d up = earth::up_e(place.latitude, place.longitude);
  return std::abs((strapdown.state().v_eb_e - truth.at(duration).pose.v_eb_e).dot(up)) / duration;
}

TEST(StrapdownVibration, OfAnyFrequencyIsNeverWorseForTheDefaultThanForOrderOne) {
  const int chosen = Strapdown::Options{}.order;
  for (double x = 0.2; x < pi; x += 0.2) {
    EXPECT_LT(coning_left(chosen, x), coning_left(1, x)) << x;
    EXPECT_LT(sculling_left(chosen, x), sculling_left(1, x)) << x;
  }
}

TEST(StrapdownVibration, BelowAFifthOfTheRateTheHighestOrderIsBetterThanTheDefault) {
  constexpr double kAFifth = 2 * pi / 5;
  for (const double x : {0.2, 0.6, 1.0, kAFifth}) {
    EXPECT_LT(coning_left(Strapdown::kHighestOrder, x), coning_left(Strapdown::Options{}.order, x)) << x;
    EXPECT_LT(sculling_left(Strapdown::kHighestOrder, x), sculling_left(Strapdown::Options{}.order, x)) << x;
  }
}

TEST(StrapdownVibration, NearHalfTheRateTheHighestOrderIsBounded) {
  constexpr double kWorst = 10;  // of order 1; the table in strapdown.h has 9.6
  for (double x = pi / 2; x < pi; x += 0.2) {
    EXPECT_LT(coning_left(Strapdown::kHighestOrder, x), kWorst * coning_left(1, x)) << x;
    EXPECT_LT(sculling_left(Strapdown::kHighestOrder, x), kWorst * sculling_left(1, x)) << x;
  }
}

TEST(StrapdownSculling, DriftsAsTheTextbookSays) {
  // Roll and side force in phase: of the mean 1/2 angle A along z, order 1 leaves 1 - sin x/x. Weight
  // swings in body axes with the roll: it adds g angle to A, less what the straight lines of order 1 lose
  // of its mean cosine.
  const auto textbook = [&](double x) {
    return kSwing / 2 * ((kShake + kG * kSwing) * (1 - std::sin(x) / x) - kG * kSwing * (1 - std::cos(x)) / 6);
  };
  const double x = 0.2 * pi;
  EXPECT_NEAR(sculling_left(1, x) / textbook(x), 1, 5e-3);
  EXPECT_NEAR(sculling_left(1, x / 2) / textbook(x / 2), 1, 5e-3);
  EXPECT_NEAR(std::log2(sculling_left(2, x) / sculling_left(2, x / 2)), 4, 0.5);
  EXPECT_LT(sculling_left(2, x / 2), 0.03 * textbook(x / 2));
  EXPECT_LT(sculling_left(4, x / 2), 0.2 * sculling_left(2, x / 2));
  EXPECT_LT(sculling_left(6, x / 2), 0.2 * sculling_left(4, x / 2));
  EXPECT_LT(sculling_left(8, x / 2), 0.2 * sculling_left(6, x / 2));
}

// --- Moving, at any place, attitude and step ---------------------------------------------------------------

TEST(StrapdownMoving, AThousandSecondsOfTurnsAndVibrationBelowACentimetreWithTheHighestOrder) {
  const Error error = flown(moving(1000), 0.005, {.order = Strapdown::kHighestOrder});
  EXPECT_LT(error.position, 4e-3);
  EXPECT_LT(error.velocity, 1e-5);
  EXPECT_LT(error.attitude.norm(), 4e-9);
}

TEST(StrapdownMoving, ErrorFallsAtItsOrderFromATenthOfASecondToAMillisecond) {
  earth::Cruise cruise;
  cruise.turn_acceleration = 5;
  cruise.turn_period = 6;
  cruise.duration = 20;
  const Trajectory truth = earth::cruise(cruise);
  constexpr double kRounding = 2e-15;
  for (const auto& [order, power] : {std::pair{1, 2}, {2, 3}, {3, 4}, {4, 5}, {6, 6}}) {
    double before = 0;
    for (const double dt : {0.1, 0.05, 0.025}) {
      const double error = flown(truth, dt, {.order = order}).attitude.norm();
      if (before > 0) {
        EXPECT_LT(error, before / std::exp2(power - 0.4) + 20 / dt * kRounding) << order << ' ' << dt;
      }
      before = error;
    }
  }
  constexpr double kAtOnce = 1e-6;         // [m] what jumps and rounding leave at any step
  constexpr double kOfGravitation = 1e-3;  // [m/s^2] its values amid the steps
  constexpr double kOfTurns = 6;  // [m/s^5] half a tilt times gravity over 20 s; a tilt of order 4 falls as dt^5
  for (const double dt : {0.1, 0.01, 0.001}) {
    const double highest = kAtOnce + kOfGravitation * dt * dt;
    EXPECT_LT(flown(truth, dt, {.order = Strapdown::kHighestOrder}).position, highest) << dt;
    EXPECT_LT(flown(truth, dt).position, highest + kOfTurns * std::pow(dt, 5)) << dt;
  }
}

TEST(StrapdownMoving, StepsMayBeUneven) {
  const Trajectory truth = moving(30);
  const auto jittered = [&](double spread, int order) {
    Strapdown strapdown(truth.at(0).pose, {.order = order});
    double t = 0;
    for (int k = 0; t < 29.9; ++k) {
      const double dt = 0.005 * (1 + spread * std::sin(12.9898 * k));
      strapdown.step(truth.increment(t, t + dt), dt);
      t += dt;
    }
    return error_of(strapdown, truth.at(t));
  };
  constexpr double kSpread = 0.4;
  const Error even = jittered(0, Strapdown::kHighestOrder);
  const Error uneven = jittered(kSpread, Strapdown::kHighestOrder);
  EXPECT_LT(even.position, 2e-7);
  EXPECT_LT(uneven.position, 5e-6);
  EXPECT_LT(uneven.attitude.norm(), 5e-9);
  // What order 4 leaves of vibration goes with the sixth power of the step, of which the longest counts most.
  const int chosen = Strapdown::Options{}.order;
  const double growth = std::pow(1 + kSpread, chosen + 2);
  EXPECT_LT(jittered(kSpread, chosen).position, growth * jittered(0, chosen).position);
  EXPECT_LT(jittered(kSpread, chosen).attitude.norm(), growth * jittered(0, chosen).attitude.norm());
}

TEST(StrapdownMoving, AChangeOfRateEndsTheHistory) {
  // From 200 Hz to 50 Hz and back, and once a time stamp a nanosecond after the last.
  constexpr double kSlow = 0.02;          // [s]
  constexpr double kSlowFrom = 6;         // [s]
  constexpr double kSlowUntil = 8;        // [s]
  constexpr double kEnd = 10;             // [s]
  constexpr double kShaken = 2 * pi * 5;  // [rad/s] coning and sculling of moving()
  const Trajectory truth = moving(12);
  const auto error_with = [&](int order) {
    Strapdown strapdown(truth.at(0).pose, {.order = order});
    double t = 0;
    const auto go = [&](double until, double dt) {
      for (; t < until - dt / 2; t += dt) strapdown.step(truth.increment(t, t + dt), dt);
    };
    go(4, 0.005);
    go(4 + 1e-9, 1e-9);
    go(kSlowFrom, 0.005);
    go(kSlowUntil, kSlow);
    go(kEnd, 0.002);
    return error_of(strapdown, truth.at(t));
  };
  const Error highest = error_with(Strapdown::kHighestOrder);
  EXPECT_LT(highest.attitude.norm(), 1e-5);
  EXPECT_LT(highest.position, 1e-3);
  // The default has the cone's rate left over while steps are long, and as much again for sculling; that tilts gravity.
  const int chosen = Strapdown::Options{}.order;
  const double cone = 2 * std::pow(std::sin(kDegree / 2), 2) * kShaken;
  const double tilt = 2 * coning_left(chosen, kShaken * kSlow) * cone * (kSlowUntil - kSlowFrom);
  const Error error = error_with(chosen);
  EXPECT_LT(error.attitude.norm(), tilt);
  EXPECT_LT(error.position, tilt * kG * std::pow(kEnd - kSlowFrom, 2) / 2);
}

TEST(StrapdownMoving, OverThePolesAndTheDateLine) {
  for (const auto& [latitude, longitude, azimuth] :
       {std::tuple{89.9, 30.0, 0.0}, {-89.9, 30.0, 180.0}, {0.0, 179.9, 90.0}, {45.0, -179.9, 270.0}}) {
    earth::Cruise cruise;
    cruise.start = Geodetic::from_degrees(latitude, longitude, 5000);
    cruise.azimuth = azimuth * kDegree;
    cruise.duration = 100;
    const Error error = flown(earth::cruise(cruise), 0.05);
    EXPECT_LT(error.position, 1e-6) << latitude;
    EXPECT_LT(error.attitude.norm(), 1e-13) << latitude;
  }
}

TEST(StrapdownMoving, NoseStraightUpOrDown) {
  const Error up = flown(earth::climb({}), 0.01);
  EXPECT_LT(up.position, 1e-7);
  EXPECT_LT(up.attitude.norm(), 1e-14);
  earth::Stand down;
  down.q_nb = earth::from_euler({0.3, -pi / 2, 0});
  down.vibration = {.coning_angle = kDegree, .coning_frequency = 1};
  down.duration = 100;
  EXPECT_LT(flown(earth::stand(down), 0.01).attitude.norm(), 1e-9);
}

TEST(StrapdownMoving, FiveTurnsASecondAndATurnAStep) {
  earth::Stand stand;
  stand.spin = Vector3d(1, 2, 2) / 3 * 10 * pi;
  stand.duration = 60;
  const Trajectory truth = earth::stand(stand);
  // What is fixed in space turns in body axes by 1.8, 9 and 18 degrees a step.
  for (const auto& [dt, attitude, position] :
       {std::tuple{0.001, 1e-13, 1e-8}, {0.005, 2e-11, 1e-4}, {0.01, 2e-9, 5e-3}}) {
    const Error error = flown(truth, dt, {.order = Strapdown::kHighestOrder});
    EXPECT_LT(error.attitude.norm(), attitude) << dt;
    EXPECT_LT(error.position, position) << dt;
  }
  const Error fine = flown(truth, 0.005);
  const Error coarse = flown(truth, 0.01);
  const int chosen = Strapdown::Options{}.order;
  EXPECT_NEAR(std::log2(coarse.attitude.norm() / fine.attitude.norm()), chosen + 1, 0.1);
  EXPECT_NEAR(std::log2(coarse.position / fine.position), chosen + 1, 0.1);
  // At a turn a step weight averages to its part along the axis: attitude survives, but for what Earth's
  // rate across the axis would add, position cannot.
  const Error whole = flown(truth, 0.2);
  EXPECT_LT(whole.attitude.norm(), earth::wgs84::kEarthRate * 60);
  // With the axis along weight and Earth's axis (at the pole) nothing is lost.
  stand.position = {pi / 2, 0, 0};
  stand.spin = {0, 0, 10 * pi};
  const Error polar = flown(earth::stand(stand), 0.2);
  EXPECT_LT(polar.attitude.norm(), 1e-11);
  EXPECT_LT(polar.position, 1e-6);
}

TEST(StrapdownMoving, AscentToMicrometres) {
  // Error is that of the jump in angular rate where pitch-over begins: it is felt by one step, as dt^2.
  EXPECT_LT(flown(earth::ascent({}), 0.01).position, 2e-4);
  EXPECT_LT(flown(earth::ascent({}), 0.001).position, 2e-6);
  EXPECT_LT(flown(earth::ascent({}), 0.1).position, 2e-2);
}

TEST(StrapdownMoving, LargeAnglesAgainstRungeKutta) {
  // Rates of 2 rad/s about all axes for 20 s, nowhere near small angles; no Earth rate in the attitude, so
  // that q_eb is the integral of these rates alone.
  Strapdown strapdown({earth::to_ecef({}), Vector3d::Zero(), Quaterniond::Identity()},
                      {.earth_rate_in_attitude = false});
  constexpr double dt = 0.005;
  for (int k = 0; k < 4000; ++k)
    strapdown.step({.angle = earth::array(odes::tumbling_angle((k + 1) * dt) - odes::tumbling_angle(k * dt))}, dt);
  const Quaterniond truth = odes::tumbled(20);
  EXPECT_LT(earth::log_rotation(truth.conjugate() * strapdown.state().q_eb).norm(), 2e-11);
}

TEST(StrapdownMoving, FreeFallIsAnOrbit) {
  // 7.7 km/s at 300 km, inclined: nothing is sensed. Against a Runge-Kutta of order 8 in inertial axes over
  // half a revolution, and the angular momentum about Earth's axis, which a zonal field leaves as it is.
  const Vector3d p = earth::to_ecef({0.3, 0.2, 300e3});
  const Vector3d v = earth::C_e_enu(0.3, 0.2) * Vector3d(4000, 6000, 100);
  const Vector3d w{0, 0, earth::wgs84::kEarthRate};
  const auto momentum = [&](const Vector3d& p_eb_e, const Vector3d& v_eb_e) {
    return p_eb_e.cross(v_eb_e + w.cross(p_eb_e)).z();
  };
  constexpr double kDuration = 2700;
  const auto [p_i, v_i] = odes::orbit(p, v + w.cross(p), kDuration);
  const auto truth = earth::Inertial().to_ecef({p_i, v_i}, kDuration);
  double coarse = 0;
  for (const double dt : {1.0, 0.5}) {
    Strapdown strapdown({p, v, Quaterniond::Identity()});
    for (double t = 0; t < kDuration - dt / 2; t += dt) strapdown.step({}, dt);
    const earth::Pose& end = strapdown.state();
    const double error = (end.p_eb_e - truth.p).norm();
    EXPECT_LT(error, 0.05 * dt * dt) << dt;
    EXPECT_NEAR(momentum(end.p_eb_e, end.v_eb_e) / momentum(p, v), 1, 1e-8) << dt;
    if (coarse > 0) {
      EXPECT_LT(error, coarse / 3);
    }
    coarse = error;
  }
}

// --- Long times --------------------------------------------------------------------------------------------

/// Height and climb held, as a barometer would: without it the vertical grows e-fold every sqrt(R/2g) = 570
/// s.
void hold_level(Strapdown& strapdown, double height) {
  earth::Pose state = strapdown.state();
  Geodetic place = earth::to_geodetic(state.p_eb_e);
  const Vector3d up = earth::up_e(place.latitude, place.longitude);
  place.height = height;
  state.p_eb_e = earth::to_ecef(place);
  state.v_eb_e -= up * up.dot(state.v_eb_e);
  strapdown.set_state(state);
}

TEST(StrapdownLong, StandsStillForTenHours) {
  const Trajectory truth = standing({}, 36000);
  const TrajectoryPoint start = truth.at(0);
  const ImuIncrement increment = truth.increment(0, 0.01);
  Strapdown strapdown(start.pose, {.order = 1});
  for (int second = 0; second < 36000; ++second) {
    for (int k = 0; k < 100; ++k) strapdown.step(increment, 0.01);
    if (second == 3599) {  // nothing held in the first hour
      EXPECT_LT(error_of(strapdown, start).position, 1e-6);
    }
    if (second >= 3599) hold_level(strapdown, 0);
  }
  const Error error = error_of(strapdown, start);
  EXPECT_LT(error.position, 1e-4);
  EXPECT_LT(error.attitude.norm(), 1e-11);
}

TEST(StrapdownLong, SchulerPeriodAndFoucaultTurn) {
  // A horizontal velocity error at 45 N swings with w_s = sqrt(g/R) (84 minutes) while its plane turns
  // clockwise at Omega sin L: error = v/w' exp(-i Omega sin L t) sin w' t, w'^2 = w_s^2 + (Omega sin L)^2,
  // in east + i north.
  const Geodetic place{pi / 4, 0.5, 0};
  earth::Stand stand;
  stand.position = place;
  stand.duration = 10;
  const Trajectory truth = earth::stand(stand);
  constexpr double dt = 1;
  const ImuIncrement increment = truth.increment(0, dt);
  earth::Pose state = truth.at(0).pose;
  const auto local = earth::LocalFrame::east_north_up(place);
  constexpr double v = 0.1;
  state.v_eb_e += local.C_el() * Vector3d(0, v, 0);
  Strapdown strapdown(state);
  const double spin = earth::wgs84::kEarthRate * std::sin(place.latitude);
  const double radius = (earth::meridian_radius(pi / 4) + earth::transverse_radius(pi / 4)) / 2;
  const double w = std::hypot(std::sqrt(earth::somigliana(pi / 4) / radius), spin);
  double worst = 0;
  double last = 0;
  std::vector<double> returns;  // times at which the error along the turning plane passes zero
  for (int k = 1; k <= 6 * 3600; ++k) {
    strapdown.step(increment, dt);
    hold_level(strapdown, 0);
    const Vector3d p = local.from_ecef(strapdown.state().p_eb_e);
    const double along = p.y() * std::cos(spin * k) + p.x() * std::sin(spin * k);
    const double across = p.x() * std::cos(spin * k) - p.y() * std::sin(spin * k);
    worst = std::max({worst, std::abs(along - v / w * std::sin(w * k)), std::abs(across)});
    if (k > 1 && (along > 0) != (last > 0)) returns.push_back(k - along / (along - last));
    last = along;
  }
  EXPECT_LT(worst, 0.02 * v / w);
  ASSERT_EQ(returns.size(), 8u);
  const double period = (returns[7] - returns[1]) / 3;
  EXPECT_NEAR(period / (2 * pi / w), 1, 2e-3);
  EXPECT_NEAR(period / 60, 84.4, 0.3);
}

// --- What is left out, what is refused ---------------------------------------------------------------------

TEST(StrapdownEarthRate, LeftOutItIsAThirdOfADegreeOverAnAscent) {
  // In body axes at burnout, pitch 50 degrees: roll, pitch, yaw.
  for (const auto& [azimuth, expected] :
       {std::pair{90.0, Vector3d(-0.011, -0.347, 0.009)}, {0.0, Vector3d(0.212, 0, 0.275)}}) {
    earth::Ascent ascent;
    ascent.azimuth = azimuth * kDegree;
    const Trajectory truth = earth::ascent(ascent);
    const Vector3d error = flown(truth, 0.01, {.earth_rate_in_attitude = false}).attitude;
    EXPECT_NEAR(error.norm() / kDegree, 0.347, 5e-4);
    EXPECT_NEAR(error.norm(), earth::wgs84::kEarthRate * 83, 1e-9);
    EXPECT_LT((error / kDegree - expected).norm(), 3e-3) << azimuth << ": " << error.transpose() / kDegree;
  }
}

TEST(Strapdown, NoiseIsNotAmplifiedByTheHistory) {
  // Angle noise on a body that spins: what a high order adds to the increments sums to nothing.
  earth::Stand stand;
  stand.spin = {3, 0, 0};
  stand.duration = 200;
  const Trajectory truth = earth::stand(stand);
  const auto imu = truth.increments(0.01);
  std::vector<double> noise(3 * imu.size());
  const auto variance = [&](int order) {
    double sum = 0;
    for (std::uint64_t run = 0; run < 20; ++run) {
      noise::fill_normal({.seed = 7, .stream = run}, 0, noise);
      auto next = noise.begin();
      Strapdown strapdown(truth.at(0).pose, {.order = order});
      for (ImuIncrement increment : imu) {
        for (double& angle : increment.angle) angle += 1e-6 * *next++;
        strapdown.step(increment, 0.01);
      }
      sum += error_of(strapdown, truth.at(200)).attitude.squaredNorm();
    }
    return sum;
  };
  EXPECT_NEAR(variance(8) / variance(1), 1, 0.01);
}

TEST(Strapdown, ACorrectionKeepsTheHistory) {
  const Trajectory truth = moving(20);
  const auto imu = truth.increments(0.005);
  Strapdown plain(truth.at(0).pose);
  Strapdown corrected(truth.at(0).pose);
  for (std::size_t k = 0; k < imu.size(); ++k) {
    plain.step(imu[k], 0.005);
    corrected.step(imu[k], 0.005);
    if (k > 100 && k % 100 == 0) corrected.set_state(corrected.state());
  }
  EXPECT_LT((plain.state().p_eb_e - corrected.state().p_eb_e).norm(), 1e-7);
  EXPECT_LT(plain.state().q_eb.angularDistance(corrected.state().q_eb), 1e-13);
}

TEST(Strapdown, SpecificForceOfTheLastStepIsTheMean) {
  const Trajectory truth = earth::ascent({});
  Strapdown strapdown(truth.at(0).pose);
  EXPECT_EQ(strapdown.last_specific_force_e(), Vector3d::Zero());
  for (int k = 0; k < 3000; ++k) strapdown.step(truth.increment(0.01 * k, 0.01 * (k + 1)), 0.01);
  const TrajectoryPoint mid = truth.at(29.995);
  EXPECT_LT((strapdown.last_specific_force_e() - mid.pose.q_eb * mid.sensed.f_ib_b).norm(), 1e-5);
}

TEST(Strapdown, RefusesAndStaysWhereItWas) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const earth::Pose good{earth::to_ecef({}), Vector3d::Zero(), Quaterniond::Identity()};
  Strapdown strapdown(good);
  const ImuIncrement imu{.angle = {0, 0.1, 0}, .velocity = {0.1, 0, 0}};
  strapdown.step(imu, 0.0);
  EXPECT_EQ(strapdown.state().p_eb_e, good.p_eb_e);
  EXPECT_EQ(strapdown.state().q_eb.coeffs(), good.q_eb.coeffs());
  EXPECT_THROW(strapdown.step(imu, -0.01), std::invalid_argument);
  EXPECT_THROW(strapdown.step(imu, nan), std::invalid_argument);
  EXPECT_THROW(strapdown.step(imu, std::numeric_limits<double>::infinity()), std::invalid_argument);
  EXPECT_THROW(strapdown.step({.velocity = {nan, 0, 0}}, 0.01), std::invalid_argument);
  EXPECT_THROW(strapdown.step({.velocity = {-4.6e8, 0, 0}}, 0.11), std::invalid_argument);
  EXPECT_EQ(strapdown.state().p_eb_e, good.p_eb_e);
  earth::Pose bad = good;
  bad.q_eb.coeffs() *= 1.1;
  EXPECT_THROW(Strapdown{bad}, std::invalid_argument);
  bad = good;
  bad.p_eb_e.setZero();
  EXPECT_THROW(Strapdown{bad}, std::invalid_argument);
  bad = good;
  bad.v_eb_e.x() = nan;
  EXPECT_THROW(Strapdown{bad}, std::invalid_argument);
  EXPECT_THROW(Strapdown(good, {.order = 0}), std::invalid_argument);
  EXPECT_THROW(Strapdown(good, {.order = Strapdown::kHighestOrder + 1}), std::invalid_argument);
}

TEST(Strapdown, AHundredSecondsInOneStep) {
  // At rest on Earth, f and w constant in body axes: only gravitation's curve along the way is approximated.
  EXPECT_LT(flown(standing({}, 100), 100).position, 0.2);
  EXPECT_LT(flown(standing({}, 100), 100).attitude.norm(), 1e-15);
}

}  // namespace
