// SPDX-License-Identifier: MIT
// The offline run against trajectories whose truth is known.
#include "gyrobudget/estimation/navigation/navigate.h"

#include "gyrobudget/noise/imu.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <utility>

namespace gyrobudget::navigation {
namespace {

using earth::kDegree;
using earth::vector;
using Eigen::Vector3d;

constexpr double kInterval = 0.01;                          // s
constexpr std::int64_t kEpoch = 1'700'000'000'000'000'000;  // clocks of logs start anywhere

std::int64_t stamp(double t) { return kEpoch + std::llround(t * 1e9); }

// An ideal log of a trajectory, on a clock of its own.
Recording record(const earth::Trajectory& truth, double interval = kInterval) {
  Recording recording;
  recording.origin = kEpoch;
  recording.imu.increments = truth.increments(interval);
  recording.imu.typical_interval = interval;
  for (std::size_t k = 0; k <= recording.imu.increments.size(); ++k)
    recording.imu.stamps.push_back(stamp(static_cast<double>(k) * interval));
  recording.imu.bridged.assign(recording.imu.increments.size(), false);
  return recording;
}

Fix fix_of(Aid::Kind kind, const earth::TrajectoryPoint& at, double stamped) {
  const earth::Geodetic place = earth::to_geodetic(at.pose.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  Fix fix;
  fix.stamp = stamp(stamped);
  if (kind == Aid::Kind::position) fix.value = at.pose.p_eb_e;
  if (kind == Aid::Kind::velocity) fix.value = C_en.transpose() * at.pose.v_eb_e;
  if (kind == Aid::Kind::height) fix.value[0] = place.height;
  fix.q_nb = Eigen::Quaterniond(C_en).conjugate() * at.pose.q_eb;
  return fix;
}

// Exact fixes at these times; their stamps are late by `late`.
std::vector<Fix> fixes(Aid::Kind kind, const earth::Trajectory& truth, double first, double interval, double late = 0) {
  std::vector<Fix> list;
  for (double t = first; t <= truth.duration(); t += interval) list.push_back(fix_of(kind, truth.at(t), t + late));
  return list;
}

Aid aid(Aid::Kind kind, double sigma) {
  Aid a;
  a.name = std::string("test.") + std::string(name(kind));
  a.kind = kind;
  a.sigma.setConstant(sigma);
  return a;
}

// 30 s of S-turns at 300 m/s.
earth::Trajectory flight() {
  return earth::cruise({.speed = 300, .turn_acceleration = 5, .turn_period = 20, .duration = 30});
}

// Starts on the truth, nearly sure of it.
Scenario scene_on(const earth::Trajectory& truth) {
  Scenario scene;
  const auto start = truth.at(0);
  const earth::Geodetic place = earth::to_geodetic(start.pose.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  scene.alignment.position = place;
  scene.alignment.velocity = Vector3d(C_en.transpose() * start.pose.v_eb_e);
  scene.alignment.attitude = earth::to_euler(Eigen::Quaterniond(C_en).conjugate() * start.pose.q_eb);
  scene.alignment.position_sigma = Vector3d::Constant(0.1);
  scene.alignment.velocity_sigma = Vector3d::Constant(0.01);
  scene.alignment.level_sigma = scene.alignment.heading_sigma = 1e-4;
  return scene;
}

double largest_residual(const navigation::Navigation& run) {
  double largest = 0;
  for (const auto& at : run.innovations)
    largest = std::max(largest, at.innovation.residual.head(at.innovation.rows).cwiseAbs().maxCoeff());
  return largest;
}

// A push that no estimate survives: numbers that overflow are an answer, and solutions end there.
TEST(NavigationRun, ASolutionThatLeavesAllNumbersHasFailed) {
  const earth::Trajectory truth = flight();
  for (const bool smooth : {false, true}) {
    Scenario scene = scene_on(truth);
    scene.smooth = smooth;
    Recording recording = record(truth);
    recording.imu.increments[1500].velocity[0] = 1e300;
    const auto found = navigate(scene, recording);
    EXPECT_EQ(found.status, Navigation::Status::failed);
    EXPECT_EQ(found.why.rfind("at 15", 0), 0U) << found.why;
    ASSERT_FALSE(found.solutions.empty());
    EXPECT_LE(found.solutions.back().time, 15.1);
  }
}

// An increment that is no number is a mistake of who made the recording, imu_log() leaves none: it is no answer.
TEST(NavigationRun, AMistakeOfTheCallerIsNoAnswer) {
  const earth::Trajectory truth = flight();
  Recording recording = record(truth);
  recording.imu.increments[1500].angle[2] = std::numeric_limits<double>::quiet_NaN();
  try {
    (void)navigate(scene_on(truth), recording);
    FAIL() << "it went through";
  } catch (const earth::OutsideDomain&) {
    FAIL() << "of another kind";
  } catch (const Diverged&) {
    FAIL() << "of another kind";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("not finite"), std::string::npos) << error.what();
  }
}

TEST(NavigationRun, ErrorsHaveTheNamesOfWhatIsWrong) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  Recording recording = record(truth);
  scene.solution_interval = 0;
  EXPECT_THROW((void)navigate(scene, recording), SetupError);
  scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 1)};
  EXPECT_THROW((void)navigate(scene, recording), RecordingError) << "no list of its fixes";
  recording.fixes = {fixes(Aid::Kind::position, truth, 1, 1)};
  std::swap(recording.fixes[0][0], recording.fixes[0][1]);
  EXPECT_THROW((void)navigate(scene, recording), RecordingError) << "times do not ascend";
  scene.aids[0].sigma.setZero();
  EXPECT_THROW((void)navigate(scene, recording), SetupError);
}

