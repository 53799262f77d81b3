// SPDX-License-Identifier: MIT
// Scenes to budgets: what is left out, what a source may grow to, self-alignment, aids, and scenes at the edges.
#include "gyrobudget/estimation/budget/scene.h"

#include "gyrobudget/estimation/budget/scene_runs.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../navigation/sensors.h"

using namespace gyrobudget;  // NOLINT
using budget::Budget;
using budget::BudgetQuestion;
using budget::BudgetScene;
using budget::Source;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::Aid;
using navigation::CoreMatrix;
using navigation::Scenario;

namespace {

using tests::kDegreePerHour;
using tests::kMicroG;

Scenario given_start() {
  Scenario scenario;
  scenario.sensor = tests::mems_imu();
  scenario.alignment.position_sigma = Vector3d(1, 1, 2);
  scenario.alignment.velocity_sigma = Vector3d::Constant(0.05);
  scenario.alignment.level_sigma = 1e-3;
  scenario.alignment.heading_sigma = 5e-3;
  return scenario;
}

Aid aid(Aid::Kind kind, double sigma, double rate) {
  Aid made;
  made.name = "gnss." + std::string(navigation::name(kind));
  made.kind = kind;
  made.sigma = Vector3d::Constant(sigma);
  made.rate = rate;
  return made;
}

earth::Trajectory turns(double duration) {
  earth::Cruise cruise;
  cruise.speed = 50;
  cruise.turn_acceleration = 3;
  cruise.turn_period = 40;
  cruise.duration = duration;
  return earth::cruise(cruise);
}

BudgetQuestion quick(double step) {
  BudgetQuestion question;
  question.step = step;
  question.growth_points = 0;
  return question;
}

// Root sums of squares of position, velocity and attitude.
Vector3d sigmas(const CoreMatrix& P) {
  return {std::sqrt(P.block<3, 3>(0, 0).trace()), std::sqrt(P.block<3, 3>(3, 3).trace()),
          std::sqrt(P.block<3, 3>(6, 6).trace())};
}

Budget budget_of(const BudgetScene& scene) { return budget::error_budget(scene.timeline, scene.sources, scene.design); }

// --- Random scenes ------------------------------------------------------------------------------------------------

class RandomScene {
 public:
  explicit RandomScene(std::uint64_t seed) : random_(seed) {}

