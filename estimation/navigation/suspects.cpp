// SPDX-License-Identifier: MIT
#include "suspects.h"

#include "gyrobudget/estimation/navigation/detail/lost.h"
#include "gyrobudget/estimation/navigation/detail/runner.h"
#include "gyrobudget/estimation/navigation/detail/tried.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "consistency.h"
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLeastExplained = 0.2;
constexpr double kNoMisfit = 1;  // right sigmas give 0.46 for three rows, E max(0, chi-square - 3)/3

// A scene that a suspect has changed, and what it makes of the IMU's triads.
struct Trying {
  Scenario scenario;
  Matrix3d gyro = Matrix3d::Identity(), accelerometer = Matrix3d::Identity();
};

ImuLog changed(ImuLog log, const Matrix3d& gyro, const Matrix3d& accelerometer) {
  if (gyro.isIdentity(0) && accelerometer.isIdentity(0)) return log;
  for (noise::ImuIncrement& increment : log.increments) {
    increment.angle = earth::array(gyro * earth::vector(increment.angle));
    increment.velocity = earth::array(accelerometer * earth::vector(increment.velocity));
  }
  return log;
}

// --- What a run says ---

// Mean over the fixes that are watched; infinite where there are none.
double misfit(const Scenario& scenario, const Navigation& run) {
  double sum = 0;
  std::int64_t count = 0;
  static const detail::NisLimit limit(detail::LostWatch::kDisagrees);
  for (const InnovationAt& at : run.innovations) {
    const Innovation& i = at.innovation;
    if (!detail::LostWatch::watched(scenario.aids[at.aid]) || i.status == Innovation::Status::not_finite) continue;
    const double most = limit.of(i.rows);
    sum += std::max(0.0, (std::isnan(i.nis) ? most : std::min(i.nis, most)) - i.rows) / i.rows;
    ++count;
  }
  return count == 0 ? std::numeric_limits<double>::infinity() : sum / static_cast<double>(count);
}