TEST(NavigationRun, FixesBetweenSamplesMeetTheTruthThere) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 1), aid(Aid::Kind::velocity, 0.1), aid(Aid::Kind::attitude, 1e-3),
                aid(Aid::Kind::height, 1)};
  Recording recording = record(truth);
  for (const Aid& a : scene.aids) recording.fixes.push_back(fixes(a.kind, truth, 0.1234567, 0.7));
  const auto found = navigate(scene, recording);
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  // 300 m/s would make 1 m of 3.5 ms; the split's own error is that of a step of 10 ms.
  constexpr double kSplit = 1e-3;
  EXPECT_LT(largest_residual(found), kSplit);
  ASSERT_EQ(found.aids.size(), 4U);
  for (const AidSummary& a : found.aids) {
    EXPECT_EQ(a.used, 43);
    EXPECT_EQ(a.gated + a.left_out + a.not_finite, 0);
  }
  EXPECT_EQ(found.steps, 3000 + 43);
}

// A sigma that each fix has of its own stands in for the aid's, in the start too; the aid's factor is of both.
TEST(NavigationRun, AFixMayHaveASigmaOfItsOwn) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 0.5), aid(Aid::Kind::velocity, 0.05)};
  scene.alignment.position = FromAid{0};
  scene.alignment.velocity = FromAid{1};
  scene.alignment.position_sigma.reset();
  scene.alignment.velocity_sigma.reset();
  Recording recording = record(truth);
  recording.fixes = {fixes(Aid::Kind::position, truth, 0, 1), fixes(Aid::Kind::velocity, truth, 0, 1)};
  const Navigation by_aid = navigate(scene, recording);
  for (std::size_t i = 0; i < 2; ++i) {
    for (Fix& fix : recording.fixes[i]) fix.sigma = scene.aids[i].sigma;
    scene.aids[i].sigma *= 1000;
  }
  const auto expect_as_by_aid = [&](const Navigation& found) {
    ASSERT_EQ(found.solutions.size(), by_aid.solutions.size());
    for (std::size_t k = 0; k < found.solutions.size(); ++k) {
      EXPECT_EQ(found.solutions[k].position_sigma, by_aid.solutions[k].position_sigma) << k;
      EXPECT_EQ(found.solutions[k].state.p_eb_e, by_aid.solutions[k].state.p_eb_e) << k;
    }
  };
  expect_as_by_aid(navigate(scene, recording));
  constexpr double kFactor = 4;  // a power of two: no rounding
  for (std::size_t i = 0; i < 2; ++i) {
    for (Fix& fix : recording.fixes[i]) *fix.sigma /= kFactor;
    scene.aids[i].sigma_factor = kFactor;
  }
  expect_as_by_aid(navigate(scene, recording));
  recording.fixes[0][3].sigma = Vector3d(1, 0, 1);
  EXPECT_THROW((void)navigate(scene, recording), RecordingError);
}

TEST(NavigationRun, ATimeTagMovesFixesToTheirInstant) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 1)};
  Recording recording = record(truth);
  constexpr double kLate = 0.02;
  recording.fixes = {fixes(Aid::Kind::position, truth, 1, 1, kLate)};
  EXPECT_GT(largest_residual(navigate(scene, recording)), 0.5 * 300 * kLate);
  scene.aids[0].time_tag = -kLate;
  EXPECT_LT(largest_residual(navigate(scene, recording)), 1e-3);
}

// In an outage a smoother knows both ends: in its middle the filter is worse, at the end of the run they are one.
TEST(NavigationRun, SmoothingBridgesAnOutage) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.sensor.gyro.white = 1e-4;
  scene.sensor.accelerometer.emplace();
  scene.sensor.accelerometer->turn_on_bias = 0.02;
  scene.aids = {aid(Aid::Kind::position, 0.1)};
  scene.aids[0].outages = {{5.5, 25.5}};
  Recording recording = record(truth);
  for (auto& increment : recording.imu.increments) increment.velocity[0] += 0.02 * kInterval;
  recording.fixes = {fixes(Aid::Kind::position, truth, 1, 1)};
  const auto filtered = navigate(scene, recording);
  scene.smooth = true;
  const auto smoothed = navigate(scene, recording);
  ASSERT_EQ(smoothed.solutions.size(), filtered.solutions.size());
  const auto error = [&](const navigation::Navigation& r, std::size_t i) {
    return (truth.at(r.solutions[i].time).pose.p_eb_e - r.solutions[i].state.p_eb_e).norm();
  };
  for (std::size_t i = 0; i < filtered.solutions.size(); ++i) {
    EXPECT_EQ(smoothed.solutions[i].time, filtered.solutions[i].time);
    EXPECT_LE(smoothed.solutions[i].position_sigma.norm(), (1 + 1e-6) * filtered.solutions[i].position_sigma.norm());
    EXPECT_LT(error(smoothed, i), 3 * smoothed.solutions[i].position_sigma.norm());
  }
  const std::size_t middle = 25;  // of a solution a second
  EXPECT_LT(error(smoothed, middle), 0.3 * error(filtered, middle));
  EXPECT_LT(smoothed.solutions[middle].position_sigma.norm(), 0.3 * filtered.solutions[middle].position_sigma.norm());
  EXPECT_NEAR(error(smoothed, 30), error(filtered, 30), 1e-9);
}