  double between(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  // 0 in one of four, else over `decades` around `middle`.
  double any(double middle, double decades) {
    return between(0, 1) < 0.25 ? 0 : middle * std::pow(10, between(-decades / 2, decades / 2));
  }

  earth::Trajectory path() {
    const double duration = std::pow(10, between(0, 2));
    switch (static_cast<int>(between(0, 4))) {
      case 0: {
        earth::Stand stand;
        stand.spin = Vector3d(between(-1, 1), between(-1, 1), between(-1, 1));
        stand.duration = duration;
        return earth::stand(stand);
      }
      case 1: {
        earth::Climb climb;
        climb.acceleration = between(0, 50);
        climb.duration = duration;
        return earth::climb(climb);
      }
      default:
        return turns(duration);
    }
  }

  Scenario scenario(double duration) {
    Scenario made;
    noise::SensorModel& s = made.sensor;
    errors(s.gyro, 1e-5);
    s.gyro.g_sensitivity = any(1e-7, 6);
    s.accelerometer.emplace();
    errors(*s.accelerometer, 1e-3);
    made.alignment.position_sigma = Vector3d::Constant(any(1, 6));
    made.alignment.velocity_sigma = Vector3d::Constant(any(0.1, 6));
    made.alignment.level_sigma = any(1e-4, 6);
    made.alignment.heading_sigma = any(1e-3, 6);
    made.states.flicker_states = 1;
    if (between(0, 1) < 0.1) {
      made.aids.push_back(aid(Aid::Kind::position, 2, 3 / duration));
      made.aids.back().correlated_sigma = Vector3d::Constant(any(1, 4));
      made.alignment.level_sigma = 1e-3;
      made.alignment.position_sigma = Vector3d::Ones();
    }
    return made;
  }

 private:
  void errors(noise::ErrorModel& e, double size) {
    e.white = any(size, 6);
    if (between(0, 1) < 0.3) e.bias_instability = any(size, 6);  // its states take 2 ms to fit
    e.rate_random_walk = any(size / 100, 6);
    e.turn_on_bias = any(size, 6);
    e.scale_factor = any(1e-4, 6);
    e.misalignment = any(1e-4, 6);
    if (between(0, 1) < 0.5) e.powered_on_before = std::pow(10, between(0, 4));
  }
  std::mt19937_64 random_;
};

}  // namespace

// The bound is exact, so a scene that breaks it is a defect, not bad luck.
TEST(SceneBudget, WhatIsLeftOutStaysInsideItsBoundInAThousandScenes) {
  constexpr int kScenes = 1000;
  constexpr double kRounding = 1e-7;  // of a sigma, through Joseph updates
  int left_out_at_all = 0, near_the_bound = 0;
  for (int i = 0; i < kScenes; ++i) {
    RandomScene random(static_cast<std::uint64_t>(i));
    const earth::Trajectory path = random.path();
    const Scenario scenario = random.scenario(path.duration());
    BudgetScene scene = budget::budget_scene(scenario, path, quick(path.duration() / 3));
    const auto gains = budget::frozen_gains(scene.timeline, scene.design);
    const Budget all = budget::error_budget(scene.timeline, scene.sources, gains);
    const double tolerance = std::pow(10, random.between(-4, -0.5));
    const double end = path.duration();
    const auto left_out = leave_out(scene, gains, std::span(&end, 1), tolerance);
    const Vector3d with = sigmas(all.total.back());
    const Vector3d without = sigmas(budget::error_budget(scene.timeline, scene.sources, gains).total.back());
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(with[k] - without[k], (tolerance + kRounding) * with[k]) << "scene " << i << ", total " << k;
      if (with[k] - without[k] > tolerance * with[k] / 10) ++near_the_bound;
    }
    for (const auto& one : left_out) {
      const auto line = std::ranges::find(all.lines, one.name, &Budget::Contribution::name);
      ASSERT_NE(line, all.lines.end());
      EXPECT_LE(sigmas(line->covariance.back())[0], one.position * (1 + kRounding) + kRounding * with[0])
          << "scene " << i << ", " << one.name;
    }
    if (!left_out.empty()) ++left_out_at_all;
  }
  EXPECT_GT(left_out_at_all, kScenes / 2);  // else nothing was tested
  EXPECT_GT(near_the_bound, kScenes / 10);
}

// One source that holds everything, passed through at once.
TEST(SceneBudget, IndependentSourcesAreTheirRootSumSquare) {
  const BudgetScene scene = budget::budget_scene(given_start(), earth::ascent({}), quick(1));
  Source all;
  for (const Source& one : scene.sources) {
    all.model.gyro_white += one.model.gyro_white;
    all.model.accelerometer_white += one.model.accelerometer_white;
    const auto old = static_cast<Eigen::Index>(all.model.terms.size());
    all.model.terms.insert(all.model.terms.end(), one.model.terms.begin(), one.model.terms.end());
    const auto m = static_cast<Eigen::Index>(all.model.terms.size());
    navigation::StateMatrix P = navigation::StateMatrix::Zero(m, m);
    P.topLeftCorner(old, old) = all.initial;
    P.bottomRightCorner(m - old, m - old) = one.initial;
    all.initial = P;
    all.core += one.core;
  }
  const CoreMatrix together = budget::error_budget(scene.timeline, std::span(&all, 1)).total.back();
  const CoreMatrix apart = budget_of(scene).total.back();
  ASSERT_GE(scene.sources.size(), 12u);
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(std::sqrt(together(i, i) / apart(i, i)), 1, 1e-9) << i;
}

