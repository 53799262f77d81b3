// SPDX-License-Identifier: MIT
// The budget in one call: what it asks of its parts, what it leaves out, what it says of limits and of its flights.
#include "gyrobudget/estimation/budget/study.h"

#include "gyrobudget/estimation/budget/scene_runs.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "../navigation/sensors.h"

namespace gyrobudget::budget {
namespace {

using Eigen::Vector3d;
using navigation::CoreMatrix;
using navigation::Scenario;

Scenario given_start() {
  Scenario scenario;
  scenario.sensor = tests::mems_imu();
  scenario.alignment.position_sigma = Vector3d(1, 1, 2);
  scenario.alignment.velocity_sigma = Vector3d::Constant(0.05);
  scenario.alignment.level_sigma = 1e-3;
  scenario.alignment.heading_sigma = 5e-3;
  return scenario;
}

earth::Trajectory short_turns() {
  return earth::cruise({.speed = 50, .turn_acceleration = 3, .turn_period = 40, .duration = 20});
}

double rss(const Study& study, const CoreMatrix& P) { return study.axes.position_sigma(P, Component::rss); }

std::vector<std::string> names(const Budget& budget) {
  std::vector<std::string> list;
  for (const auto& line : budget.lines) list.push_back(line.name);
  return list;
}

TEST(BudgetStudy, IsTheSumOfItsParts) {
  const Scenario scenario = given_start();
  const earth::Trajectory path = short_turns();
  const Study study = budget::study(scenario, path, {.tolerance = std::nullopt, .step = 0.5});
  BudgetQuestion question = question_of(scenario, 0.01);
  question.step = 0.5;
  question.at = {path.duration()};
  const BudgetScene scene = budget_scene(scenario, path, question);
  const Budget parts = error_budget(scene.timeline, scene.sources, scene.design);
  ASSERT_EQ(names(study.budget), names(parts));
  EXPECT_EQ(study.at, path.duration());
  EXPECT_EQ(study.budget.times, parts.times);
  EXPECT_EQ(study.total(), parts.total.back());
  for (std::size_t i = 0; i < parts.lines.size(); ++i) EXPECT_EQ(study.line(i), parts.lines[i].covariance.back());
  EXPECT_TRUE(study.left_out.empty());
  EXPECT_EQ(study.tolerance, 0);
  EXPECT_FALSE(study.aided);
  EXPECT_EQ(study.pad, 0);
  EXPECT_GT(study.flicker_states, 0);
  for (const bool there : {study.exact.has_value(), study.limit.has_value(), study.monte_carlo.has_value()})
    EXPECT_FALSE(there) << "nobody asked for it";
}

TEST(BudgetStudy, LeavesOutNoMoreThanTheToleranceOfATotal) {
  constexpr double kTolerance = 0.05;
  const Study all = study(given_start(), short_turns(), {.tolerance = std::nullopt});
  const Study some = study(given_start(), short_turns(), {.tolerance = kTolerance});
  ASSERT_FALSE(some.left_out.empty());
  EXPECT_EQ(some.left_out.size() + some.budget.lines.size(), all.budget.lines.size());
  EXPECT_GE(rss(some, some.total()), (1 - kTolerance) * rss(all, all.total()));
  EXPECT_LT(rss(some, some.total()), rss(all, all.total()));
  for (const Negligible& out : some.left_out) {
    EXPECT_FALSE(std::ranges::count(names(some.budget), out.name)) << out.name;
    EXPECT_LE(out.share, kTolerance * (2 - kTolerance)) << out.name;
  }
}

TEST(BudgetStudy, AnswersAtTheTimeThatIsAsked) {
  const Study early = study(given_start(), short_turns(), {.at = 7});
  EXPECT_EQ(early.at, 7);
  EXPECT_EQ(early.budget.times[early.at_index], 7);
  const Study late = study(given_start(), short_turns());
  EXPECT_LT(rss(early, early.total()), rss(late, late.total()));
  for (const double at : {-0.1, 20.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW((void)study(given_start(), short_turns(), {.at = at}), navigation::SetupError) << at;
  EXPECT_THROW((void)study(given_start(), short_turns(), {.runs = -1}), navigation::SetupError);
  EXPECT_THROW((void)study(given_start(), short_turns(), {.tolerance = 1}), navigation::SetupError);
}

TEST(BudgetStudy, AxesAreThoseOfTheSiteOrOfThePlaceReached) {
  Scenario scenario = given_start();
  const earth::Trajectory path = earth::cruise({.speed = 300, .duration = 3600});
  const auto up = [](const earth::Geodetic& at) { return earth::up_e(at.latitude, at.longitude); };
  const Study reached = study(scenario, path);
  EXPECT_LT((reached.axes.C_enu.col(2) - up(earth::to_geodetic(path.at(3600).pose.p_eb_e))).norm(), 1e-12);
  scenario.site = earth::Geodetic{0.1, 0.2, 0};
  const Study at_site = study(scenario, path);
  EXPECT_LT((at_site.axes.C_enu.col(2) - up(*scenario.site)).norm(), 1e-12);
  EXPECT_NEAR(rss(reached, reached.total()), rss(at_site, at_site.total()), 1e-9 * rss(at_site, at_site.total()));
}

TEST(BudgetStudy, ALimitIsOfAllSourcesAndItsFactorsReachIt) {
  const Study all = study(given_start(), short_turns(), {.tolerance = std::nullopt});
  const double limit = 2 * rss(all, all.total());
  const Study asked =
      study(given_start(), short_turns(), {.tolerance = 0.05, .limit = Options::Limit{Component::rss, limit}});
  ASSERT_TRUE(asked.limit);
  EXPECT_NEAR(asked.limit->found, rss(all, all.total()), 1e-12 * limit) << "what is left out counts too";
  EXPECT_TRUE(asked.limit->met());
  EXPECT_FALSE(asked.limit->alignment) << "the scene does not align itself";
  ASSERT_EQ(asked.limit->factors.size(), asked.budget.lines.size());
  for (std::size_t i = 0; i < asked.limit->factors.size(); ++i) {
    const double own = rss(asked, asked.line(i)), grown = asked.limit->factors[i] * own;
    EXPECT_NEAR(std::sqrt(asked.limit->found * asked.limit->found - own * own + grown * grown), limit, 1e-9 * limit);
  }
  const Study broken = study(given_start(), short_turns(), {.limit = Options::Limit{Component::rss, limit / 4}});
  EXPECT_FALSE(broken.limit->met());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE((Study::Limit{.limit = 1, .found = nan}).met()) << "a number that is none meets no limit";
}

TEST(BudgetStudy, ExactIntegralsStandBesideEachLine) {
  const Study study = budget::study(given_start(), short_turns(), {.exact = true});
  ASSERT_TRUE(study.exact);
  ASSERT_EQ(study.exact->size(), study.budget.lines.size());
  constexpr double kStates = 0.03;  // what Gauss-Markov states and steps of the covariance are off by
  for (std::size_t i = 0; i < study.exact->size(); ++i)
    EXPECT_NEAR(rss(study, (*study.exact)[i]), rss(study, study.line(i)), kStates * rss(study, study.line(i)))
        << study.budget.lines[i].name;
}

TEST(BudgetStudy, FlightsAreThoseOfTheWholeSceneAndOfEachSource) {
  const Options options{.tolerance = 0.05, .imu_interval = 0.05, .runs = 4, .each_source = true, .seed = 3};
  const Scenario scenario = given_start();
  const Study study = budget::study(scenario, short_turns(), options);
  ASSERT_TRUE(study.monte_carlo);
  EXPECT_EQ(study.monte_carlo->runs, 4);
  EXPECT_EQ(study.monte_carlo->seed, 3U);
  EXPECT_EQ(study.monte_carlo->points.size(), 4U);
  EXPECT_EQ(study.runs.asked, 4);
  EXPECT_EQ(study.runs.flown, 4);
  EXPECT_FALSE(study.stopped);
  ASSERT_EQ(study.monte_carlo->sources.size(), study.budget.lines.size());
  BudgetQuestion question = question_of(scenario, 0.05);
  question.at = {study.at};
  const BudgetScene scene = budget_scene(scenario, short_turns(), question);
  const MonteCarlo::Options asked{.runs = 4, .seed = 3, .imu_interval = 0.05};
  const MonteCarlo whole = fly(scene, scenario, asked);
  EXPECT_EQ(study.monte_carlo->covariance, whole.covariance(whole.times.size() - 1)) << "with what is left out";
  const auto source = std::ranges::find(scene.sources, study.budget.lines[0].name, &Source::name);
  const auto alone = fly_alone(scene, scenario, *source, asked);
  EXPECT_EQ(study.monte_carlo->sources[0]->covariance, alone->covariance(whole.times.size() - 1));
}

TEST(BudgetStudy, ProgressCountsAllRunsAndStopsThem) {
  std::vector<std::int64_t> seen;
  std::int64_t all = 0;
  Options options{.imu_interval = 0.1, .runs = 3, .each_source = true};
  options.progress = [&](std::int64_t done, std::int64_t of) {
    seen.push_back(done);
    all = of;
    return true;
  };
  const Study whole = study(given_start(), short_turns(), options);
  EXPECT_EQ(all, 3 * static_cast<std::int64_t>(1 + whole.budget.lines.size()));
  EXPECT_EQ(seen.back(), all);
  EXPECT_TRUE(std::ranges::is_sorted(seen));

  options.runs = 200;
  options.progress = [](std::int64_t, std::int64_t) { return false; };
  const Study stopped = study(given_start(), short_turns(), options);
  EXPECT_TRUE(stopped.stopped);
  EXPECT_FALSE(stopped.stopped_at);
  EXPECT_LT(stopped.runs.flown, stopped.runs.asked);
  ASSERT_TRUE(stopped.monte_carlo);
  for (const auto& source : stopped.monte_carlo->sources) EXPECT_FALSE(source) << "none was flown";

  options.progress = [](std::int64_t done, std::int64_t) { return done <= 200; };
  const Study in_the_first = study(given_start(), short_turns(), options);
  EXPECT_TRUE(in_the_first.stopped);
  EXPECT_EQ(in_the_first.stopped_at, 0U);
  EXPECT_EQ(in_the_first.monte_carlo->runs, 200);
}

TEST(BudgetStudy, WhatACallerThrowsPassesThrough) {
  class Mistake : public std::invalid_argument {
   public:
    using std::invalid_argument::invalid_argument;
  };
  Options options{.runs = 1};
  options.progress = [](std::int64_t, std::int64_t) -> bool { throw Mistake("of the caller"); };
  EXPECT_THROW((void)study(given_start(), short_turns(), options), Mistake);
}

TEST(BudgetStudy, SaysWhereTheCovarianceDoesNotHold) {
  const Study sound = study(given_start(), short_turns());
  EXPECT_FALSE(sound.large_attitude);
  EXPECT_TRUE(sound.out_of_range.empty());
  EXPECT_TRUE(sound.no_heading.empty());

  Scenario scenario = given_start();
  scenario.alignment.heading_sigma = 10 * earth::kDegree;
  scenario.sensor.accelerometer->range = 9;  // below gravity
  const Study wild = study(scenario, short_turns());
  ASSERT_TRUE(wild.large_attitude);
  EXPECT_EQ(wild.large_attitude->axis, 2);
  EXPECT_GE(wild.large_attitude->sigma, 10 * earth::kDegree * (1 - 1e-9));
  ASSERT_FALSE(wild.out_of_range.empty());
  const OutOfRange& cut = wild.out_of_range.back();
  EXPECT_EQ(cut.carrier, navigation::Carrier::accelerometer);
  EXPECT_EQ(cut.axis, 2);
  EXPECT_EQ(cut.from, 0);
  EXPECT_GT(cut.peak, 9.7);
  EXPECT_EQ(cut.range, 9);

  scenario = given_start();
  scenario.alignment.attitude = navigation::SelfAlignment{.duration = 60, .heading = std::nullopt};
  EXPECT_FALSE(study(scenario, earth::ascent({})).no_heading.empty());

  scenario = given_start();
  EXPECT_THROW((void)study(scenario, earth::stand({.duration = 1e6})), navigation::Diverged) << "heights grow e-fold";
}

TEST(BudgetComponents, ComponentsAreAxes) {
  LocalAxes axes;
  axes.C_launch << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // downrange to the north
  CoreMatrix P = CoreMatrix::Zero();
  P.diagonal().head<3>() << 9, 16, 144;
  const auto sigma = [&](Component component) { return axes.position_sigma(P, component); };
  EXPECT_DOUBLE_EQ(sigma(Component::east), 3);
  EXPECT_DOUBLE_EQ(sigma(Component::north), 4);
  EXPECT_DOUBLE_EQ(sigma(Component::up), 12);
  EXPECT_DOUBLE_EQ(sigma(Component::downrange), 4);
  EXPECT_DOUBLE_EQ(sigma(Component::crossrange), 3);
  EXPECT_DOUBLE_EQ(sigma(Component::horizontal), 5);
  EXPECT_DOUBLE_EQ(sigma(Component::rss), 13);
  EXPECT_EQ(to_string(Component::crossrange), "crossrange");
}

}  // namespace
}  // namespace gyrobudget::budget