TEST(NavigationRun, AnUnknownTimeTagIsFound) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 0.1)};
  scene.aids[0].time_tag_sigma = 0.05;
  Recording recording = record(truth);
  constexpr double kLate = 0.02;
  recording.fixes = {fixes(Aid::Kind::position, truth, 1, 1, kLate)};
  const auto found = navigate(scene, recording);
  ASSERT_EQ(found.model.terms.size(), 1U);
  EXPECT_EQ(found.model.terms[0].effect, Effect::time_tag);
  // A fix that is stamped late was measured earlier than stated.
  EXPECT_NEAR(found.solutions.back().terms[0], -kLate, 5 * found.solutions.back().term_sigmas[0] + 1e-4);
  EXPECT_LT(found.solutions.back().term_sigmas[0], 1e-3);
}

// Of a tag that the fixes hardly tell the estimate is (1 - P/P0) of what they say alone: it is not run again about it.
TEST(NavigationRun, ATimeTagThatIsHardlySeenStaysNearWhatWasTold) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  constexpr double kLate = 0.05, kTold = 0.01;
  scene.aids = {aid(Aid::Kind::position, 40)};
  scene.aids[0].time_tag_sigma = kTold;
  Recording recording = record(truth);
  recording.fixes = {fixes(Aid::Kind::position, truth, 1, 1, kLate)};
  const Solution last = navigate(scene, recording).solutions.back();
  ASSERT_GT(last.term_sigmas[0], 0.5 * kTold);
  const double learnt = 1 - std::pow(last.term_sigmas[0] / kTold, 2);
  // The fixes of a flight of 300 m/s in turns say 50 ms, and what the start knows of the place another tenth of that.
  EXPECT_NEAR(last.terms[0], -learnt * kLate, 0.1 * learnt * kLate);
}

TEST(NavigationRun, OutagesValidityAndTheGateAreCounted) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 1)};
  scene.aids[0].outages = {{9.5, 12.5}};
  scene.aids[0].valid.to = 25.5;
  Recording recording = record(truth);
  recording.fixes = {fixes(Aid::Kind::position, truth, -0.0 + 1, 1)};
  recording.fixes[0][4].value.x() += 1000;
  recording.fixes[0][6].value.y() = std::numeric_limits<double>::quiet_NaN();
  const auto found = navigate(scene, recording);
  const AidSummary& a = found.aids.at(0);
  EXPECT_EQ(a.left_out, 3 + 5);  // 10, 11, 12; 26 to 30
  EXPECT_EQ(a.gated, 1);
  EXPECT_EQ(a.not_finite, 1);
  EXPECT_EQ(a.used, 30 - 8 - 2);
  EXPECT_EQ(found.innovations.size(), 22U);
}

TEST(NavigationRun, TheReferenceTellsTheErrorAtEverySolution) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.solution_interval = 0.37;
  scene.at = {3.14159};
  scene.aids = {aid(Aid::Kind::position, 1), aid(Aid::Kind::velocity, 1), aid(Aid::Kind::attitude, 1)};
  scene.reference = {0, 1, 2};
  Recording recording = record(truth);
  for (Aid& a : scene.aids) {
    a.used = false;
    recording.fixes.push_back(fixes(a.kind, truth, 0, 0.1));
  }
  const auto found = navigate(scene, recording);
  ASSERT_TRUE(found.reference);
  EXPECT_EQ(found.innovations.size(), 0U);
  EXPECT_EQ(found.solutions.size(), 82U + 1U);
  EXPECT_EQ(found.reference->dof, 9);
  // The strapdown's own errors over 30 s, and a cubic's over 0.1 s of a 20 s turn (velocity: straight, a third of
  // 5 m/s^2 (2 pi/20 s)^2 (0.1 s)^2/8).
  EXPECT_LT(found.reference->position_rms, 1e-3);
  EXPECT_LT(found.reference->velocity_rms, 3e-3);
  EXPECT_LT(found.reference->attitude_rms, 1e-3);
  // An error that is put in comes out with its sign: solution less reference.
  for (Fix& fix : recording.fixes[0]) {
    const earth::Geodetic at = earth::to_geodetic(fix.value);
    fix.value += earth::C_e_enu(at.latitude, at.longitude) * Vector3d(1, -2, 3);
  }
  const auto shifted = navigate(scene, recording);
  EXPECT_LT((shifted.reference->errors.back().position - Vector3d(-1, 2, -3)).norm(), 5e-3);
}

TEST(NavigationRun, AnAidMayGiveTheStart) {
  const earth::Trajectory truth = flight();
  Scenario scene;
  scene.aids = {aid(Aid::Kind::position, 1), aid(Aid::Kind::velocity, 0.1), aid(Aid::Kind::attitude, 1e-3)};
  scene.alignment.start = 4.2;
  scene.alignment.position = FromAid{0};
  scene.alignment.velocity = FromAid{1};
  scene.alignment.attitude = FromAid{2};
  Recording recording = record(truth);
  for (const Aid& a : scene.aids) recording.fixes.push_back(fixes(a.kind, truth, 0.25, 0.5));
  const auto found = navigate(scene, recording);
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  EXPECT_NEAR(found.alignment.to, 4.25, 1e-9);
  const auto at = truth.at(found.solutions.back().time);
  EXPECT_LT((found.solutions.back().state.p_eb_e - at.pose.p_eb_e).norm(), 0.01);
  scene.alignment.start = 29.9;
  EXPECT_EQ(navigate(scene, recording).status, navigation::Navigation::Status::no_start);
}