TEST(SceneBudget, SharesSumToOneAndAFactorMeetsTheLimit) {
  const BudgetScene scene = budget::budget_scene(given_start(), earth::ascent({}), quick(2));
  const Budget budget = budget_of(scene);
  const std::size_t end = budget.times.size() - 1;
  double sum = 0;
  for (const double share : shares(budget, end)) sum += share;
  EXPECT_NEAR(sum, 1, 1e-12);

  const Eigen::Matrix<double, 3, Eigen::Dynamic> crossrange = scene.C_launch.col(1);
  const auto along = [&](const CoreMatrix& P) {
    return std::sqrt((crossrange.transpose() * P.block<3, 3>(0, 0) * crossrange).trace());
  };
  for (const double of_total : {0.95, 1.5}) {
    const double limit = of_total * along(budget.total[end]);
    int finite = 0;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
      const double factor = allowed_factor(budget, end, scene.sources[s].name, crossrange, limit);
      if (factor == 0 || factor > 1e6) continue;
      ++finite;
      auto scaled = scene.sources;
      scaled[s].core *= factor * factor;
      scaled[s].initial *= factor * factor;
      scaled[s].model.gyro_white *= factor;
      scaled[s].model.accelerometer_white *= factor;
      for (auto& term : scaled[s].model.terms) term.walk *= factor;
      EXPECT_NEAR(along(budget::error_budget(scene.timeline, scaled).total[end]) / limit, 1, 1e-9)
          << scene.sources[s].name << " x " << factor;
    }
    EXPECT_GE(finite, 1);
  }
  EXPECT_EQ(allowed_factor(budget, end, "initial.heading", crossrange, 1e-9), 0);
  EXPECT_THROW((void)allowed_factor(budget, end, "gyro.no_such", crossrange, 1), std::invalid_argument);
}

// --- With a filter ------------------------------------------------------------------------------------------------

namespace {

Scenario outage(double until) {
  Scenario scenario = given_start();
  scenario.aids = {aid(Aid::Kind::position, 2, 1), aid(Aid::Kind::velocity, 0.1, 1)};
  for (Aid& one : scenario.aids) one.outages = {{until / 2, 3 * until / 4}};
  return scenario;
}

budget::MonteCarlo fly(const BudgetScene& scene, const Scenario& scenario, int runs) {
  budget::MonteCarlo::Options options;
  options.runs = runs;
  options.imu_interval = 0.02;
  return budget::fly(scene, scenario, options);
}

// Nine ratios and a NEES at 1e-4 each: one alarm in a thousand seeds.
void expect_agreement(const BudgetScene& scene, const budget::MonteCarlo& flown, std::size_t i) {
  constexpr double kRight = 1 - 1e-4;
  const Budget budget = budget_of(scene);
  const auto band = navigation::sigma_ratio_band(flown.runs, kRight);
  const auto found = navigation::local_sigmas(flown.covariance(i), scene.C_enu);
  const auto linear = navigation::local_sigmas(budget.total[i], scene.C_enu);
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(band.holds(found.position[k] / linear.position[k])) << found.position[k] / linear.position[k];
    EXPECT_TRUE(band.holds(found.velocity[k] / linear.velocity[k])) << found.velocity[k] / linear.velocity[k];
    EXPECT_TRUE(band.holds(found.attitude[k] / linear.attitude[k])) << found.attitude[k] / linear.attitude[k];
  }
  const auto nees = flown.nees(i, budget.total[i], scene.C_enu);
  EXPECT_GE(nees.dof, 6);
  EXPECT_TRUE(navigation::chi_square_mean_band(nees.dof, flown.runs, kRight).holds(nees.mean)) << nees.mean;
}

}  // namespace

