// SPDX-License-Identifier: MIT
#include "scene_runs.h"

#include <algorithm>
#include <utility>

namespace gyrobudget::inline v0::budget {
namespace {

// Of the scene as a whole.
MonteCarlo::Options of_scene(const BudgetScene& scene, const navigation::Scenario& scenario,
                             MonteCarlo::Options options) {
  options.imu.vibration = scenario.states.vibration;
  options.imu.temperature = scenario.states.temperature;
  options.filter = scenario.filter;
  options.self_alignment = scene.self_alignment;
  options.heading_sigma = scene.heading_sigma;
  return options;
}

// Drawn at random, once a run; Earth's rate left out is not: the strapdown leaves it out. Nor is what a sensor makes.
bool of_the_world(const Source& source) {
  return source.shape && !source.sensor && source.name != kUncompensatedEarthRate;
}

double longest_step(const Timeline& timeline) {
  double longest = 0;
  for (const auto& step : timeline.steps()) longest = std::max(longest, step.to - step.from);
  return longest;
}

}  // namespace

MonteCarlo::Options whole_scene(const BudgetScene& scene, const navigation::Scenario& scenario,
                                MonteCarlo::Options options) {
  options = of_scene(scene, scenario, std::move(options));
  for (const Source& source : scene.sources)
    if (of_the_world(source)) options.world.push_back(source);
  return options;
}

MonteCarlo fly(const BudgetScene& scene, const navigation::Scenario& scenario, MonteCarlo::Options options) {
  return monte_carlo(scene.timeline, scenario.sensor, scene.initial, scene.C_enu, scene.design, scene.aids,
                     whole_scene(scene, scenario, std::move(options)));
}

std::optional<MonteCarlo> fly_alone(const BudgetScene& scene, const navigation::Scenario& scenario,
                                    const Source& source, MonteCarlo::Options options) {
  options = of_scene(scene, scenario, std::move(options));
  options.noisy_aid = source.aid;
  options.imu.gyro = options.imu.accelerometer = {};
  if (source.sensor)
    (source.sensor->carrier == navigation::Carrier::gyro ? options.imu.gyro
                                                         : options.imu.accelerometer) = {source.sensor->error};
  if (of_the_world(source)) options.world.push_back(source);
  options.filter.strapdown.earth_rate_in_attitude = source.name != kUncompensatedEarthRate;
  options.filter.covariance_interval = std::max(options.filter.covariance_interval, longest_step(scene.timeline));
  const InitialErrors initial = only(scene.initial, source.name);
  if (scene.self_alignment && (initial.level > 0 || (initial.heading > 0 && !scene.heading_sigma))) return std::nullopt;
  MonteCarlo::AidErrors aids;
  const auto& terms = source.model.terms;
  if (!terms.empty() && terms.front().carrier == navigation::Carrier::aid) aids = {source.model, source.initial, {}};
  aids.starts = scene.aids.starts;
  return monte_carlo(scene.timeline, scenario.sensor, initial, scene.C_enu, scene.design, aids, options);
}

}  // namespace gyrobudget::inline v0::budget