// A body at rest whose sensors have constant errors.
Recording pad(const earth::Trajectory& truth, const Vector3d& gyro_bias, const Vector3d& accelerometer_bias) {
  Recording recording = record(truth);
  for (auto& i : recording.imu.increments) {
    vector(i.angle) += gyro_bias * kInterval;
    vector(i.velocity) += accelerometer_bias * kInterval;
  }
  return recording;
}

Scenario pad_scene(double gyro_sigma, double accelerometer_sigma) {
  Scenario scene;
  scene.alignment.position = earth::alcantara().position;
  scene.alignment.position_sigma = scene.alignment.velocity_sigma = Vector3d::Constant(1e-6);
  scene.alignment.attitude = SelfAlignment{.duration = 60};
  scene.sensor.gyro.turn_on_bias = noise::PerAxis(gyro_sigma);
  scene.sensor.accelerometer.emplace();
  scene.sensor.accelerometer->turn_on_bias = noise::PerAxis(accelerometer_sigma);
  return scene;
}

TEST(NavigationRun, WhatLevelledTheBodyDoesNotMoveItAfterwards) {
  // 1 mg of accelerometer: levelled by itself it stays where it is; a sigma that took tilt and bias for independent
  // would claim b sqrt(2) T^2/2 = 48 m after 83 s.
  constexpr double kMilliG = 9.80665e-3, kTime = 83;
  const earth::Trajectory truth = earth::stand({.duration = 60 + kTime});
  Scenario scene = pad_scene(1e-9, kMilliG);
  const auto found = navigate(scene, pad(truth, Vector3d::Zero(), {kMilliG, -kMilliG, 0}));
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  const Solution& last = found.solutions.back();
  EXPECT_NEAR(last.time, 60 + kTime, 1e-6);
  const auto frame = earth::LocalFrame::east_north_up(earth::alcantara().position);
  const Vector3d moved = frame.from_ecef(last.state.p_eb_e);
  EXPECT_LT(moved.head<2>().norm(), 0.5);
  EXPECT_LT(last.position_sigma.head<2>().norm(), 2);
  // It is off level by b/g, and says so.
  EXPECT_NEAR(last.attitude_sigma[0], 1e-3, 1e-4);
}

TEST(NavigationRun, HeadingAtRestCostsTheGyrosBias) {
  constexpr double kDegreePerHour = kDegree / 3600;
  const double bias = 0.01 * kDegreePerHour;
  const earth::Trajectory truth = earth::stand({.duration = 70});
  const Scenario scene = pad_scene(bias, 1e-9);
  const auto found = navigate(scene, pad(truth, {0, bias, 0}, Vector3d::Zero()));  // the body's y points east
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  const double expected = bias / (earth::wgs84::kEarthRate * std::cos(earth::alcantara().position.latitude));
  const auto& state = found.alignment.state;
  const earth::Geodetic at = earth::to_geodetic(state.p_eb_e);
  const earth::Euler euler =
      earth::to_euler(Eigen::Quaterniond(earth::C_e_ned(at.latitude, at.longitude)).conjugate() * state.q_eb);
  EXPECT_NEAR(std::abs(euler.yaw), expected, 0.02 * expected);
  EXPECT_NEAR(found.solutions.front().attitude_sigma[2], expected, 0.02 * expected);
}

// Switched on where the alignment starts, the bias is zero there and walks in its course, to K sqrt(T) at its end. The
// mean, and with it heading and level, is off by K sqrt(T/3).
TEST(NavigationRun, WhatTheBiasWalkedMeanwhileIsHalfKnown) {
  constexpr double kTime = 60, kAfter = 10;
  const double walk = 0.1 * kDegree / 3600 / 60, force_walk = 1e-5;  // 0.1 deg/h/sqrt(h)
  Scenario scene = pad_scene(0, 0);
  scene.sensor.gyro.rate_random_walk = walk;
  const auto turned = navigate(scene, record(earth::stand({.duration = kTime + kAfter})));
  ASSERT_EQ(turned.status, navigation::Navigation::Status::navigated) << turned.why;
  const double rate = earth::wgs84::kEarthRate * std::cos(earth::alcantara().position.latitude);
  const Solution& start = turned.solutions.front();
  constexpr double kExact = 1e-3;
  EXPECT_NEAR(start.attitude_sigma[2] / (walk * std::sqrt(kTime / 3) / rate), 1, kExact);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(start.gyro_bias_sigma[axis], walk * std::sqrt(kTime), 1e-6 * walk);

  // Tilt takes the mean off the horizontal accelerometers. What is left at the end, sqrt(K^2 T/3) by its covariance
  // K^2 T/2 with the mean, moves the body by t^2/2 of it and by K sqrt(t^5/20) of its further walk. Where the two were
  // one number only the latter would be left, 0.35 of it all; where they were none, 2.2 times.
  scene = pad_scene(0, 0);
  scene.sensor.accelerometer->rate_random_walk = force_walk;
  scene.alignment.attitude = SelfAlignment{.duration = kTime, .heading = 0};
  scene.alignment.heading_sigma = 1e-9;
  const auto tilted = navigate(scene, record(earth::stand({.duration = kTime + kAfter})));
  ASSERT_EQ(tilted.status, navigation::Navigation::Status::navigated) << tilted.why;
  const double t = kAfter;
  const double moved = force_walk * std::sqrt(kTime / 3 * std::pow(t, 4) / 4 + std::pow(t, 5) / 20);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(tilted.solutions.front().attitude_sigma[axis] / (force_walk * std::sqrt(kTime / 3) / 9.781), 1, kExact);
    EXPECT_NEAR(tilted.solutions.back().position_sigma[axis] / moved, 1, kExact);
  }
}

