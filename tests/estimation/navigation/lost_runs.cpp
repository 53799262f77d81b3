// SPDX-License-Identifier: MIT
#include "lost_runs.h"

#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/estimation/navigation/simulated_fixes.h"
#include "gyrobudget/estimation/navigation/simulated_imu.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <random>

#include "sensors.h"

namespace gyrobudget::lost {
namespace {

using earth::kDegree;
using Eigen::Vector3d;
using navigation::Aid;

constexpr double kRate = 50;                                      // Hz
constexpr double kLevel = 0.5 * kDegree, kHeading = 2 * kDegree;  // one sigma of the start

Aid aid(const char* name, Aid::Kind kind, double sigma, bool used) {
  Aid a;
  a.name = name;
  a.kind = kind;
  a.sigma.setConstant(sigma);
  a.used = used;
  return a;
}

// The sensor with smaller or larger sigmas.
noise::SensorModel told(noise::SensorModel sensor, double factor) {
  for (noise::ErrorModel* errors : {&sensor.gyro, &*sensor.accelerometer}) {
    for (noise::PerAxis* values : {&errors->white, &errors->bias_instability, &errors->rate_random_walk,
                                   &*errors->turn_on_bias, &*errors->scale_factor, &*errors->misalignment})
      *values *= factor;
  }
  return sensor;
}

Run drive_once(const Case& c, const earth::Trajectory& truth, int number) {
  const double back = c.outage > 0 ? c.outage_from + c.outage : 0;
  constexpr double kExact = 1e-6, kFix = 2;  // m
  navigation::Scenario scene;
  scene.sensor = told(tests::mems_imu(), c.told);
  scene.aids = {aid("gnss.position", Aid::Kind::position, kFix, true),
                aid("gnss.velocity", Aid::Kind::velocity, 0.05, true),
                aid("truth.position", Aid::Kind::position, kExact, false),
                aid("truth.velocity", Aid::Kind::velocity, kExact, false),
                aid("truth.attitude", Aid::Kind::attitude, kExact, false)};
  for (int i = 0; i < 2 && c.outage > 0; ++i)
    scene.aids[static_cast<std::size_t>(i)].outages = {{c.outage_from, back - 0.5}};
  scene.reference = {2, 3, 4};
  scene.recovery = c.recovery;
  std::mt19937_64 random(static_cast<std::uint64_t>(number) + 1);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma) {
    return Vector3d(sigma * normal(random), sigma * normal(random), sigma * normal(random));
  };
  const auto start = truth.at(0);
  const earth::Geodetic place = earth::to_geodetic(start.pose.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  scene.alignment.position = earth::to_geodetic(start.pose.p_eb_e + draw(2) + C_en * Vector3d(c.start_error, 0, 0));
  scene.alignment.position_sigma = Vector3d::Constant(2);
  scene.alignment.velocity = Vector3d(C_en.transpose() * start.pose.v_eb_e + draw(0.05));
  scene.alignment.velocity_sigma = Vector3d::Constant(0.05);
  earth::Euler euler = earth::to_euler(Eigen::Quaterniond(C_en).conjugate() * start.pose.q_eb);
  euler.yaw += kHeading * normal(random);
  euler.pitch += kLevel * normal(random);
  euler.roll += kLevel * normal(random);
  scene.alignment.attitude = euler;
  scene.alignment.level_sigma = kLevel;
  scene.alignment.heading_sigma = kHeading;

  navigation::SimulatedImu imu(truth, tests::mems_imu(), {.rate_hz = kRate, .run = static_cast<std::uint64_t>(number)});
  navigation::Recording recording;
  recording.imu.increments = imu.next(static_cast<std::size_t>(truth.duration() * kRate));
  recording.imu.typical_interval = 1 / kRate;
  for (std::size_t k = 0; k <= recording.imu.increments.size(); ++k)
    recording.imu.stamps.push_back(std::llround(static_cast<double>(k) / kRate * 1e9));
  recording.imu.bridged.assign(recording.imu.increments.size(), false);
  for (std::size_t i = 0; i < scene.aids.size(); ++i)
    recording.fixes.push_back(
        navigation::simulated_fixes(scene.aids[i], static_cast<int>(i), truth, 1, static_cast<std::uint64_t>(number)));
  Run run;
  run.found = navigation::navigate(scene, recording);
  run.found_after = std::numeric_limits<double>::infinity();
  constexpr double kFar = 6;  // sigmas: beyond what the gate may use
  constexpr int kInARow = 5;
  int unsaid = 0;
  for (const navigation::Solution& s : run.found.solutions) {
    const earth::Geodetic at = earth::to_geodetic(s.state.p_eb_e);
    const Vector3d error =
        earth::C_e_enu(at.latitude, at.longitude).transpose() * (truth.at(s.time).pose.p_eb_e - s.state.p_eb_e);
    const bool far = (error.array().abs() > kFar * (s.position_sigma.array().square() + kFix * kFix).sqrt()).any();
    unsaid = far && !s.lost && run.found.usable() ? unsaid + 1 : 0;
    if (unsaid >= kInARow) run.unsaid_at = s.time;
    if (far) run.found_after = std::numeric_limits<double>::infinity();
    if (!far && std::isinf(run.found_after)) run.found_after = std::max(0.0, s.time - back);
  }
  return run;
}

}  // namespace

std::vector<Run> drive(const Case& c) {
  const double back = c.outage > 0 ? c.outage_from + c.outage : 0;
  const earth::Trajectory truth = earth::cruise({.speed = c.drive.speed,
                                                 .turn_acceleration = c.drive.turn_acceleration,
                                                 .turn_period = c.drive.turn_period,
                                                 .duration = back + c.after});
  std::vector<Run> runs(static_cast<std::size_t>(c.runs));
  tbb::parallel_for(0, c.runs, [&](int i) { runs[static_cast<std::size_t>(i)] = drive_once(c, truth, i); });
  return runs;
}

double nees_inside(const std::vector<Run>& runs, double from) {
  constexpr double kStates = 9;
  std::vector<double> sums, counts;
  for (const Run& run : runs) {
    if (!run.found.usable() || !run.found.reference) continue;
    for (const navigation::ReferenceError& e : run.found.reference->errors) {
      if (e.time < from) continue;
      const auto k = static_cast<std::size_t>(std::llround(e.time - from));
      if (k >= sums.size()) sums.resize(k + 1), counts.resize(k + 1);
      sums[k] += e.nees;
      counts[k] += 1;
    }
  }
  double inside = 0;
  for (std::size_t k = 0; k < sums.size(); ++k)
    inside += counts[k] > 0 && navigation::chi_square_mean_band(kStates, counts[k]).holds(sums[k] / counts[k]) ? 1 : 0;
  return inside / static_cast<double>(sums.size());
}

}  // namespace gyrobudget::lost
