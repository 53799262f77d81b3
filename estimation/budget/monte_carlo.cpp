// SPDX-License-Identifier: MIT
#include "monte_carlo.h"

#include "gyrobudget/vehicle/earth/attitude.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "simulated_navigator.h"

namespace gyrobudget::inline v0::budget {
namespace {

using CoreVector = Eigen::Matrix<double, navigation::kCoreStates, 1>;

struct Flown {
  std::vector<CoreVector> errors;  ///< at the times of interest; none where no heading was found
  bool aligned = true;
  Saturated saturated;
  FixCount fixes;
};

CoreVector error(const earth::Pose& truth, const earth::Pose& estimate) {
  CoreVector e;
  e << truth.p_eb_e - estimate.p_eb_e, truth.v_eb_e - estimate.v_eb_e,
      earth::log_rotation(truth.q_eb * estimate.q_eb.conjugate());
  return e;
}

Flown fly(const SimulatedScene& scene, std::uint64_t run) {
  const Timeline& timeline = scene.timeline();
  SimulatedNavigator navigator(scene, run);
  Flown flown;
  flown.aligned = navigator.aligned();
  if (!flown.aligned) return flown;
  const auto at_sample = [&] {
    const std::size_t k = navigator.samples();
    const auto& report = timeline.report();
    const std::size_t next = flown.errors.size();
    const bool asked = next < report.size() && scene.sample(report[next]) <= k;
    if (!asked && !navigator.fix_due()) return;
    const earth::Motion truth = timeline.at(scene.time(k));
    navigator.use_fixes(truth);
    if (asked) flown.errors.push_back(error(truth.pose, navigator.state()));
  };
  for (const noise::ImuIncrement& exact : scene.increments()) {
    at_sample();
    navigator.step(exact);
  }
  at_sample();
  flown.saturated = navigator.saturated();
  flown.fixes = navigator.fixes();
  return flown;
}

void check(const MonteCarlo& flown, std::size_t i) {
  if (flown.runs < 1) throw std::invalid_argument("no run of Monte Carlo was flown to its end");
  if (i >= flown.times.size()) throw std::out_of_range(fmt::format("time {} of {}", i, flown.times.size()));
}

}  // namespace

Saturated& Saturated::operator+=(const Saturated& more) {
  for (std::size_t i = 0; i < 3; ++i) {
    gyro[i] += more.gyro[i];
    accelerometer[i] += more.accelerometer[i];
  }
  return *this;
}

std::uint64_t Saturated::sum() const {
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < 3; ++i) all += gyro[i] + accelerometer[i];
  return all;
}

FixCount& FixCount::operator+=(const FixCount& more) {
  given += more.given;
  refused += more.refused;
  return *this;
}

double FixCount::refused_share() const {
  return given > 0 ? static_cast<double>(refused) / static_cast<double>(given) : 0;
}

bool FixCount::beyond_chance() const {
  constexpr double kByChance = 1e-3;
  return refused_share() > kByChance;
}

navigation::CoreMatrix MonteCarlo::covariance(std::size_t i) const {
  check(*this, i);
  navigation::CoreMatrix sum = navigation::CoreMatrix::Zero();
  for (const auto& run : errors) sum += run[i] * run[i].transpose();
  return sum / runs;
}

double second_order(const navigation::CoreMatrix& P) {
  constexpr double kTerms = 10, kMost = 0.01, kLeast = 1e-12;
  return std::clamp(kTerms * P.block<3, 3>(navigation::kAttitude, navigation::kAttitude).trace(), kLeast, kMost);
}

MonteCarlo::Nees MonteCarlo::nees(std::size_t i, const navigation::CoreMatrix& P, const Eigen::Matrix3d& C_el) const {
  check(*this, i);
  navigation::CoreMatrix local = navigation::CoreMatrix::Zero();
  for (int k = 0; k < navigation::kCoreStates; k += 3) local.block<3, 3>(k, k) = C_el.transpose();
  const navigation::FirstOrderNees directions(local * P * local.transpose(), second_order(P));
  Nees result{.dof = directions.dof()};
  for (const auto& run : errors) result.mean += directions(local * run[i]) / runs;
  for (const auto& direction : directions.left_out()) {
    double sum = 0;
    for (const auto& run : errors) sum += std::pow(directions.along(direction, local * run[i]), 2);
    result.left_out.push_back({direction.weights, std::sqrt(direction.variance), std::sqrt(sum / runs)});
  }
  return result;
}

MonteCarlo monte_carlo(const Timeline& timeline, const noise::SensorModel& sensor, const InitialErrors& initial,
                       const Eigen::Matrix3d& C_el, const std::optional<Design>& design,
                       const MonteCarlo::AidErrors& aids, const MonteCarlo::Options& options) {
  const SimulatedScene scene(timeline, sensor, initial, C_el, design, aids, options);
  MonteCarlo result;
  result.times = timeline.report();
  std::vector<std::vector<CoreVector>> errors(static_cast<std::size_t>(options.runs));
  std::atomic<int> unaligned = 0;
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  int done = 0;
  tbb::parallel_for(0, options.runs, [&](int run) {
    if (stopped) return;
    Flown flown = fly(scene, static_cast<std::uint64_t>(run));
    errors[static_cast<std::size_t>(run)] = std::move(flown.errors);
    unaligned += flown.aligned ? 0 : 1;
    const std::lock_guard lock(mutex);
    result.saturated += flown.saturated;
    result.fixes += flown.fixes;
    ++done;
    if (options.progress && !options.progress(done)) stopped = true;
  });
  std::erase_if(errors, [](const auto& run) { return run.empty(); });
  result.errors = std::move(errors);
  result.runs = static_cast<int>(result.errors.size());
  result.unaligned = unaligned;
  return result;
}

}  // namespace gyrobudget::inline v0::budget