// 100 IMUs that wander while they align themselves, tilted and with axes that are not square, and then navigate for a
// minute at rest: position, velocity and attitude together against the covariance that they claim, at the start and at
// the end, are chi-square of 900. False alarm of each limit: 1e-4.
constexpr int kManyRuns = 100;
constexpr double kManyLow = 750.7, kManyHigh = 1066.4;

// NEES in sum over the runs, where the alignment ends and at the end.
std::pair<double, double> nees_of_self_aligned(noise::ErrorModel gyro, noise::ErrorModel accelerometer) {
  constexpr double kAlign = 60, kAfter = 60, dt = 0.1;
  const earth::Trajectory truth =
      earth::stand({.q_nb = earth::from_euler({1, 0.3, -0.2}), .duration = kAlign + kAfter});
  Scenario scene = pad_scene(0, 0);
  scene.sensor.gyro = std::move(gyro);
  scene.sensor.accelerometer = std::move(accelerometer);
  scene.solution_interval = kAfter;
  scene.aids = {aid(Aid::Kind::position, 1), aid(Aid::Kind::velocity, 1), aid(Aid::Kind::attitude, 1)};
  scene.reference = {0, 1, 2};
  Recording ideal = record(truth, dt);
  for (Aid& a : scene.aids) {
    a.used = false;
    ideal.fixes.push_back(fixes(a.kind, truth, 0, 1));
  }
  std::pair<double, double> sum{0, 0};
  for (std::uint64_t i = 0; i < kManyRuns; ++i) {
    noise::Imu imu(scene.sensor, dt, {.seed = 20261122, .run = i});
    Recording recording = ideal;
    for (auto& increment : recording.imu.increments) {
      increment = imu.next(increment);
    }
    const auto found = navigate(scene, recording);
    if (found.status != navigation::Navigation::Status::navigated || found.reference->errors.size() != 2) return {0, 0};
    sum.first += found.reference->errors.front().nees;
    sum.second += found.reference->errors.back().nees;
  }
  return sum;
}

TEST(NavigationRun, ASelfAlignedStartIsConsistentWithSensorsThatWander) {
  constexpr double kLow = 215.4, kHigh = 398.0;  // chi-square of 300 at 1e-4 and 1 - 1e-4
  const auto walking = [](double walk) { return noise::ErrorModel{.white = walk, .rate_random_walk = walk}; };
  const auto correlated = [](double sigma) {
    return noise::ErrorModel{.white = sigma / 10, .gauss_markov = {{sigma, 30}}};
  };
  const auto all = [](double size) {
    return noise::ErrorModel{.white = size / 10,
                             .rate_random_walk = size / 10,
                             .gauss_markov = {{size, 30}},
                             .turn_on_bias = size,
                             .misalignment = noise::PerAxis(3e-3),
                             .powered_on_before = 20.0};
  };
  for (const auto& [gyro, accelerometer] :
       {std::pair{walking(2e-8), walking(1e-4)}, {correlated(2e-7), correlated(1e-3)}, {all(2e-7), all(1e-3)}}) {
    const auto [at_start, at_end] = nees_of_self_aligned(gyro, accelerometer);
    // Where it starts there is nothing wrong but attitude.
    EXPECT_GT(at_start, kLow);
    EXPECT_LT(at_start, kHigh);
    EXPECT_GT(at_end, kManyLow);
    EXPECT_LT(at_end, kManyHigh);
  }
}

// --- A start from GNSS ---------------------------------------------------------------------------------------------

// What an antenna at the aid's lever arm has.
Fix antenna_fix(const Aid& aid, const earth::TrajectoryPoint& at, double stamped) {
  Fix fix = fix_of(aid.kind, at, stamped);
  const earth::Geodetic place = earth::to_geodetic(at.pose.p_eb_e);
  const Vector3d w_eb_b = at.sensed.w_ib_b - at.pose.q_eb.conjugate() * Vector3d(0, 0, earth::wgs84::kEarthRate);
  if (aid.kind == Aid::Kind::position) fix.value += at.pose.q_eb * aid.lever_arm;
  if (aid.kind == Aid::Kind::velocity)
    fix.value +=
        earth::C_e_ned(place.latitude, place.longitude).transpose() * (at.pose.q_eb * w_eb_b.cross(aid.lever_arm));
  return fix;
}

std::vector<Fix> antenna_fixes(const Aid& aid, const earth::Trajectory& truth, double first, double interval) {
  std::vector<Fix> list;
  for (double t = first; t <= truth.duration(); t += interval) list.push_back(antenna_fix(aid, truth.at(t), t));
  return list;
}

