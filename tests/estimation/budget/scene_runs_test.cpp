// SPDX-License-Identifier: MIT
// Each source of a scene flown alone against its line of the budget.
#include "gyrobudget/estimation/budget/scene_runs.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "../navigation/sensors.h"

using namespace gyrobudget;  // NOLINT
using budget::BudgetQuestion;
using budget::BudgetScene;
using budget::MonteCarlo;
using Eigen::Vector3d;
using navigation::CoreMatrix;
using navigation::Scenario;
using tests::kMicroG;

namespace {

using Local = Eigen::Matrix<double, navigation::kCoreStates, 1>;

Local sigmas(const CoreMatrix& P, const Eigen::Matrix3d& C_el) {
  const auto s = navigation::local_sigmas(P, C_el);
  Local all;
  all << s.position, s.velocity, s.attitude;
  return all;
}

BudgetQuestion question(double interval) {
  BudgetQuestion q;
  q.growth_points = 0;
  q.imu_interval = interval;
  q.gravity = 20 * kMicroG;
  q.deflection = 2e-5;
  return q;
}

Scenario ascent(noise::SensorModel sensor, double level) {
  Scenario scenario;
  scenario.sensor = std::move(sensor);
  scenario.alignment.position_sigma = Vector3d(1, 1, 2);
  scenario.alignment.velocity_sigma = Vector3d::Constant(0.01);
  scenario.alignment.level_sigma = level;
  scenario.alignment.heading_sigma = level;
  return scenario;
}

// Axes on which a line is worth a ratio: a hundredth of the total's variance, and above what second order may add.
struct Compared {
  int axes = 0, lines = 0;
};

// Bands are of one alarm in a hundred seeds for a whole scene with its `ratios` at most.
Compared expect_each_source_right(const BudgetScene& scene, const Scenario& scenario, int runs, double interval,
                                  int ratios) {
  const auto budget = error_budget(scene.timeline, scene.sources, scene.design);
  const Local total = sigmas(budget.total.back(), scene.C_enu);
  const auto band = navigation::sigma_ratio_band(runs, 1 - 0.01 / ratios);
  MonteCarlo::Options options;
  options.runs = runs;
  options.imu_interval = interval;
  Compared compared;
  const auto compare = [&](const std::string& name, const CoreMatrix& P, const MonteCarlo& flown) {
    const Local linear = sigmas(P, scene.C_enu), found = sigmas(flown.covariance(0), scene.C_enu);
    const double second = std::sqrt(budget::second_order(P));
    const int before = compared.axes;
    for (Eigen::Index k = 0; k < linear.size(); ++k) {
      if (linear[k] < 0.1 * total[k] || linear[k] < second * linear.segment<3>(k - k % 3).norm()) continue;
      ++compared.axes;
      EXPECT_TRUE(band.holds(found[k] / linear[k])) << name << ", axis " << k << ": " << found[k] / linear[k];
    }
    if (compared.axes > before) ++compared.lines;
  };
  for (std::size_t i = 0; i < scene.sources.size(); ++i) {
    const auto flown = fly_alone(scene, scenario, scene.sources[i], options);
    EXPECT_TRUE(flown) << scene.sources[i].name;
    if (flown) compare(scene.sources[i].name, budget.lines[i].covariance.back(), *flown);
  }
  compare("total", budget.total.back(), fly(scene, scenario, options));
  EXPECT_LE(compared.axes, ratios);
  return compared;
}

}  // namespace

TEST(SceneRuns, EachSourceOfAFibreOpticAscentAloneAndTheTotal) {
  const Scenario scenario = ascent(tests::ifog_imu(), 5e-5);
  const BudgetScene scene = budget_scene(scenario, earth::ascent({}), question(0.08));
  const Compared compared = expect_each_source_right(scene, scenario, 300, 0.08, 100);
  EXPECT_GT(compared.axes, 40);
  EXPECT_GT(compared.lines, 8);
}

TEST(SceneRuns, EachSourceOfAMemsAscentAloneAndTheTotal) {
  const Scenario scenario = ascent(tests::mems_imu(), 3e-4);
  const BudgetScene scene = budget_scene(scenario, earth::ascent({}), question(0.08));
  const Compared compared = expect_each_source_right(scene, scenario, 300, 0.08, 100);
  EXPECT_GT(compared.axes, 40);
  EXPECT_GT(compared.lines, 8);
}

