// SPDX-License-Identifier: MIT
#include "study.h"

#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "adjoint.h"
#include "scene_runs.h"
#include "sources.h"

namespace gyrobudget::inline v0::budget {
namespace {

std::size_t index_of(const std::vector<double>& times, double at) {
  const auto nearest = std::min_element(times.begin(), times.end(),
                                        [at](double a, double b) { return std::abs(a - at) < std::abs(b - at); });
  return static_cast<std::size_t>(nearest - times.begin());
}

LocalAxes axes_of(const navigation::Scenario& scenario, const earth::Trajectory& trajectory, const BudgetScene& scene,
                  double at) {
  if (scenario.site) return {scene.C_enu, scene.C_launch};
  const earth::Geodetic here = earth::to_geodetic(trajectory.at(at).pose.p_eb_e);
  return {earth::LocalFrame::east_north_up(here).C_el(),
          earth::LocalFrame::launch_plane(here, scenario.azimuth).C_el()};
}

// States of the axis that has most: those of the flicker's source that do not stay.
int flicker_states(std::span<const Source> sources) {
  const auto flicker = std::ranges::find(sources, "gyro.bias_instability", &Source::name);
  if (flicker == sources.end()) return 0;
  std::array<int, 3> count{};
  for (const auto& term : flicker->model.terms)
    if (std::isfinite(term.correlation_time)) ++count.at(static_cast<std::size_t>(term.axis));
  return std::ranges::max(count);
}

std::optional<Study::LargeAttitude> large_attitude(const Budget& budget, const Eigen::Matrix3d& C_enu) {
  Study::LargeAttitude largest;
  for (std::size_t i = 0; i < budget.times.size(); ++i) {
    const Eigen::Vector3d sigma = navigation::local_sigmas(budget.total[i], C_enu).attitude;
    Eigen::Index axis = 0;
    if (const double most = sigma.maxCoeff(&axis); most > largest.sigma)
      largest = {static_cast<int>(axis), most, budget.times[i]};
  }
  if (largest.sigma < kLinearAttitude) return std::nullopt;
  return largest;
}

// All runs of a study, those of the whole scene and those of its sources, as one piece of work.
class Flights {
 public:
  Flights(const Options& options, std::size_t lines)
      : asked_(options), all_(std::int64_t{options.runs} * (options.each_source ? 1 + static_cast<int>(lines) : 1)) {}

  [[nodiscard]] MonteCarlo::Options next() {
    MonteCarlo::Options options{.runs = asked_.runs, .seed = asked_.seed, .imu_interval = asked_.imu_interval};
    if (asked_.progress)
      options.progress = [this, before = before_](int done) { return asked_.progress(before + done, all_); };
    before_ += asked_.runs;
    return options;
  }

 private:
  const Options& asked_;
  std::int64_t all_, before_ = 0;
};

class StudyBuilder {
 public:
  StudyBuilder(const navigation::Scenario& scenario, const earth::Trajectory& trajectory, const Options& options)
      : scenario_(scenario),
        trajectory_(trajectory),
        options_(options),
        at_(options.at.value_or(trajectory.duration())),
        question_(question_of(scenario, options.imu_interval)) {
    if (!(at_ >= 0 && at_ <= trajectory.duration()))
      throw navigation::SetupError(
          fmt::format("a budget at {} s: the scene runs from 0 to {} s", at_, trajectory.duration()));
    if (options.runs < 0)
      throw navigation::SetupError(fmt::format("{} runs of Monte Carlo, expected none or more", options.runs));
    question_.step = options.step;
    question_.at = {at_};
  }

