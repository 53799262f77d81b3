// SPDX-License-Identifier: MIT
// budget: scene -> error budget per source.
#include "gyrobudget/app/report/budget.h"

#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/trajectory_file.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/estimation/budget/alignment_time.h"
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/budget/scene_runs.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "notes.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using budget::BudgetScene;
using report::BudgetResult;

budget::BudgetQuestion question(const BudgetArguments& a, const navigation::Scenario& scenario, double at) {
  budget::BudgetQuestion q = budget::question_of(scenario, 1 / a.rate);
  q.step = a.step;
  q.at = {at};
  return q;
}

std::size_t index_of(const std::vector<double>& times, double at) {
  const auto nearest = std::min_element(times.begin(), times.end(),
                                        [at](double a, double b) { return std::abs(a - at) < std::abs(b - at); });
  return static_cast<std::size_t>(nearest - times.begin());
}

// Axes of the tables: at the scene's site; where it has none, at the place reached, as on a cruise over a quarter of Earth
// the start's "up" says little.
void choose_axes(BudgetResult& r, const navigation::Scenario& scenario, const earth::Trajectory& trajectory) {
  if (scenario.site) return;
  const earth::Geodetic here = earth::to_geodetic(trajectory.at(r.at).pose.p_eb_e);
  r.C_enu = earth::LocalFrame::east_north_up(here).C_el();
  r.C_launch = earth::LocalFrame::launch_plane(here, scenario.azimuth).C_el();
}

void add_exact(BudgetResult& r, const BudgetScene& scene, const budget::FrozenGains& gains, double imu_interval) {
  const budget::Adjoint back = adjoint(scene.timeline, gains, r.at);
  r.exact.emplace();
  for (const auto& source : scene.sources) r.exact->push_back(response(back, scene.timeline, source, imu_interval));
}

// All runs of a budget, that of the whole scene and those of its sources, as one piece of work.
class Flights {
 public:
  Flights(const BudgetArguments& a, int flights)
      : progress_(a.common, "runs"), all_(static_cast<double>(flights) * a.runs), runs_(a.runs) {
    options_.runs = a.runs;
    options_.seed = a.seed;
    options_.imu_interval = 1 / a.rate;
    options_.progress = [this](int done) {
      progress_.update(done_ + done, all_);
      return !interruption_.asked();
    };
  }
  Flights(const Flights&) = delete;
  Flights& operator=(const Flights&) = delete;

  [[nodiscard]] const budget::MonteCarlo::Options& options() const { return options_; }
  void flown() { done_ += runs_; }

 private:
  Progress progress_;
  Interruption interruption_;
  double all_, runs_, done_ = 0;
  budget::MonteCarlo::Options options_;
};

void add_monte_carlo(BudgetResult& r, const BudgetArguments& a, const BudgetScene& scene,
                     const navigation::Scenario& scenario, const budget::FrozenGains& gains) {
  Flights flights(a, a.each_source ? 1 + static_cast<int>(r.budget.lines.size()) : 1);
  const auto flown = fly(scene, scenario, flights.options());
  flights.flown();
  if (flown.unaligned > 0)
    r.notes.push_back(
        fmt::format("{} runs of Monte Carlo found no heading on the pad and do not count: give the alignment one",
                    flown.unaligned));
  r.interrupted = flown.runs + flown.unaligned < a.runs;
  if (r.interrupted) r.notes.push_back(fmt::format("Monte Carlo was interrupted: {} of {} runs", flown.runs, a.runs));
  note_refused(r.notes, flown.fixes, flown.refused);
  if (flown.runs == 0) return;
  const std::size_t i = index_of(flown.times, r.at);
  const auto all = error_budget(scene.timeline, scene.sources, gains);
  BudgetResult::MonteCarlo mc{.runs = flown.runs,
                              .seed = a.seed,
                              .covariance = flown.covariance(i),
                              .nees = flown.nees(i, all.total[r.at_index], r.C_enu),
                              .saturated = flown.saturated};
  for (const auto& run : flown.errors) mc.points.emplace_back(r.C_enu.transpose() * run[i].head<3>());
  for (const auto& line : r.budget.lines) {
    if (!a.each_source) break;
    auto& one = mc.sources.emplace_back();
    if (r.interrupted) continue;
    const auto source = std::ranges::find(scene.sources, line.name, &budget::Source::name);
    const auto alone = fly_alone(scene, scenario, *source, flights.options());
    flights.flown();
    if (alone && alone->runs + alone->unaligned < a.runs) {
      r.interrupted = true;
      r.notes.push_back(
          fmt::format("Monte Carlo was interrupted at {}: it and the sources behind it are not compared", line.name));
      continue;
    }
    if (alone && alone->runs > 0) one = {alone->runs, alone->covariance(i)};
  }
  r.monte_carlo = std::move(mc);
}

// "crossrange < 10 m", of all sources, those left out too.
BudgetResult::Limit limit(const BudgetArguments& a, const BudgetResult& r, const budget::Budget& all,
                          const navigation::Scenario& scenario, const earth::Trajectory& trajectory) {
  BudgetResult::Limit result{.text = a.limit->text, .component = a.limit->component, .limit = a.limit->metres};
  result.found = position_sigma(r, all.total[r.at_index], result.component);
  const auto axes = component_axes(r, result.component);
  for (const auto& line : r.budget.lines)
    result.factors.push_back(allowed_factor(all, r.at_index, line.name, axes, result.limit));
  if (std::holds_alternative<navigation::SelfAlignment>(scenario.alignment.attitude))
    result.alignment = alignment_time(scenario, trajectory, question(a, scenario, r.at), r.at, axes, result.limit);
  return result;
}