// The filter keeps the gains of the whole scene while its sources fly one by one, its aids' errors too.
TEST(SceneRuns, EachSourceOfAnAidedScene) {
  Scenario scenario = ascent(tests::mems_imu(), 3e-3);
  navigation::Aid gnss{.name = "gnss.position", .sigma = Vector3d::Constant(2)};
  gnss.correlated_sigma = Vector3d::Constant(1);
  gnss.correlation_time = 30;
  gnss.bias_sigma = Vector3d::Constant(0.5);
  gnss.outages = {{30, 45}};
  gnss.rate = 0.5;
  scenario.aids = {gnss,
                   {.name = "gnss.velocity",
                    .kind = navigation::Aid::Kind::velocity,
                    .sigma = Vector3d::Constant(0.1),
                    .rate = 0.5}};
  earth::Cruise turns;
  turns.speed = 50;
  turns.turn_acceleration = 3;
  turns.turn_period = 20;
  turns.duration = 45;
  const BudgetScene scene = budget_scene(scenario, earth::cruise(turns), question(0.1));
  const Compared compared = expect_each_source_right(scene, scenario, 150, 0.1, 140);
  EXPECT_GT(compared.axes, 40);
  EXPECT_GT(compared.lines, 8);
}

// Random numbers of a source are those it has beside the others: errors alone add up to the error of all, but for terms
// of second order.
TEST(SceneRuns, ErrorsOfSourcesAloneAddUpRunByRun) {
  const Scenario scenario = ascent(tests::ifog_imu(), 5e-5);
  BudgetScene scene = budget_scene(scenario, earth::ascent({}), question(0.05));
  std::erase_if(scene.sources, [](const auto& source) { return bool(source.shape); });  // theirs are of another order
  MonteCarlo::Options options;
  options.runs = 4;
  options.imu_interval = 0.05;
  scene.initial = {};
  const MonteCarlo all = fly(scene, scenario, options);
  Scenario ideal = scenario;
  ideal.sensor = {};
  const Local own = fly(scene, ideal, options).errors[0].back();  // of the strapdown at 20 Hz
  std::vector<Local> sum(4, own);
  for (const auto& source : scene.sources) {
    if (!source.sensor) continue;
    const auto flown = fly_alone(scene, scenario, source, options);
    for (std::size_t run = 0; run < sum.size(); ++run) sum[run] += flown->errors[run].back() - own;
  }
  constexpr double kSecondOrder = 1e-3;
  for (std::size_t run = 0; run < sum.size(); ++run)
    for (Eigen::Index k = 0; k < 9; k += 3) {
      const Vector3d whole = all.errors[run].back().segment<3>(k);
      EXPECT_LT((sum[run].segment<3>(k) - whole).norm(), kSecondOrder * whole.norm()) << run;
    }
}

TEST(SceneRuns, AnErrorThatIsNotRandomIsTheErrorItself) {
  Scenario scenario;
  BudgetQuestion q = question(0.02);
  q.earth_rate_compensated = false;
  q.gravity = q.deflection = 0;
  const BudgetScene scene = budget_scene(scenario, earth::ascent({}), q);
  const auto source = std::ranges::find(scene.sources, budget::kUncompensatedEarthRate, &budget::Source::name);
  ASSERT_NE(source, scene.sources.end());
  MonteCarlo::Options options;
  options.runs = 1;
  options.imu_interval = 0.02;
  const auto flown = fly_alone(scene, scenario, *source, options);
  const Local linear = sigmas(error_budget(scene.timeline, scene.sources).total.back(), scene.C_enu);
  const Local found = sigmas(flown->covariance(0), scene.C_enu);
  constexpr double kSecondOrder = 0.01;  // 0.35 deg
  for (Eigen::Index k = 0; k < 9; k += 3)
    EXPECT_NEAR(found.segment<3>(k).norm() / linear.segment<3>(k).norm(), 1, kSecondOrder) << k;
}

// Gyros that cannot find north leave a heading in the filter's P0 alone: no flight has it, unless one is given.
TEST(SceneRuns, AHeadingThatNothingGivesIsNotFlown) {
  Scenario scenario = ascent(tests::mems_imu(), 1e-3);
  MonteCarlo::Options options;
  options.runs = 1;
  options.imu_interval = 0.1;
  for (const bool given : {false, true}) {
    navigation::SelfAlignment alignment{.duration = 20};
    if (given) alignment.heading = 1.0;
    scenario.alignment.attitude = alignment;
    const BudgetScene scene = budget_scene(scenario, earth::ascent({}), question(0.1));
    int headings = 0;
    for (const auto& source : scene.sources) {
      const bool heading = source.name == "initial.heading";
      headings += heading;
      EXPECT_EQ(fly_alone(scene, scenario, source, options).has_value(), !heading || given) << source.name;
    }
    EXPECT_EQ(headings, 1) << given;
  }
}