  [[nodiscard]] Study operator()() {
    const BudgetScene whole = budget_scene(scenario_, trajectory_, question_);
    const FrozenGains gains = frozen_gains(whole.timeline, whole.design);
    BudgetScene kept = whole;
    result_.at = at_;
    result_.axes = axes_of(scenario_, trajectory_, whole, at_);
    result_.aided = whole.design.has_value();
    result_.pad = -whole.timeline.start();
    result_.not_modelled = whole.left_out;
    result_.no_heading = whole.no_heading;
    result_.out_of_range = whole.out_of_range;
    if (options_.tolerance) {
      result_.tolerance = *options_.tolerance;
      result_.left_out = leave_out(kept, gains, std::span(&at_, 1), *options_.tolerance);
    }
    result_.budget = error_budget(kept.timeline, kept.sources, gains);
    result_.at_index = index_of(result_.budget.times, at_);
    result_.flicker_states = flicker_states(whole.sources);
    result_.large_attitude = large_attitude(result_.budget, result_.axes.C_enu);
    if (options_.exact) add_exact(kept, gains);
    if (!options_.limit && options_.runs == 0) return std::move(result_);
    const Budget all = error_budget(whole.timeline, whole.sources, gains);
    if (options_.limit) add_limit(all);
    if (options_.runs > 0) add_monte_carlo(whole, all);
    return std::move(result_);
  }

 private:
  void add_exact(const BudgetScene& scene, const FrozenGains& gains) {
    const Adjoint back = adjoint(scene.timeline, gains, at_);
    result_.exact.emplace();
    for (const Source& source : scene.sources)
      result_.exact->push_back(response(back, scene.timeline, source, options_.imu_interval));
  }

  void add_limit(const Budget& all) {
    const auto [component, position] = *options_.limit;
    const auto axes = result_.axes.of(component);
    Study::Limit& limit = *(result_.limit = Study::Limit{});
    limit.component = component;
    limit.limit = position;
    limit.found = result_.axes.position_sigma(all.total[result_.at_index], component);
    for (const auto& line : result_.budget.lines)
      limit.factors.push_back(allowed_factor(all, result_.at_index, line.name, axes, position));
    if (std::holds_alternative<navigation::SelfAlignment>(scenario_.alignment.attitude))
      limit.alignment = alignment_time(scenario_, trajectory_, question_, at_, axes, position);
  }

  void add_monte_carlo(const BudgetScene& scene, const Budget& all) {
    Flights flights(options_, result_.budget.lines.size());
    const MonteCarlo flown = fly(scene, scenario_, flights.next());
    result_.runs = {.asked = options_.runs, .flown = flown.runs, .unaligned = flown.unaligned, .fixes = flown.fixes};
    result_.stopped = flown.runs + flown.unaligned < options_.runs;
    if (flown.runs == 0) return;
    const std::size_t i = index_of(flown.times, at_);
    Study::Flown& mc = *(result_.monte_carlo = Study::Flown{});
    mc.runs = flown.runs;
    mc.seed = options_.seed;
    mc.covariance = flown.covariance(i);
    mc.nees = flown.nees(i, all.total[result_.at_index], result_.axes.C_enu);
    mc.saturated = flown.saturated;
    for (const auto& run : flown.errors) mc.points.emplace_back(result_.axes.C_enu.transpose() * run[i].head<3>());
    if (options_.each_source) fly_each_alone(scene, flights, i);
  }

  void fly_each_alone(const BudgetScene& scene, Flights& flights, std::size_t i) {
    auto& sources = result_.monte_carlo->sources;
    sources.resize(result_.budget.lines.size());
    for (std::size_t k = 0; k < sources.size() && !result_.stopped; ++k) {
      const auto source = std::ranges::find(scene.sources, result_.budget.lines[k].name, &Source::name);
      const auto alone = fly_alone(scene, scenario_, *source, flights.next());
      if (!alone) continue;
      if (alone->runs + alone->unaligned < options_.runs) {
        result_.stopped = true;
        result_.stopped_at = k;
      } else if (alone->runs > 0) {
        sources[k] = {alone->runs, alone->covariance(i)};
      }
    }
  }

  const navigation::Scenario& scenario_;
  const earth::Trajectory& trajectory_;
  const Options& options_;
  double at_;
  BudgetQuestion question_;
  Study result_;
};

}  // namespace

Study study(const navigation::Scenario& scenario, const earth::Trajectory& trajectory, const Options& options) {
  return StudyBuilder(scenario, trajectory, options)();
}

}  // namespace gyrobudget::inline v0::budget