class Scan {
 public:
  Scan(const Scenario& scenario, const Recording& recording)
      : scenario_(detail::quick(scenario)), part_(detail::beginning(scenario, recording)) {
    for (Aid& aid : scenario_.aids) aid.time_tag_sigma = 0;
    as_it_is_ = misfit_of({scenario_}).value_or(std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] std::vector<Suspect> suspects() {
    if (as_it_is_ < kNoMisfit) return {};
    for (const std::vector<std::size_t>& device : devices()) {
      try_clock(device);
      try_lever_arm(device);
      try_sigma(device);
    }
    try_axes();
    try_units();
    try_heading();
    std::ranges::stable_sort(found_, [](const Suspect& a, const Suspect& b) {
      const bool sigma_a = a.kind == Suspect::Kind::sigma, sigma_b = b.kind == Suspect::Kind::sigma;
      return sigma_a != sigma_b ? sigma_b : a.explained > b.explained;
    });
    if (found_.size() > kMostSuspects) found_.resize(kMostSuspects);
    return std::move(found_);
  }

 private:
  // Aids that one device measures: those with one clock, the rest each by itself.
  [[nodiscard]] std::vector<std::vector<std::size_t>> devices() const {
    std::vector<std::vector<std::size_t>> result;
    for (std::size_t i = 0; i < scenario_.aids.size(); ++i) {
      const Aid& aid = scenario_.aids[i];
      if (!aid.used || !detail::LostWatch::watched(aid)) continue;
      const bool same =
          !result.empty() && !aid.clock.empty() && scenario_.aids[result.back().front()].clock == aid.clock;
      if (!same) result.emplace_back();
      result.back().push_back(i);
    }
    return result;
  }

  // What cannot be run explains nothing.
  [[nodiscard]] std::optional<Navigation> run(const Trying& trying) const {
    const Recording tried{
        .origin = part_.origin, .imu = changed(part_.imu, trying.gyro, trying.accelerometer), .fixes = part_.fixes};
    try {
      return detail::run(trying.scenario, tried);
    } catch (const SetupError&) {
      return std::nullopt;
    }
  }
  [[nodiscard]] std::optional<double> misfit_of(const Trying& trying) const {
    const auto found = run(trying);
    if (!found) return std::nullopt;
    return misfit(trying.scenario, *found);
  }

  // Runs all and keeps the best, if it explains enough.
  void keep_best(std::vector<std::pair<Suspect, Trying>> list) {
    std::vector<std::optional<double>> misfits(list.size());
    tbb::parallel_for(std::size_t{0}, list.size(), [&](std::size_t i) { misfits[i] = misfit_of(list[i].second); });
    const Suspect* best = nullptr;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!misfits[i]) continue;
      list[i].first.explained = explained(*misfits[i]);
      if (best == nullptr || list[i].first.explained > best->explained) best = &list[i].first;
    }
    if (best != nullptr && best->explained >= kLeastExplained) found_.push_back(*best);
  }
  [[nodiscard]] double explained(double left) const { return std::clamp(1 - left / as_it_is_, 0.0, 1.0); }

  // --- Suspects ---

  [[nodiscard]] Scenario with_clock(const std::vector<std::size_t>& device, double shift) const {
    Scenario changed = scenario_;
    for (const std::size_t i : device) changed.aids[i].time_tag += shift;
    return changed;
  }

  // Of offsets, all shared out at once; the best and what it explains.
  [[nodiscard]] std::pair<double, double> best_shift(const std::vector<std::size_t>& device,
                                                     const std::vector<double>& shifts) const {
    std::vector<std::optional<double>> misfits(shifts.size());
    tbb::parallel_for(std::size_t{0}, shifts.size(),
                      [&](std::size_t i) { misfits[i] = misfit_of({with_clock(device, shifts[i])}); });
    std::pair<double, double> best{0, 0};
    for (std::size_t i = 0; i < shifts.size(); ++i)
      if (misfits[i] && explained(*misfits[i]) > best.second) best = {shifts[i], explained(*misfits[i])};
    return best;
  }

  void try_clock(const std::vector<std::size_t>& device) {
    constexpr int kFar = 20, kLeap = 18;
    std::vector<double> shifts{-kLeap, kLeap};  // first: of equals the first is kept
    for (int s = 1; s <= kFar; ++s)
      if (s != kLeap) shifts.insert(shifts.end(), {-1.0 * s, 1.0 * s});
    for (const double s : {0.2, 0.4, 0.6, 0.8}) shifts.insert(shifts.end(), {-s, s});
    std::pair<double, double> best = best_shift(device, shifts);
    if (best.second < kLeastExplained) return;
    for (const double step : {0.2, 0.04}) {
      std::vector<double> around;
      for (int k = -4; k <= 4; ++k)
        if (k != 0) around.push_back(best.first + k * step);
      const auto finer = best_shift(device, around);
      constexpr double kBetter = 0.01;  // whole seconds are likelier than others
      if (finer.second > best.second + kBetter) best = finer;
    }
    found_.push_back({.kind = Suspect::Kind::clock, .aids = device, .value = best.first, .explained = best.second});
  }

  void try_lever_arm(const std::vector<std::size_t>& device) {
    if (scenario_.aids[device.front()].kind == Aid::Kind::height) return;
    constexpr double kWide = 10;
    constexpr std::array<double, 3> kSigmas{3, 0.5, 0.1};  // m: each run begins about what the one before found
    Scenario changed = scenario_;
    changed.solution_interval = 1;  // the last one has the arm
    Suspect suspect{.kind = Suspect::Kind::lever_arm, .aids = device, .axes = {}};
    Vector3d arm = changed.aids[device.front()].lever_arm;
    for (std::size_t pass = 0; pass < kSigmas.size(); ++pass) {
      for (const std::size_t i : device) {
        changed.aids[i].lever_arm = arm;
        changed.aids[i].lever_arm_sigma.setConstant(kSigmas[pass]);
        changed.aids[i].sigma_factor = pass == 0 ? kWide : 1;
      }
      const auto found = run({changed});
      if (!found || found->solutions.empty()) return;
      for (std::size_t k = 0; k < found->model.terms.size(); ++k) {
        const ErrorTerm& term = found->model.terms[k];
        if (term.effect == Effect::lever_arm && static_cast<std::size_t>(term.aid) == device.front())
          arm[term.axis] += found->solutions.back().terms[k];
      }
      if (!arm.allFinite()) return;
      suspect.explained = explained(misfit(changed, *found));
    }
    suspect.lever_arm = arm;
    if (suspect.explained >= kLeastExplained) found_.push_back(suspect);
  }

  void try_sigma(const std::vector<std::size_t>& device) {
    std::vector<std::pair<Suspect, Trying>> list;
    for (const double factor : {3.0, 10.0}) {
      Scenario changed = scenario_;
      for (const std::size_t i : device) changed.aids[i].sigma_factor *= factor;
      list.push_back({{.kind = Suspect::Kind::sigma, .aids = device, .value = factor, .axes = {}}, {changed}});
    }
    keep_best(std::move(list));
  }

  void try_axes() {
    std::vector<std::pair<Suspect, Trying>> list;
    std::array<int, 3> axis{0, 1, 2};
    do {
      for (unsigned signs = 0; signs < 8; ++signs) {
        Matrix3d turn = Matrix3d::Zero();
        std::string name;
        for (int i = 0; i < 3; ++i) {
          const bool minus = (signs >> i & 1U) != 0;
          turn(i, axis[static_cast<std::size_t>(i)]) = minus ? -1 : 1;
          name += fmt::format("{}{}{}", i == 0 ? "" : ", ", minus ? "-" : "",
                              "xyz"[static_cast<std::size_t>(axis[static_cast<std::size_t>(i)])]);
        }
        if (turn.isIdentity()) continue;
        Suspect suspect{.kind = Suspect::Kind::axes, .aids = {}, .axes = name};
        suspect.mirrored = turn.determinant() < 0;
        list.push_back({std::move(suspect), {scenario_, turn, turn}});
      }
    } while (std::next_permutation(axis.begin(), axis.end()));
    keep_best(std::move(list));
  }

  void try_units() {
    const Matrix3d same = Matrix3d::Identity();
    std::vector<std::pair<Suspect, Trying>> list;
    for (const double factor : {earth::kDegree, 1 / earth::kDegree})
      list.push_back({{.kind = Suspect::Kind::unit, .aids = {}, .value = factor, .axes = {}, .gyro = true},
                      {scenario_, factor * same, same}});
    for (const double factor : {noise::kStandardGravity, 1 / noise::kStandardGravity})
      list.push_back(
          {{.kind = Suspect::Kind::unit, .aids = {}, .value = factor, .axes = {}}, {scenario_, same, factor * same}});
    keep_best(std::move(list));
  }

  void try_heading() {
    std::vector<std::pair<Suspect, Trying>> list;
    for (const double degrees : {180., 90., -90.}) {
      Scenario changed = scenario_;
      const double turn = degrees * earth::kDegree;
      if (auto* euler = std::get_if<earth::Euler>(&changed.alignment.attitude))
        euler->yaw += turn;
      else if (auto* self = std::get_if<SelfAlignment>(&changed.alignment.attitude); self != nullptr && self->heading)
        *self->heading += turn;
      else
        return;
      list.push_back({{.kind = Suspect::Kind::heading, .aids = {}, .value = turn, .axes = {}}, {changed}});
    }
    keep_best(std::move(list));
  }

  Scenario scenario_;
  Recording part_;
  double as_it_is_ = 0;
  std::vector<Suspect> found_;
};

}  // namespace

std::vector<Suspect> suspects(const Scenario& scenario, const Recording& recording) {
  return Scan(scenario, recording).suspects();
}

}  // namespace gyrobudget::inline v0::navigation