// A filter that is run again for each source alone is tuned to it, and what it then claims adds up to nothing.
TEST(SceneBudget, FrozenSourcesAddUpWhereRetunedOnesDoNot) {
  const BudgetScene scene = budget::budget_scene(outage(120), turns(120), quick(0.5));
  const auto gains = budget::frozen_gains(scene.timeline, scene.design);
  const Budget frozen = budget::error_budget(scene.timeline, scene.sources, gains);
  CoreMatrix retuned = CoreMatrix::Zero();
  for (const Source& one : scene.sources) {
    if (one.aid >= 0) continue;  // their noise is in each of the others
    const auto m = static_cast<Eigen::Index>(one.model.terms.size());
    const budget::Design alone{
        one.model, navigation::initial_covariance(one.core, m > 0 ? one.initial : navigation::StateMatrix::Zero(0, 0))};
    retuned += budget::frozen_gains(scene.timeline, alone).claimed.back();
  }
  const CoreMatrix& claimed = gains.claimed.back();
  constexpr double kSame = 0.01;  // 1/f has the states of each source's own file, and those of the joint design
  const Vector3d whole = sigmas(claimed), sum = sigmas(frozen.total.back()), wrong = sigmas(retuned);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(sum[k] / whole[k], 1, kSame) << k;
    EXPECT_GT(std::abs(wrong[k] / whole[k] - 1), 0.05) << k;
  }
}

TEST(SceneBudget, AidsWithAnOutageAgreeWithMonteCarlo) {
  const Scenario scenario = outage(80);
  BudgetQuestion question = quick(0.5);
  question.at = {60};  // the end of the outage
  const BudgetScene scene = budget::budget_scene(scenario, turns(80), question);
  const auto flown = fly(scene, scenario, 60);
  ASSERT_EQ(flown.times, (std::vector<double>{60, 80}));
  for (std::size_t i = 0; i < 2; ++i) expect_agreement(scene, flown, i);
}

// Position and velocity of the start are the first fix: with its bias, which the next fixes have too, and never lose.
TEST(SceneBudget, AStartFromGnssIsOneErrorWithItsBias) {
  Scenario scenario = given_start();
  scenario.aids = {aid(Aid::Kind::position, 0.5, 1), aid(Aid::Kind::velocity, 0.1, 1)};
  scenario.aids[0].bias_sigma = Vector3d::Constant(3);
  scenario.aids[0].correlated_sigma = Vector3d::Constant(1);
  scenario.aids[0].lever_arm = Vector3d(0.3, 0, -1);
  scenario.alignment.position = navigation::FromAid{0};
  scenario.alignment.velocity = navigation::FromAid{1};
  scenario.alignment.position_sigma.reset();
  scenario.alignment.velocity_sigma.reset();
  BudgetQuestion question = quick(0.5);
  question.at = {0};
  const BudgetScene scene = budget::budget_scene(scenario, turns(60), question);
  const Budget budget = budget_of(scene);
  const auto position = [&](std::string_view source, std::size_t i) {
    const auto line = std::ranges::find(budget.lines, source, &Budget::Contribution::name);
    return line == budget.lines.end() ? -1 : sigmas(line->covariance.at(i))[0];
  };
  EXPECT_EQ(position("initial.position", 0), -1);
  EXPECT_NEAR(position("aid.gnss.position", 0), 0.5 * std::sqrt(3), 1e-9);
  constexpr double kBias = 3 * 1.7320508;
  for (const std::size_t i : {0u, 1u}) EXPECT_NEAR(position("aid.gnss.position.bias", i) / kBias, 1, 1e-5) << i;
  // Not at all what two errors of 3 m would make, as the filter of a start that is none of the aid's has it.
  for (const std::size_t i : {0u, 1u})
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(sigmas(budget.claimed[i])[k] / sigmas(budget.total[i])[k], 1, 0.02) << i << k;
  const auto gains = budget::frozen_gains(scene.timeline, scene.design);
  const auto back = adjoint(scene.timeline, gains, 60);
  for (const auto& source : scene.sources) {
    const auto line = std::ranges::find(budget.lines, source.name, &Budget::Contribution::name);
    const double forward = sigmas(line->covariance.back())[0];
    EXPECT_NEAR(sigmas(state_response(back, scene.timeline, source))[0], forward, 1e-6 * forward + 1e-9) << source.name;
  }
  const auto flown = fly(scene, scenario, 100);
  for (std::size_t i = 0; i < 2; ++i) expect_agreement(scene, flown, i);
  Scenario late = scenario;
  late.aids[0].valid.from = 5;
  EXPECT_THROW((void)budget::budget_scene(late, turns(60), question), std::invalid_argument);
}

