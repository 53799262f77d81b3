// SPDX-License-Identifier: MIT
// A filter that is lost says so, and finds its way back: a reduced lost_study, and what it rests on.
#include "gyrobudget/estimation/navigation/innovation_check.h"
#include "gyrobudget/estimation/navigation/navigate.h"
#include "gyrobudget/estimation/navigation/simulated_fixes.h"
#include "gyrobudget/estimation/navigation/suspects.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lost_runs.h"

namespace gyrobudget::navigation {
namespace {

using earth::kDegree;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Status = Navigation::Status;

constexpr double kRate = 50;  // Hz

// A car in S-turns, 100 s, with a GNSS of 0.1 m and 5 cm/s at 2 Hz that starts the filter, and an IMU that the filter
// takes for a little noisy.
struct Car {
  earth::Trajectory truth = earth::cruise({.speed = 15, .turn_acceleration = 2, .turn_period = 50, .duration = 100});
  Scenario scene;
  Recording recording;

  Car() {
    scene.sensor.gyro.white = 1e-4;
    scene.sensor.gyro.turn_on_bias = 1e-4;
    scene.sensor.accelerometer.emplace();
    scene.sensor.accelerometer->white = 1e-3;
    scene.sensor.accelerometer->turn_on_bias = 1e-2;
    scene.aids = {aid("gnss.position", Aid::Kind::position, 0.1), aid("gnss.velocity", Aid::Kind::velocity, 0.05)};
    scene.alignment.position = FromAid{0};
    scene.alignment.velocity = FromAid{1};
    const earth::Pose start = truth.at(0).pose;
    const earth::Geodetic place = earth::to_geodetic(start.p_eb_e);
    scene.alignment.attitude =
        earth::to_euler(Eigen::Quaterniond(earth::C_e_ned(place.latitude, place.longitude)).conjugate() * start.q_eb);
    scene.alignment.level_sigma = 0.2 * kDegree;
    scene.alignment.heading_sigma = 2 * kDegree;
    recording.imu.increments = truth.increments(1 / kRate);
    recording.imu.typical_interval = 1 / kRate;
    for (std::size_t k = 0; k <= recording.imu.increments.size(); ++k)
      recording.imu.stamps.push_back(std::llround(static_cast<double>(k) / kRate * 1e9));
    recording.imu.bridged.assign(recording.imu.increments.size(), false);
    measure();
  }

  static Aid aid(const char* name, Aid::Kind kind, double sigma) {
    Aid a;
    a.name = name;
    a.kind = kind;
    a.sigma.setConstant(sigma);
    a.rate = 2;
    a.clock = "gnss";
    return a;
  }

  // Fixes as the aids are now.
  void measure() {
    recording.fixes.clear();
    for (std::size_t i = 0; i < scene.aids.size(); ++i)
      recording.fixes.push_back(
          simulated_fixes(scene.aids[i], static_cast<int>(i), truth, 1, 0, static_cast<int>(clock_of(scene.aids, i))));
  }

