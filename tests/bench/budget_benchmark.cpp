// SPDX-License-Identifier: MIT
// Error against run time of an error budget: 83 s of ascent with a MEMS IMU of 12 sources and more.
//
//   budget_benchmark                    covariance step, states of 1/f, exact integrals, Monte Carlo runs
//   budget_benchmark quick              without Monte Carlo
//   budget_benchmark --plot FILE.svg    and the same as a picture, by gnuplot
//
// Errors are those of the position's root sum square at burn-out against the finest of each kind; of Monte Carlo, half
// the 99 % band of a sigma by that many runs.
#include "gyrobudget/app/report/gnuplot.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/budget/scene_runs.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace gyrobudget;  // NOLINT
using budget::BudgetQuestion;
using budget::BudgetScene;
using navigation::CoreMatrix;
using navigation::Scenario;

constexpr double kHour = 3600, kMicroG = 9.80665e-6;
constexpr double kFinest = 0.01;  // [s]: 100 Hz

Scenario ascent() {
  Scenario scenario;
  auto& gyro = scenario.sensor.gyro;
  gyro.white = 0.15 * earth::kDegree / 60;
  gyro.bias_instability = 0.7 * earth::kDegree / kHour;
  gyro.rate_random_walk = 4.32 * earth::kDegree / kHour / 60;
  gyro.turn_on_bias = 10 * earth::kDegree / kHour;
  gyro.scale_factor = 5e-4;
  gyro.misalignment = 1e-3;
  gyro.powered_on_before = 600;
  auto& accelerometer = scenario.sensor.accelerometer.emplace();
  accelerometer.white = 1e-3;
  accelerometer.bias_instability = 50 * kMicroG;
  accelerometer.turn_on_bias = 1000 * kMicroG;
  accelerometer.scale_factor = 5e-4;
  scenario.alignment.level_sigma = 1e-3;
  scenario.alignment.heading_sigma = 1e-3;
  return scenario;
}

// The same with a GNSS receiver, and a filter in every run.
Scenario aided() {
  Scenario scenario = ascent();
  using navigation::Aid;
  scenario.aids = {{.name = "gnss.position", .kind = Aid::Kind::position, .sigma = Eigen::Vector3d(2, 2, 4)},
                   {.name = "gnss.velocity", .kind = Aid::Kind::velocity, .sigma = Eigen::Vector3d::Constant(0.1)}};
  return scenario;
}

// Relative error over run time [s], by way.
struct Point {
  double time = 0, error = 0;
};
using Points = std::map<std::string, std::vector<Point>>;