// Gauss-Markov states an axis that stand for 1/f noise.
int flicker_states(std::span<const budget::Source> sources) {
  const auto flicker = std::ranges::find(sources, "gyro.bias_instability", &budget::Source::name);
  if (flicker == sources.end()) return 0;
  const auto& terms = flicker->model.terms;
  return static_cast<int>(
             std::ranges::count_if(terms, [](const auto& term) { return std::isfinite(term.correlation_time); })) /
         3;
}

// The largest attitude error of the growth and when: what is second order in it grows with its square.
void note_large_angles(BudgetResult& r) {
  constexpr double kLinear = 5 * earth::kDegree;
  constexpr std::array kAxes{"east", "north", "up"};
  double largest = 0, when = 0;
  Eigen::Index axis = 0;
  for (std::size_t i = 0; i < r.budget.times.size(); ++i) {
    const Eigen::Vector3d sigma = navigation::local_sigmas(r.budget.total[i], r.C_enu).attitude;
    if (Eigen::Index k = 0; sigma.maxCoeff(&k) > largest) {
      largest = sigma[k];
      axis = k;
      when = r.budget.times[i];
    }
  }
  if (largest < kLinear) return;
  r.notes.push_back(fmt::format(
      "the attitude about {} has a sigma of {:.3g} deg at {:.4g} s: beyond about 5 deg linear theory fails and the covariance does not hold; --runs tells by how much",
      kAxes[static_cast<std::size_t>(axis)], largest / earth::kDegree, when));
}

void note_short_flight(std::vector<std::string>& notes, const files::SceneFile& file,
                       const earth::Trajectory& trajectory) {
  const flight::Flight& flight = file.flight->plan.flight;
  const double asked = std::isfinite(flight.duration) ? flight.duration : flight.vehicle.burn_time;
  if (trajectory.duration() < asked - flight.period)
    notes.push_back(fmt::format("the flight ends at {:.4g} s and not at {:.4g} s: gyrobudget fly says why",
                                trajectory.duration(), asked));
}

BudgetResult budget(const BudgetArguments& a, const files::SceneFile& file, const earth::Trajectory& trajectory) {
  const navigation::Scenario& scenario = file.scenario;
  const double end = trajectory.duration();
  const double at = a.at.value_or(end);
  if (!(at >= 0 && at <= end))
    throw std::invalid_argument(fmt::format("--at {} s: the scene runs from 0 to {} s", at, end));
  BudgetScene scene = budget_scene(scenario, trajectory, question(a, scenario, at));
  const budget::FrozenGains gains = frozen_gains(scene.timeline, scene.design);
  BudgetResult r{.scene = a.scene,
                 .name = scenario.name,
                 .sensor = file.sensor,
                 .command = a.common.command_line,
                 .at = at,
                 .C_enu = scene.C_enu,
                 .C_launch = scene.C_launch,
                 .aided = scene.design.has_value(),
                 .pad = -scene.timeline.start(),
                 .tolerance = a.keep_all ? 0 : a.tolerance,
                 .not_modelled = scene.left_out};
  choose_axes(r, scenario, trajectory);
  r.notes.insert(r.notes.end(), scene.warnings.begin(), scene.warnings.end());
  if (file.sensor.empty()) r.notes.emplace_back("the scene names no sensor file: the IMU is ideal");
  const BudgetScene whole = scene;
  if (!a.keep_all) r.left_out = leave_out(scene, gains, std::span(&at, 1), a.tolerance);
  r.budget = error_budget(scene.timeline, scene.sources, gains);
  r.at_index = index_of(r.budget.times, at);
  r.flicker_states = flicker_states(whole.sources);
  note_large_angles(r);
  if (a.exact) add_exact(r, scene, gains, 1 / a.rate);
  if (a.limit) {
    const auto all = error_budget(whole.timeline, whole.sources, gains);
    r.limit = limit(a, r, all, scenario, trajectory);
  }
  if (a.runs > 0) add_monte_carlo(r, a, whole, scenario, gains);
  return r;
}

}  // namespace

int run(const BudgetArguments& a) {
  const std::vector<Output> outputs{{"--report", a.report}};
  check_outputs(a.scene, outputs);
  files::SceneFile file = files::read_scene(a.scene);
  for (const std::string& input : {file.sensor, file.trajectory}) check_outputs(input, outputs);
  for (const std::string& input : a.sensors) check_outputs(input, outputs);
  if (file.flight) check_outputs(file.flight->vehicle.path, outputs);
  const earth::Trajectory trajectory = files::planned_trajectory(file);
  std::vector<std::string> notes;
  if (file.flight) note_short_flight(notes, file, trajectory);
  std::vector<BudgetResult> results;
  if (a.sensors.empty()) results.push_back(budget(a, file, trajectory));
  for (const std::string& sensor : a.sensors) {
    if (!results.empty() && results.back().interrupted) break;
    change_sensor(file, sensor);
    results.push_back(budget(a, file, trajectory));
  }
  for (auto& r : results) r.notes.insert(r.notes.begin(), notes.begin(), notes.end());
  print(a.common.json ? report::budget_json(results) : report::budget_text(results));
  if (!a.report.empty()) {
    text::write_file(a.report, report::budget_page(results));
    say(a.common, "report page: " + a.report);
  }
  const bool broken = std::any_of(results.begin(), results.end(),
                                  [](const auto& r) { return r.limit && !(r.limit->found <= r.limit->limit); });
  if (results.back().interrupted) return exit_interrupted;
  return broken ? exit_no_answer : exit_done;
}

}  // namespace gyrobudget::inline v0::cli