// Starts at 0.5 s with a GNSS receiver's first fix, attitude given.
Scenario from_gnss(const earth::Trajectory& truth) {
  Scenario scene;
  const auto start = truth.at(0.5);
  const earth::Geodetic place = earth::to_geodetic(start.pose.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  scene.alignment.position = FromAid{0};
  scene.alignment.velocity = FromAid{1};
  scene.alignment.attitude = earth::to_euler(Eigen::Quaterniond(C_en).conjugate() * start.pose.q_eb);
  scene.aids = {aid(Aid::Kind::position, 0.05), aid(Aid::Kind::velocity, 0.02)};
  return scene;
}

TEST(NavigationRun, TheLeverArmIsTakenOffTheStart) {
  const earth::Trajectory truth = flight();
  Scenario scene = from_gnss(truth);
  scene.alignment.level_sigma = 1e-3;
  scene.alignment.heading_sigma = 0.02;
  scene.aids[0].lever_arm = scene.aids[1].lever_arm = {3, -1, 2};
  Recording recording = record(truth);
  for (const Aid& a : scene.aids) recording.fixes.push_back(antenna_fixes(a, truth, 0.5, 1));
  const auto found = navigate(scene, recording);
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  const auto at = truth.at(0.5);
  constexpr double kFrame = 2e-6;  // m: the attitude is given in axes of the antenna's place
  EXPECT_LT((found.alignment.state.p_eb_e - at.pose.p_eb_e).norm(), kFrame);
  EXPECT_LT((found.alignment.state.v_eb_e - at.pose.v_eb_e).norm(), 1e-3);
  EXPECT_LT(largest_residual(found), 2e-3);
  // A heading that is off takes the lever arm off in a wrong direction: dp = [l x] psi.
  const CoreMatrix& P = found.alignment.covariance;
  const Eigen::Matrix3d psi = P.block<3, 3>(kAttitude, kAttitude);
  const Eigen::Matrix3d arm = earth::skew(at.pose.q_eb * scene.aids[0].lever_arm);
  EXPECT_LT((P.block<3, 3>(kPosition, kAttitude) - arm * psi).norm(), 1e-6 * (arm * psi).norm());
  const Eigen::Matrix3d expected = arm * psi * arm.transpose() + 0.05 * 0.05 * Eigen::Matrix3d::Identity();
  EXPECT_LT((P.block<3, 3>(kPosition, kPosition) - expected).norm(), 1e-6 * expected.norm());
}

// Neither the first fix nor all the later ones tell a constant error of the aid from one of position.
TEST(NavigationRun, AnAidsBiasInTheStartStaysThere) {
  constexpr double kBias = 3;
  const earth::Trajectory truth = flight();
  Scenario scene = from_gnss(truth);
  scene.alignment.level_sigma = scene.alignment.heading_sigma = 1e-6;
  scene.aids[0].bias_sigma.setConstant(kBias);
  Recording recording = record(truth);
  for (const Aid& a : scene.aids) recording.fixes.push_back(antenna_fixes(a, truth, 0.5, 1));
  const auto found = navigate(scene, recording);
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  const double first = std::hypot(kBias, scene.aids[0].sigma[0]);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(found.solutions.front().position_sigma[axis] / first, 1, 1e-9);
    EXPECT_NEAR(found.solutions.back().position_sigma[axis] / kBias, 1, 5e-3);  // for errors apart: 1/sqrt(2)
  }
  // Where the scene says how wrong the start is, it is the scene's.
  scene.alignment.position_sigma = Vector3d::Constant(kBias);
  EXPECT_NEAR(navigate(scene, recording).solutions.back().position_sigma[0] / kBias, std::sqrt(0.5), 0.01);
}

// Between two fixes the start is made of both.
TEST(NavigationRun, AFixIsUsedOnce) {
  const earth::Trajectory truth = flight();
  Scenario scene = from_gnss(truth);
  scene.alignment.level_sigma = scene.alignment.heading_sigma = 1e-3;
  Recording recording = record(truth);
  recording.fixes = {antenna_fixes(scene.aids[0], truth, 0.3, 1), antenna_fixes(scene.aids[1], truth, 0.5, 1)};
  const auto found = navigate(scene, recording);
  ASSERT_TRUE(found.usable()) << found.why;  // the velocity between two fixes is not on the straight line
  EXPECT_NEAR(found.alignment.to, 1.3, 1e-9);
  EXPECT_EQ(found.aids.at(0).left_out, 2);  // 0.3, 1.3
  EXPECT_EQ(found.aids.at(1).left_out, 2);  // 0.5, and 1.5 with it
}