double seconds(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double position(const CoreMatrix& P) { return std::sqrt(P.block<3, 3>(0, 0).trace()); }

BudgetScene scene_of(const Scenario& scenario, double step) {
  BudgetQuestion question;
  question.step = step;
  question.growth_points = 0;
  return budget_scene(scenario, earth::ascent({}), question);
}

double total(const Scenario& scenario, double step) {
  const BudgetScene scene = scene_of(scenario, step);
  return position(error_budget(scene.timeline, scene.sources).total.back());
}

void by_step(const Scenario& scenario, Points& points) {
  double finest = 0;
  const double time = seconds([&] { finest = total(scenario, kFinest); });
  fmt::print("{} sources, 83 s at 100 Hz: {:.2f} s\n\n", scene_of(scenario, 1).sources.size(), time);
  fmt::print("covariance step   steps   error      run time\n");
  const double length = earth::Ascent{}.duration;
  for (const int steps : {10, 25, 50, 100, 200, 400, 800}) {
    double found = 0;
    const double cost = seconds([&] { found = total(scenario, length / steps); });
    points["covariance, by its step"].push_back({cost, std::abs(found / finest - 1)});
    fmt::print("  {:7.3f} s       {:5}   {:8.1e}   {:6.1f} ms{}\n", length / steps, steps, std::abs(found / finest - 1),
               1e3 * cost, steps == 200 ? "   default" : "");
  }
}

// Run time of one flight of an ideal IMU, on all cores.
double strapdown_alone() {
  static const double time = [] {
    const Scenario ideal;
    const BudgetScene scene = scene_of(ideal, 0.4);
    budget::MonteCarlo::Options options;
    options.runs = 100;
    return seconds([&] { (void)fly(scene, ideal, options); }) / options.runs;
  }();
  return time;
}

// Of gyro.bias_instability alone, against its structure function.
void by_states(const Scenario& scenario, Points& points) {
  Scenario flicker;
  flicker.sensor.gyro.bias_instability = scenario.sensor.gyro.bias_instability;
  flicker.sensor.gyro.powered_on_before = 600;
  fmt::print("\n1/f of the gyro alone          error      run time\n");
  const double length = earth::Ascent{}.duration;
  const auto exact = [&](double step, double* cost) {
    const BudgetScene scene = scene_of(flicker, step);
    double found = 0;
    *cost = seconds([&] {
      const auto back = adjoint(scene.timeline, {}, scene.timeline.end());
      found = position(response(back, scene.timeline, scene.sources[0], kFinest));
    });
    return found;
  };
  double cost = 0;
  const double truth = exact(length / 1600, &cost);
  for (int states = 0; states <= 4; ++states) {
    flicker.states.flicker_states = states;
    double found = 0;
    cost = seconds([&] { found = total(flicker, length / 800); });
    points["1/f alone, by its states"].push_back({cost, std::abs(found / truth - 1)});
    fmt::print("  {} states, 800 steps           {:8.1e}   {:6.1f} ms\n", states, std::abs(found / truth - 1),
               1e3 * cost);
  }
  flicker.states.flicker_states.reset();
  for (const int steps : {50, 100, 200, 400, 800}) {
    const double found = exact(length / steps, &cost);
    points["1/f alone, exact integrals by step"].push_back({cost, std::abs(found / truth - 1)});
    fmt::print("  exact integrals, {:4} steps    {:8.1e}   {:6.1f} ms\n", steps, std::abs(found / truth - 1),
               1e3 * cost);
  }
}

void by_runs(const Scenario& scenario, const std::string& way, Points& points) {
  const BudgetScene scene = scene_of(scenario, 0.4);
  const double linear = position(error_budget(scene.timeline, scene.sources, scene.design).total.back());
  fmt::print("\n{:<25} found/linear   99 % band of an axis   run time   of a run of strapdown alone\n", way);
  for (const int runs : {50, 200, 1000}) {
    budget::MonteCarlo::Options options;
    options.runs = runs;
    double found = 0;
    const double cost = seconds([&] { found = position(fly(scene, scenario, options).covariance(0)); });
    const auto band = navigation::sigma_ratio_band(runs, 0.99);
    points[way].push_back({cost, (band.upper - band.lower) / 2});
    fmt::print("  {:5} runs                 {:5.3f}       {:5.3f} to {:5.3f}         {:5.2f} s    {:4.1f} x\n", runs,
               found / linear, band.lower, band.upper, cost, cost / runs / strapdown_alone());
  }
}

std::string picture(const Points& points) {
  std::string script =
      "set terminal svg size 900,600 dynamic font 'sans-serif,14' background '#ffffff'\n"
      "set logscale xy\nset format '%g'\nset grid\nset key outside bottom center vertical maxrows 3\n"
      "set title 'Error budget of an 83 s ascent'\n"
      "set xlabel 'run time [s]'\nset ylabel 'relative error of the position'\n";
  std::string plots;
  for (const auto& [way, list] : points) {
    const std::string title = report::gnuplot_string(way);
    plots += fmt::format("{}'-' using 1:2 with linespoints linewidth 2 pointtype 7 title {}", plots.empty() ? "" : ", ",
                         title);
  }
  script += fmt::format("plot {}\n", plots);
  for (const auto& [way, list] : points) {
    for (const Point& point : list) script += fmt::format("{:.6e} {:.6e}\n", point.time, point.error);
    script += "e\n";
  }
  return report::run_gnuplot(script);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  const Scenario scenario = ascent();
  Points points;
  by_step(scenario, points);
  by_states(scenario, points);
  if (std::ranges::find(words, "quick") == words.end()) {
    by_runs(scenario, "Monte Carlo, 100 Hz", points);
    by_runs(aided(), "Monte Carlo with a filter", points);
  }
  const auto plot = std::ranges::find(words, "--plot");
  if (plot != words.end() && plot + 1 != words.end()) text::write_file(std::string(plot[1]), picture(points));
}