// An accelerometer that levels and then errs cancels itself at rest; the budget charges it with both.
TEST(SceneBudget, ASelfAlignedSceneChargesTheSensorAndAgreesWithMonteCarlo) {
  Scenario scenario;
  scenario.site = earth::alcantara().position;
  scenario.sensor.gyro.white = 0.001 * earth::kDegree / 60;
  scenario.sensor.gyro.turn_on_bias = 0.01 * kDegreePerHour;
  scenario.sensor.accelerometer.emplace();
  scenario.sensor.accelerometer->white = 5e-5;
  scenario.sensor.accelerometer->turn_on_bias = 100 * kMicroG;
  scenario.alignment.attitude = navigation::SelfAlignment{.duration = 60, .heading = std::nullopt};
  earth::Climb climb;
  climb.acceleration = 16 - 9.78;
  climb.duration = 40;
  const BudgetScene scene = budget::budget_scene(scenario, earth::climb(climb), quick(1));
  ASSERT_TRUE(scene.self_alignment);
  ASSERT_TRUE(scene.design);
  const Budget budget = budget_of(scene);
  const auto line = std::ranges::find(budget.lines, "accelerometer.turn_on_bias", &Budget::Contribution::name);
  ASSERT_NE(line, budget.lines.end());
  const double g = 9.78, expected = 100 * kMicroG * (16 / g - 1) * 40 * 40 / 2;  // b (f/g - 1) T^2/2
  const auto sigma = navigation::local_sigmas(line->covariance.back(), scene.C_enu);
  constexpr double kPhysics = 0.05;  // Earth's turn, gravity's gradient, and what is left of the coarse start
  EXPECT_NEAR(sigma.position.x() / expected, 1, kPhysics);
  expect_agreement(scene, fly(scene, scenario, 60), 0);
}

// --- Edges --------------------------------------------------------------------------------------------------------

namespace {

void expect_sane(const BudgetScene& scene, std::size_t most_steps) {
  const Budget budget = budget_of(scene);
  EXPECT_LE(budget.steps, most_steps);
  for (const CoreMatrix& P : budget.total) {
    EXPECT_TRUE(P.allFinite());
    EXPECT_GE(P.diagonal().minCoeff(), 0);
  }
  for (const auto& line : budget.lines) EXPECT_TRUE(line.covariance.back().allFinite()) << line.name;
  EXPECT_GT(budget.total.back()(0, 0), 0);
}

}  // namespace

// Each source by itself is what it is beside one 20 decades larger.
TEST(SceneBudget, TwentyDecadesInOneBudget) {
  Scenario scenario;
  scenario.sensor.gyro.white = 1e-16;
  scenario.sensor.gyro.turn_on_bias = 1e-6;
  scenario.alignment.position_sigma = Vector3d::Constant(1e10);
  scenario.alignment.level_sigma = 1e-14;
  const BudgetScene both = budget::budget_scene(scenario, earth::ascent({}), quick(1));
  const Budget large = budget_of(both);
  Scenario alone;
  alone.sensor.gyro.white = 1e-16;
  const Budget small = budget_of(budget::budget_scene(alone, earth::ascent({}), quick(1)));
  const auto line = std::ranges::find(large.lines, "gyro.arw", &Budget::Contribution::name);
  ASSERT_NE(line, large.lines.end());
  EXPECT_EQ(line->covariance.back(), small.lines.at(0).covariance.back());
  EXPECT_GT(sigmas(large.total.back())[0] / sigmas(line->covariance.back())[0], 1e20);
  expect_sane(both, 100);
}