TEST(NavigationRun, AStartFromGnssIsConsistent) {
  const earth::Trajectory truth = flight();
  Scenario scene = from_gnss(truth);
  scene.sensor.gyro.white = 1e-5;
  scene.sensor.accelerometer.emplace();
  scene.sensor.accelerometer->white = 1e-3;
  scene.alignment.level_sigma = 0.002;
  scene.alignment.heading_sigma = 0.03;
  scene.aids[0].lever_arm = scene.aids[1].lever_arm = {3, -1, 2};
  scene.aids[0].bias_sigma.setConstant(0.3);
  scene.aids[0].correlated_sigma.setConstant(0.2);
  scene.aids[0].correlation_time = 10;
  scene.solution_interval = 29;
  scene.reference = {2, 3, 4};
  for (const auto kind : {Aid::Kind::position, Aid::Kind::velocity, Aid::Kind::attitude}) {
    scene.aids.push_back(aid(kind, 1));
    scene.aids.back().used = false;
  }
  Recording ideal = record(truth);
  for (const Aid& a : scene.aids) ideal.fixes.push_back(antenna_fixes(a, truth, 0.5, 1));
  std::mt19937_64 engine(20261122);
  std::normal_distribution<double> unit;
  const auto draw = [&](double sigma) {
    return Vector3d(sigma * unit(engine), sigma * unit(engine), sigma * unit(engine));
  };
  const double phi = std::exp(-1 / scene.aids[0].correlation_time);
  double at_start = 0, at_end = 0;
  for (int i = 0; i < kManyRuns; ++i) {
    Recording recording = ideal;
    for (auto& increment : recording.imu.increments) {
      vector(increment.angle) += draw(1e-5 * std::sqrt(kInterval));
      vector(increment.velocity) += draw(1e-3 * std::sqrt(kInterval));
    }
    const Vector3d bias = draw(0.3);
    Vector3d correlated = draw(0.2);
    for (Fix& fix : recording.fixes[0]) {
      const earth::Geodetic at = earth::to_geodetic(fix.value);
      fix.value += earth::C_e_enu(at.latitude, at.longitude) * (bias + correlated + draw(0.05));
      correlated = phi * correlated + draw(0.2 * std::sqrt(1 - phi * phi));
    }
    for (Fix& fix : recording.fixes[1]) fix.value += draw(0.02);
    Scenario one = scene;
    const auto start = truth.at(0.5);
    const earth::Geodetic place = earth::to_geodetic(start.pose.p_eb_e);
    const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
    const Vector3d psi_n(0.002 * unit(engine), 0.002 * unit(engine), 0.03 * unit(engine));
    one.alignment.attitude =
        earth::to_euler(earth::exp_rotation(psi_n) * (Eigen::Quaterniond(C_en).conjugate() * start.pose.q_eb));
    const auto found = navigate(one, recording);
    ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
    ASSERT_EQ(found.reference->errors.size(), 2U);
    at_start += found.reference->errors.front().nees;
    at_end += found.reference->errors.back().nees;
  }
  EXPECT_GT(at_start, kManyLow);
  EXPECT_LT(at_start, kManyHigh);
  EXPECT_GT(at_end, kManyLow);
  EXPECT_LT(at_end, kManyHigh);
}

// What is known exactly stays so, and never without a number.
TEST(NavigationRun, SigmasOfZeroAreNumbers) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.alignment.position_sigma = scene.alignment.velocity_sigma = Vector3d::Zero();
  scene.alignment.level_sigma = 0;
  const auto found = navigate(scene, record(truth));
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  for (const Solution& s : found.solutions)
    EXPECT_TRUE(s.position_sigma.allFinite() && s.velocity_sigma.allFinite() && s.attitude_sigma.allFinite()) << s.time;
}

TEST(NavigationRun, AMemsIsAskedForItsHeading) {
  constexpr double kDegreePerHour = kDegree / 3600;
  const earth::Trajectory truth = earth::stand({.q_nb = earth::from_euler({1, 0.1, 0}), .duration = 70});
  Scenario scene = pad_scene(100 * kDegreePerHour, 1e-3);
  const Recording recording = pad(truth, Vector3d::Zero(), Vector3d::Zero());
  const auto refused = navigate(scene, recording);
  EXPECT_EQ(refused.status, navigation::Navigation::Status::heading_not_observable);
  EXPECT_FALSE(refused.why.empty());
  scene.alignment.attitude = SelfAlignment{.duration = 60, .heading = 1};
  scene.alignment.heading_sigma = 0.01;
  const auto found = navigate(scene, recording);
  ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
  EXPECT_NEAR(found.solutions.front().attitude_sigma[2], 0.01, 1e-4);
}

TEST(NavigationRun, ABodyThatMovesOrAWrongUnitIsNoAlignment) {
  const earth::Trajectory truth = earth::stand({.duration = 70});
  Recording recording = record(truth);
  for (auto& i : recording.imu.increments) vector(i.velocity) *= 9.780327 / 9.80665;  // another g
  const auto found = navigate(pad_scene(1e-9, 1e-4), recording);
  EXPECT_EQ(found.status, navigation::Navigation::Status::not_at_rest);
}

TEST(NavigationRun, ZeroVelocityHoldsTheBody) {
  const earth::Trajectory truth = earth::stand({.duration = 200});
  Scenario scene = pad_scene(1e-7, 1e-3);
  scene.aids = {aid(Aid::Kind::rest, 0.01)};
  scene.aids[0].valid.to = 150;
  Recording recording = pad(truth, {1e-7, 0, 0}, {1e-3, 5e-4, -1e-3});
  recording.fixes = {{}};
  const auto found = navigate(scene, recording);
  EXPECT_EQ(found.aids.at(0).used, 90);
  EXPECT_LT(found.solutions.back().position_sigma.norm(), 1);
  const double moved = (found.solutions.back().state.p_eb_e - truth.at(200).pose.p_eb_e).norm();
  EXPECT_LT(moved, 3 * found.solutions.back().position_sigma.norm());
}