  // Position error over its sigma in the worst axis.
  [[nodiscard]] double in_sigmas(const Solution& s) const {
    const earth::Geodetic at = earth::to_geodetic(s.state.p_eb_e);
    const Vector3d error =
        earth::C_e_enu(at.latitude, at.longitude).transpose() * (truth.at(s.time).pose.p_eb_e - s.state.p_eb_e);
    return error.cwiseQuotient(s.position_sigma).cwiseAbs().maxCoeff();
  }
};

constexpr double kFar = 5;  // sigmas: a right solution is that far off once in 1e6

TEST(Lost, ARightSceneIsNavigatedWithoutASpan) {
  const Car car;
  const Navigation found = navigate(car.scene, car.recording);
  EXPECT_EQ(found.status, Status::navigated) << found.why;
  EXPECT_TRUE(found.lost.empty());
  EXPECT_TRUE(suspects(car.scene, car.recording).empty());
}

// Wrong by a kilometre, sure of a metre: said with the span, and right after it.
TEST(Lost, AWrongStartIsFoundAgain) {
  Car car;
  earth::Geodetic start = earth::to_geodetic(car.truth.at(0).pose.p_eb_e);
  start.latitude += 1000 / 6.4e6;
  car.scene.alignment.position = start;
  car.scene.alignment.position_sigma = Vector3d::Ones();
  for (const bool smooth : {false, true}) {
    car.scene.smooth = smooth;
    const Navigation found = navigate(car.scene, car.recording);
    ASSERT_EQ(found.status, Status::recovered) << found.why;
    ASSERT_EQ(found.lost.size(), 1U);
    EXPECT_EQ(found.lost[0].from, 0);
    EXPECT_LT(found.lost[0].to, 15);
    EXPECT_EQ(found.lost[0].restarted, "position");
    for (const Solution& s : found.solutions) {
      EXPECT_EQ(s.lost, s.time < found.lost[0].to) << s.time;
      EXPECT_TRUE(s.time <= found.lost[0].to || car.in_sigmas(s) < kFar) << s.time;
    }
  }
  car.scene.recovery = false;
  const Navigation kept = navigate(car.scene, car.recording);
  EXPECT_EQ(kept.status, Status::lost);
  EXPECT_FALSE(kept.usable());
  EXPECT_EQ(kept.lost.back().to, 100);
}

// Fixes that are wild each for itself are no reason to leave a filter that is right.
TEST(Lost, OutliersThatDoNotAgreeAreNoLoss) {
  Car car;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 50);
  for (std::size_t k = 1; k < car.recording.fixes[0].size(); ++k)
    if (k % 10 < 3) car.recording.fixes[0][k].value += Vector3d(normal(random), normal(random), normal(random));
  const Navigation found = navigate(car.scene, car.recording);
  EXPECT_EQ(found.status, Status::navigated) << found.why;
  for (const Solution& s : found.solutions) EXPECT_LT(car.in_sigmas(s), kFar) << s.time;
}

TEST(Lost, WhatIsWrongIsNamed) {
  const auto first = [](const Car& car, Suspect::Kind kind) {
    const Navigation found = navigate(car.scene, car.recording);
    EXPECT_EQ(found.status, Status::lost) << found.why;
    const std::vector<Suspect> list = suspects(car.scene, car.recording);
    EXPECT_FALSE(list.empty());
    if (list.empty()) return Suspect{};
    EXPECT_EQ(list[0].kind, kind) << static_cast<int>(list[0].kind) << " " << list[0].value;
    EXPECT_GT(list[0].explained, 0.8);
    return list[0];
  };
  Car late;
  for (auto& fixes : late.recording.fixes)
    for (Fix& fix : fixes) fix.stamp += 18'000'000'000;
  EXPECT_EQ(first(late, Suspect::Kind::clock).value, -18);

  Car arm;
  for (Aid& aid : arm.scene.aids) aid.lever_arm = {2, 0, -1};
  arm.scene.aids[0].sigma.setConstant(0.01);
  arm.scene.aids[1].sigma.setConstant(0.01);
  arm.measure();
  for (Aid& aid : arm.scene.aids) aid.lever_arm.setZero();
  const Vector3d found = first(arm, Suspect::Kind::lever_arm).lever_arm;
  EXPECT_NEAR(found.x(), 2, 0.1);
  EXPECT_NEAR(found.y(), 0, 0.1);

  Car degrees;
  for (auto& increment : degrees.recording.imu.increments) earth::vector(increment.angle) /= kDegree;
  EXPECT_NEAR(first(degrees, Suspect::Kind::unit).value, kDegree, 1e-12);

  Car turned;
  const Matrix3d swap = (Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();  // its own inverse
  for (auto& increment : turned.recording.imu.increments) {
    increment.angle = earth::array(swap * earth::vector(increment.angle));
    increment.velocity = earth::array(swap * earth::vector(increment.velocity));
  }
  EXPECT_EQ(first(turned, Suspect::Kind::axes).axes, "y, x, -z");
}

// The motion over a gap is not known, and the sigmas say so: of a car that turns, and of one that runs straight.
TEST(Lost, SigmasGrowOverAGapAsTheMotionDoes) {
  Car car;
  car.scene.aids[0].outages = car.scene.aids[1].outages = {{39.9, 50.1}};
  car.measure();
  ImuSamples samples;
  samples.gyro = samples.accelerometer = SampleKind::increment;
  for (std::size_t k = 0; k < car.recording.imu.increments.size(); ++k) {
    const double t = static_cast<double>(k + 1) / kRate;
    if (t > 40 && t <= 50) continue;
    samples.stamps.push_back(car.recording.imu.stamps[k + 1]);
    samples.values.push_back(car.recording.imu.increments[k]);
  }
  car.recording.imu = imu_log(samples);
  ASSERT_EQ(car.recording.imu.gaps, 1);
  const Navigation found = navigate(car.scene, car.recording);
  ASSERT_EQ(found.status, Status::navigated) << found.why;
  for (const Solution& s : found.solutions) EXPECT_LT(car.in_sigmas(s), kFar) << s.time;
  const Solution& end = found.solutions[50];
  EXPECT_GT(end.position_sigma.head<2>().norm(), 10);  // 2 m/s^2 for ten seconds
  EXPECT_LT(end.position_sigma.head<2>().norm(), 300);
}

// Of 0.4 s at 15 m/s in turns: the first estimate is off by what the turns do in it.
TEST(Lost, ALongDelayIsFoundWithinItsSigma) {
  Car car;
  for (auto& fixes : car.recording.fixes)
    for (Fix& fix : fixes) fix.stamp += 400'000'000;
  for (Aid& aid : car.scene.aids) aid.time_tag_sigma = 0.3;
  const Navigation found = navigate(car.scene, car.recording);
  ASSERT_EQ(found.status, Status::navigated) << found.why;
  const auto tags =
      std::ranges::count_if(found.model.terms, [](const ErrorTerm& t) { return t.effect == Effect::time_tag; });
  EXPECT_EQ(tags, 1) << "one receiver has one clock";
  EXPECT_NEAR(found.solutions.back().terms.back(), -0.4, kFar * found.solutions.back().term_sigmas.back());
  EXPECT_LT(found.solutions.back().term_sigmas.back(), 0.02);
}

TEST(Lost, RobustWeightsAreAsStated) {
  const Robust huber{Robust::Kind::huber, 1.5}, student{Robust::Kind::student, 4};
  EXPECT_EQ(Robust{}.weight(3, 100), 1);
  EXPECT_EQ(huber.weight(3, 3), 1);
  EXPECT_DOUBLE_EQ(huber.weight(3, 300), 0.15);
  EXPECT_DOUBLE_EQ(student.weight(3, 10), 0.5);
  // An outlier that no gate refuses moves the solution after it by less, and its weight is the one of its NIS.
  Car car;
  car.scene.at = {50.01};
  car.scene.filter.gate_false_alarm = 0;
  const auto place = [&](const Robust& robust, bool outlier) -> Vector3d {
    Recording recording = car.recording;
    if (outlier) recording.fixes[0][100].value *= 1 + 3 / 6.4e6;  // 3 m up
    car.scene.filter.robust = robust;
    const Navigation found = navigate(car.scene, recording);
    for (const InnovationAt& at : found.innovations)
      EXPECT_EQ(at.innovation.weight, robust.weight(at.innovation.rows, at.innovation.nis));
    return std::ranges::find_if(found.solutions, [](const Solution& s) { return s.time > 50.005; })->state.p_eb_e;
  };
  const double plain = (place({}, true) - place({}, false)).norm();
  for (const Robust& robust : {huber, student})
    EXPECT_LT((place(robust, true) - place(robust, false)).norm(), 0.5 * plain);
}

// Errors of a receiver that smooths, told as large white ones: residuals that agree from fix to fix; and white ones
// that are told five times too large or too small.
TEST(Lost, InnovationsSayWhichSigmaIsWrong) {
  Car slow;
  for (Aid& aid : slow.scene.aids) aid.correlated_sigma.setConstant(aid.kind == Aid::Kind::position ? 0.5 : 0);
  slow.scene.aids[0].correlation_time = 20;
  slow.scene.aids[0].sigma.setConstant(0.01);
  slow.measure();
  slow.scene.aids[0].correlated_sigma.setZero();
  slow.scene.aids[0].sigma.setConstant(5);
  slow.scene.aids[1].used = false;
  slow.scene.alignment.velocity_sigma = Vector3d::Constant(0.1);
  const auto verdicts = innovation_verdicts(navigate(slow.scene, slow.recording));
  ASSERT_EQ(verdicts.size(), 1U);
  ASSERT_TRUE(verdicts[0].correlated) << verdicts[0].correlation;
  EXPECT_LT(verdicts[0].correlated->white, verdicts[0].correlated->sigma);

  Car white;
  EXPECT_TRUE(innovation_verdicts(navigate(white.scene, white.recording)).empty());
  for (Aid& aid : white.scene.aids) aid.sigma *= 5;
  const auto large = innovation_verdicts(navigate(white.scene, white.recording));
  ASSERT_EQ(large.size(), 2U);
  EXPECT_FALSE(large[0].correlated || large[1].correlated);
  // Of 1200 residuals the likeliest factor is right to a few percent; steps of the root of 2 are asked for.
  const NoiseFactors factors = noise_factors(white.scene, white.recording);
  EXPECT_GT(factors.aids, 0.2 / 1.5);
  EXPECT_LT(factors.aids, 0.2 * 1.5);
  EXPECT_GT(factors.aids_gain, factors.imu_gain);
}

// A reduced lost_study; its figures of 100 runs are in docs/lost-and-found.md.
TEST(Lost, NeverUnsaidAndFoundAgain) {
  for (const lost::Drive& d : {lost::kCar, lost::kDrone}) {
    for (const auto& c : {lost::Case{.drive = d, .outage_from = 40, .outage = 60, .after = 50, .told = 0.1, .runs = 6},
                          lost::Case{.drive = d, .after = 60, .start_error = 1000, .runs = 6}}) {
      for (const lost::Run& run : lost::drive(c)) {
        EXPECT_LT(run.unsaid_at, 0) << d.name;
        EXPECT_LE(run.found_after, 30) << d.name << " " << run.found.why;
      }
    }
  }
}

}  // namespace
}  // namespace gyrobudget::navigation