TEST(SceneBudget, ASecondAndAHundredHours) {
  earth::Stand stand;
  stand.duration = 1;
  expect_sane(budget::budget_scene(given_start(), earth::stand(stand), {}), 300);
  // The vertical channel needs a height, else it grows by e in 570 s.
  Scenario scenario = given_start();
  scenario.aids = {aid(Aid::Kind::height, 10, 1.0 / 300)};
  earth::Cruise cruise;
  cruise.duration = 100 * 3600;
  expect_sane(budget::budget_scene(scenario, earth::cruise(cruise), {}), 5000);
}

TEST(SceneBudget, OverThePoleAtFiftyGAndSpinning) {
  earth::Cruise over;
  over.start = {89.9 * earth::kDegree, 0, 10000};
  over.azimuth = 0;
  over.duration = 200;
  expect_sane(budget::budget_scene(given_start(), earth::cruise(over), {}), 500);
  earth::Climb fast;
  fast.acceleration = 49 * 9.80665;
  fast.duration = 30;
  expect_sane(budget::budget_scene(given_start(), earth::climb(fast), {}), 500);
  earth::Stand spinning;
  spinning.spin = Vector3d(2 * M_PI * 5, 0, 0);
  spinning.duration = 60;
  // A constant error across the spin axis averages out, so the step must follow the turn.
  const BudgetScene scene = budget::budget_scene(given_start(), earth::stand(spinning), {});
  expect_sane(scene, 5000);
  const Budget coarse = budget_of(scene);
  const Budget fine = budget_of(budget::budget_scene(given_start(), earth::stand(spinning), quick(0.002)));
  constexpr double kSame = 0.02;
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sigmas(coarse.total.back())[k] / sigmas(fine.total.back())[k], 1, kSame) << k;
}

// By then no number holds the vertical channel of an unaided navigator.
TEST(SceneBudget, RefusesWhatGrowsBeyondAllNumbers) {
  earth::Cruise cruise;
  cruise.duration = 100 * 3600;
  BudgetScene scene = budget::budget_scene(given_start(), earth::cruise(cruise), {});
  const auto gains = budget::frozen_gains(scene.timeline, scene.design);
  const std::size_t sources = scene.sources.size();
  EXPECT_TRUE(leave_out(scene, gains, std::span(&cruise.duration, 1), 0.01).empty());
  EXPECT_EQ(scene.sources.size(), sources);
  EXPECT_THROW((void)budget::error_budget(scene.timeline, scene.sources, gains), std::invalid_argument);
}

// Thirty years at rest: said at once, not after all steps of all sources.
TEST(SceneBudget, RefusesThirtyYearsAtOnceAndMoreSamplesThanCount) {
  earth::Stand stand;
  stand.duration = 1e9;
  EXPECT_THROW((void)budget::budget_scene(given_start(), earth::stand(stand), {}), std::invalid_argument);
  stand.duration = 1e7;
  Scenario aided = given_start();
  aided.aids = {aid(Aid::Kind::height, 10, 1)};
  EXPECT_THROW((void)budget::budget_scene(aided, earth::stand(stand), {}), std::invalid_argument);  // 1e7 fixes
  stand.duration = 10;
  const BudgetScene scene = budget::budget_scene(given_start(), earth::stand(stand), quick(1));
  const auto back = adjoint(scene.timeline, budget::frozen_gains(scene.timeline, scene.design), 10);
  EXPECT_THROW(
      (void)process_response(back, scene.timeline, navigation::Carrier::gyro, {noise::Flicker{1e-6}, 1}, {}, 1e-18),
      std::invalid_argument);
}

TEST(SceneBudget, SaysWhereTheHeadingIsNotObservable) {
  Scenario scenario;
  scenario.sensor = tests::mems_imu();
  scenario.alignment.attitude = navigation::SelfAlignment{.duration = 60, .heading = std::nullopt};
  const BudgetScene scene = budget::budget_scene(scenario, earth::ascent({}), quick(1));
  EXPECT_NE(scene.no_heading.find("heading"), std::string::npos) << scene.no_heading;
}
