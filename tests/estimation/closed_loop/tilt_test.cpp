// SPDX-License-Identifier: MIT
// First-order theory of a wrong attitude, against flights.
#include "gyrobudget/estimation/closed_loop/tilt.h"

#include "gyrobudget/estimation/closed_loop/study.h"
#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/flight/point_mass.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrobudget::closed_loop {
namespace {

using earth::kDegree;
using Eigen::Vector3d;

// What the theory leaves out: of a distance, and across it, where height changes drag.
constexpr double kTheory = 0.025, kAcross = 0.055;
void expect_near(const Vector3d& flown, const Vector3d& theory) {
  EXPECT_NEAR(flown.norm() / theory.norm(), 1, kTheory);
  EXPECT_LT((flown - theory).norm(), kAcross * flown.norm());
}

struct Vehicles : testing::TestWithParam<flight::Vehicle (*)()> {
  flight::Plan plan = [] {
    flight::Plan p;
    p.flight.vehicle = GetParam()();
    return p;
  }();
  TiltResponse response{plan};
  [[nodiscard]] Vector3d departure(const flight::Plan& other) const {
    return fly_nominal(other).end.truth.p_eb_e - response.nominal().end.truth.p_eb_e;
  }
};
INSTANTIATE_TEST_SUITE_P(Of, Vehicles, testing::Values(&flight::vlm1, &flight::vlm1_paper),
                         [](const auto& of) { return of.index == 0 ? "Vlm1" : "Paper"; });

TEST_P(Vehicles, RateFeedbackFliesLateByTwiceDampingOverFrequency) {
  flight::Plan lagging = plan;
  lagging.control.feedback = flight::RateFeedback::rate;
  const double lag = 2 * plan.control.damping / plan.control.frequency;
  const auto psi = [&](double t) -> Vector3d { return -lag * plan.control.pitch.at(t).first * response.pitch_axis(t); };
  expect_near(departure(lagging), response.position(psi));
  // The same from a program that comes so much later: a lag and nothing else.
  flight::Plan late = plan;
  late.control.pitch = flight::LookupTable::linear({{8 + lag, 90 * kDegree}, {83 + lag, 50 * kDegree}});
  EXPECT_NEAR(departure(lagging).norm() / departure(late).norm(), 1, 0.01);
}

TEST_P(Vehicles, AnOffsetOfTheAttitude) {
  for (const double offset : {-1 * kDegree, 1 * kDegree}) {
    flight::Plan off = plan;
    off.control.pitch = flight::LookupTable::linear({{8, 90 * kDegree + offset}, {83, 50 * kDegree + offset}});
    expect_near(departure(off),
                response.position([&](double t) -> Vector3d { return offset * response.pitch_axis(t); }));
  }
}

class StrapdownWithoutEarthRate {
 public:
  explicit StrapdownWithoutEarthRate(const earth::Pose& pose) : strapdown_(pose, {.earth_rate_in_attitude = false}) {}
  void step(const noise::ImuIncrement& increment, double dt) { strapdown_.step(increment, dt); }
  [[nodiscard]] const earth::Pose& state() const { return strapdown_.state(); }

 private:
  navigation::Strapdown strapdown_;
};

TEST_P(Vehicles, EarthRateLeftOutTurnsTheFlightAboutThePoles) {
  StrapdownWithoutEarthRate navigator(pose_on_pad(plan.flight));
  const auto flown = fly(plan, plan.flight, {}, navigator);
  expect_near(flown.end.truth.p_eb_e - response.nominal().end.truth.p_eb_e,
              response.position([](double t) { return Vector3d(0, 0, -earth::wgs84::kEarthRate * t); }));
}

TEST(TiltResponse, TheLoopGivesWayToTheAir) {
  flight::Plan plan;
  plan.flight.vehicle = flight::vlm1_paper();
  const TiltResponse response(plan);
  const flight::AttitudeControl program(plan.flight.vehicle, plan.flight.world.site, plan.control);
  const auto exact = fly_point_mass(plan.flight, program);
  const double ahead =
      plan.flight.vehicle.imu_station - flight::burn_state(plan.flight.vehicle, exact.end.t).centre_of_mass;
  const Vector3d imu = exact.end.truth.p_eb_e + exact.end.truth.q_eb * Vector3d(ahead, 0, 0);
  expect_near(response.nominal().end.truth.p_eb_e - imu, response.position_of_standing_error());
  plan.flight.world.atmosphere = false;
  EXPECT_EQ(TiltResponse(plan).position_of_standing_error().norm(), 0);
}

TEST(TiltResponse, NoiseAndBiasesDisperseAsManyFlightsDo) {
  constexpr int kRuns = 60;
  noise::SensorModel sensor;
  sensor.gyro.white = 0.15 * kDegree / 60;
  sensor.gyro.rate_random_walk = 20 * kDegree / 3600 / 60;
  sensor.gyro.turn_on_bias = {1 * kDegree / 3600, 2 * kDegree / 3600, 0};
  navigation::Scenario scene;
  scene.sensor = sensor;
  const Study many = study({}, {}, scene, {.runs = kRuns});
  const TiltResponse response{flight::Plan{}};
  const auto of = [&](noise::ErrorModel gyro) { return response.covariance(gyro).trace(); };
  double square = 0;
  for (const Outcome& o : many.sensors.outcomes) square += o.position.squaredNorm() / kRuns;
  // Two directions or more: 99.9 % of mean squares of 60 runs, and the theory's own error.
  const double band = 3.3 / std::sqrt(kRuns) + 2 * kTheory;
  EXPECT_NEAR(square / of(sensor.gyro), 1, band);
  // Each of the three has its part, and parts add up.
  noise::ErrorModel white, walk, bias;
  white.white = sensor.gyro.white;
  walk.rate_random_walk = sensor.gyro.rate_random_walk;
  bias.turn_on_bias = sensor.gyro.turn_on_bias;
  EXPECT_NEAR(of(white) + of(walk) + of(bias), of(sensor.gyro), 1e-9 * of(sensor.gyro));
  for (const auto& part : {white, walk, bias}) EXPECT_GT(of(part), 0.02 * of(sensor.gyro));
  // So do axes, and noise about the thrust's own axis does less than about the others.
  const auto alone = [&](std::size_t axis) {
    noise::ErrorModel one;
    one.white[axis] = white.white[axis];
    return of(one);
  };
  EXPECT_NEAR(alone(0) + alone(1) + alone(2), of(white), 1e-9 * of(white));
  EXPECT_LT(alone(0), alone(1));
}

}  // namespace
}  // namespace gyrobudget::closed_loop