TEST(NavigationRun, SigmasAreRightOverManyRuns) {
  // 24 runs of 30 s with white noise, drawn biases and starts, and GNSS at 1 Hz; the error at the end against the
  // filter's covariance is chi-square of 9 each. False alarm of the limits: 1e-4 each way.
  constexpr int kRuns = 24;
  constexpr double kLow = 147.0, kHigh = 302.1;  // chi-square of 216 at 1e-4 and 1 - 1e-4
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  const Recording ideal = record(truth);
  scene.sensor.gyro.white = 1e-4;
  scene.sensor.gyro.turn_on_bias = noise::PerAxis(1e-4);
  scene.sensor.accelerometer.emplace();
  scene.sensor.accelerometer->white = 1e-3;
  scene.sensor.accelerometer->turn_on_bias = noise::PerAxis(0.02);
  scene.aids = {aid(Aid::Kind::position, 2), aid(Aid::Kind::velocity, 0.1), aid(Aid::Kind::attitude, 1)};
  scene.aids[2].used = false;
  scene.reference = {0, 1, 2};
  scene.solution_interval = 30;
  std::mt19937_64 engine(20261122);
  std::normal_distribution<double> unit;
  const auto draw = [&](double sigma) {
    return Vector3d(sigma * unit(engine), sigma * unit(engine), sigma * unit(engine));
  };
  double sum = 0, nis = 0;
  for (int i = 0; i < kRuns; ++i) {
    Recording recording = ideal;
    const Vector3d gyro = draw(1e-4), accelerometer = draw(0.02);
    for (auto& increment : recording.imu.increments) {
      vector(increment.angle) += kInterval * gyro + draw(1e-4 * std::sqrt(kInterval));
      vector(increment.velocity) += kInterval * accelerometer + draw(1e-3 * std::sqrt(kInterval));
    }
    Scenario one = scene;
    const auto start = truth.at(0);
    const earth::Geodetic place = earth::to_geodetic(start.pose.p_eb_e);
    const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
    one.alignment.position = earth::to_geodetic(start.pose.p_eb_e + draw(0.1));
    one.alignment.velocity = Vector3d(C_en.transpose() * (start.pose.v_eb_e + draw(0.01)));
    one.alignment.attitude =
        earth::to_euler(Eigen::Quaterniond(C_en).conjugate() * earth::exp_rotation(draw(1e-4)) * start.pose.q_eb);
    for (const Aid& a : one.aids) {
      // Fixes end before the truth's last instant, which the reference keeps exact.
      recording.fixes.push_back(fixes(a.kind, truth, 1, 1));
      if (!a.used) continue;
      for (std::size_t k = 0; k + 1 < recording.fixes.back().size(); ++k)
        recording.fixes.back()[k].value += draw(a.sigma[0]);
    }
    for (Aid& a : one.aids) a.valid.to = 29.5;
    const auto found = navigate(one, recording);
    ASSERT_EQ(found.status, navigation::Navigation::Status::navigated) << found.why;
    ASSERT_EQ(found.reference->errors.size(), 1U);
    sum += found.reference->errors.back().nees;
    nis += found.aids[0].nis_mean / 3;
  }
  EXPECT_GT(sum, kLow);
  EXPECT_LT(sum, kHigh);
  EXPECT_NEAR(nis / kRuns, 1, 0.13);  // 4 sqrt(2/(3 29 24))
}

TEST(NavigationRun, RefusesWhatWouldFillMemory) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.solution_interval = 1e-9;
  EXPECT_THROW((void)navigate(scene, record(truth)), std::invalid_argument);
  scene.solution_interval = 1;
  scene.aids = {aid(Aid::Kind::rest, 1)};
  scene.aids[0].rate = 1e9;
  Recording recording = record(truth);
  recording.fixes.emplace_back();
  EXPECT_THROW((void)navigate(scene, recording), std::invalid_argument);
}

TEST(NavigationRun, RefusesWrongScenes) {
  const earth::Trajectory truth = flight();
  const Recording recording = record(truth);
  Scenario scene = scene_on(truth);
  scene.solution_interval = 0;
  EXPECT_THROW((void)navigate(scene, recording), std::invalid_argument);
  scene = scene_on(truth);
  scene.aids = {aid(Aid::Kind::position, 1)};
  EXPECT_THROW((void)navigate(scene, recording), std::invalid_argument);  // no list of fixes
  scene.aids[0].sigma[1] = 0;
  Recording with = recording;
  with.fixes = {{}};
  EXPECT_THROW((void)navigate(scene, with), std::invalid_argument);
  scene.aids[0].sigma[1] = 1;
  scene.alignment.velocity = FromAid{0};
  EXPECT_THROW((void)navigate(scene, with), std::invalid_argument);  // measures positions
}

TEST(NavigationRun, GivesTheSameBytesAgain) {
  const earth::Trajectory truth = flight();
  Scenario scene = scene_on(truth);
  scene.sensor.gyro.white = 1e-4;
  scene.aids = {aid(Aid::Kind::position, 1)};
  Recording recording = record(truth);
  recording.fixes = {fixes(Aid::Kind::position, truth, 0.333, 1)};
  const auto a = navigate(scene, recording), b = navigate(scene, recording);
  ASSERT_EQ(a.solutions.size(), b.solutions.size());
  EXPECT_EQ(a.solutions.back().state.p_eb_e, b.solutions.back().state.p_eb_e);
  EXPECT_EQ(a.solutions.back().position_sigma, b.solutions.back().position_sigma);
}

}  // namespace
}  // namespace gyrobudget::navigation
