// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/budget/error_budget.h"

#include "gyrobudget/estimation/budget/adjoint.h"
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/budget/sources.h"
#include "gyrobudget/estimation/navigation/sensor_states.h"
#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gyrobudget;  // NOLINT
using budget::Source;
using budget::Timeline;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::CoreMatrix;

namespace {

constexpr double kForce = 16;  // [m/s^2]

// Upwards with a constant specific force.
earth::Trajectory climb(double duration) {
  earth::Climb climb;
  climb.acceleration = kForce - earth::normal_gravity(earth::to_ecef(climb.site)).norm();
  climb.duration = duration;
  return earth::climb(climb);
}

Source source(const noise::SensorModel& sensor, const navigation::SensorStates::Options& options) {
  const auto states = sensor_states(sensor, options);
  return {.name = "test", .model = states.model, .initial = states.initial};
}

// East-north-up sigmas of one source at the end.
navigation::LocalSigmas at_end(const earth::Trajectory& path, const Source& source, double step) {
  const auto frame = earth::LocalFrame::east_north_up(earth::alcantara().position);
  Timeline::Options options;
  options.step = step;
  const auto budget = budget::error_budget(Timeline(path, {}, options), std::span(&source, 1));
  return navigation::local_sigmas(budget.total.back(), frame.C_el());
}

navigation::SensorStates::Options epoch_of(double length) {
  navigation::SensorStates::Options options;
  options.scene_length = length;
  return options;
}

}  // namespace

// Constant specific force along the vertical: each horizontal axis has f N sqrt(T^5/20), f K sqrt(T^7/252), f b T^3/6.
TEST(Budget, MeetsTheClosedFormsOfConstantForce) {
  constexpr double kScene = 10;  // [s]: what gravity's gradient adds is (T/800 s)^2/4, 4e-5; Earth's turn 7e-4/2
  constexpr double kPhysics = 4e-4;
  const auto path = climb(kScene);
  const struct {
    noise::PerAxis noise::ErrorModel::*coefficient;
    double expected;
  } cases[] = {{&noise::ErrorModel::white, kForce * std::sqrt(std::pow(kScene, 5) / 20)},
               {&noise::ErrorModel::rate_random_walk, kForce * std::sqrt(std::pow(kScene, 7) / 252)}};
  for (const auto& c : cases) {
    noise::SensorModel sensor;
    sensor.gyro.*c.coefficient = 1;
    const auto sigma = at_end(path, source(sensor, epoch_of(kScene)), 0.02);
    EXPECT_NEAR(sigma.position.x() / c.expected, 1, kPhysics);
    EXPECT_NEAR(sigma.position.y() / c.expected, 1, kPhysics);
  }
  noise::SensorModel biased;
  biased.gyro.turn_on_bias = 1;
  EXPECT_NEAR(at_end(path, source(biased, epoch_of(kScene)), 0.02).position.x(), kForce * std::pow(kScene, 3) / 6,
              kPhysics * kForce * std::pow(kScene, 3) / 6);
}

// Axes are independent: a triad whose axes differ has the sum of what each has alone, by states and by integrals.
TEST(Budget, OfAxesThatDifferIsTheSumOfThem) {
  constexpr double kSum = 1e-12;  // of the total: rounding of sums of thousands of terms
  const auto path = earth::ascent({});
  Timeline::Options options;
  options.step = 0.5;
  const Timeline timeline(path, {}, options);
  const auto gains = budget::frozen_gains(timeline, {});
  const auto backward = adjoint(timeline, gains, path.duration());
  noise::ErrorModel differ;
  differ.white = {1e-5, 3e-5, 0};
  differ.rate_random_walk = {1e-7, 0, 5e-7};
  differ.bias_instability = {0, 1e-6, 3e-6};
  auto states = epoch_of(83);
  states.flicker_states = 2;  // of each axis, whatever else it has
  const auto forward = [&](const noise::ErrorModel& gyro) {
    noise::SensorModel sensor;
    sensor.gyro = gyro;
    return CoreMatrix(budget::error_budget(timeline, std::vector{source(sensor, states)}, gains).total.back());
  };
  const auto exact = [&](const noise::ErrorModel& gyro) {
    CoreMatrix sum = CoreMatrix::Zero();
    for (const noise::TriadProcess& p : gyro.triad_processes())
      sum += process_response(backward, timeline, navigation::Carrier::gyro, p, {.powered_on_before = 60}, 0.01);
    return sum;
  };
  CoreMatrix by_states = CoreMatrix::Zero(), by_integrals = CoreMatrix::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    noise::ErrorModel one;
    for (const auto term : {noise::Term::white, noise::Term::flicker, noise::Term::rate_random_walk})
      one[term][axis] = differ[term][axis];
    by_states += forward(one);
    by_integrals += exact(one);
  }
  EXPECT_LT((by_states - forward(differ)).norm(), kSum * by_states.norm());
  EXPECT_LT((by_integrals - exact(differ)).norm(), kSum * by_integrals.norm());
}

// The error of a step falls with its square.
TEST(Budget, ConvergesWithTheSquareOfTheStep) {
  const auto path = earth::ascent({});
  noise::SensorModel sensor;
  sensor.gyro.white = 1e-5;
  sensor.gyro.rate_random_walk = 1e-7;
  const Source both = source(sensor, epoch_of(83));
  const double fine = at_end(path, both, 0.025).position.norm();
  const double error_1 = at_end(path, both, 1).position.norm() - fine;
  const double error_2 = at_end(path, both, 0.5).position.norm() - fine;
  EXPECT_NEAR(error_1 / error_2, 4, 0.3);
}

// --- With a filter ------------------------------------------------------------------------------------------------

namespace {

constexpr double kMicroG = 9.80665e-6;

noise::SensorModel tactical() {
  noise::SensorModel sensor;
  sensor.gyro.white = 0.1 * earth::kDegree / 60;
  sensor.gyro.rate_random_walk = 1e-7;
  sensor.gyro.turn_on_bias = 5 * earth::kDegree / 3600;
  sensor.gyro.scale_factor = 1e-4;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 5e-4;
  sensor.accelerometer->turn_on_bias = 1000 * kMicroG;
  return sensor;
}

CoreMatrix diagonal(double position, double velocity, double level, double heading, const Matrix3d& C_el) {
  CoreMatrix P = CoreMatrix::Zero();
  P.block<3, 3>(0, 0).diagonal().setConstant(position * position);
  P.block<3, 3>(3, 3).diagonal().setConstant(velocity * velocity);
  P.block<3, 3>(6, 6) =
      C_el * Vector3d(level * level, level * level, heading * heading).asDiagonal() * C_el.transpose();
  return P;
}

// A turning cruise with position and velocity each second but for an outage.
struct Aided {
  static constexpr double kDuration = 200;
  static constexpr double kPositionSigma = 3, kVelocitySigma = 0.1;
  Matrix3d C_el;
  Timeline timeline;
  navigation::SensorStates states;
  budget::Design design;
  std::vector<Source> sources;

  Aided() : C_el(local()), timeline(make_timeline()), states(sensor_states(tactical(), options())) {
    const CoreMatrix core = diagonal(10, 1, 1e-3, 1e-2, C_el);
    design = {states.model, navigation::initial_covariance(core, states.initial)};
    sources.push_back({.name = "initial", .initial = {}, .core = core});
    sources.push_back({.name = "white"});
    sources.back().model.gyro_white = states.model.gyro_white;
    sources.back().model.accelerometer_white = states.model.accelerometer_white;
    for (std::size_t k = 0; k < states.model.terms.size(); ++k) {
      sources.push_back({.name = name(states.model.terms[k])});
      sources.back().model.terms = {states.model.terms[k]};
      sources.back().initial = states.initial.block(static_cast<int>(k), static_cast<int>(k), 1, 1);
    }
    sources.push_back({.name = "aid.position", .aid = 0});
    sources.push_back({.name = "aid.velocity", .aid = 1});
    for (auto& source : sources) {
      const auto m = static_cast<Eigen::Index>(source.model.terms.size());
      if (source.initial.rows() != m) source.initial = navigation::StateMatrix::Zero(m, m);
    }
  }

 private:
  static navigation::SensorStates::Options options() {
    auto options = epoch_of(kDuration);
    options.gyro = navigation::Epoch{.powered_on_before = 600};
    return options;
  }
  static earth::Trajectory path() {
    earth::Cruise cruise;
    cruise.turn_acceleration = 4;
    cruise.duration = kDuration;
    return earth::cruise(cruise);
  }
  static Matrix3d local() { return earth::LocalFrame::east_north_up(earth::Cruise{}.start).C_el(); }
  [[nodiscard]] Timeline make_timeline() const {
    std::vector<navigation::PlannedFix> fixes;
    for (const double t : navigation::fix_times({1, kDuration, 1, {{100, 150}}})) {
      const auto truth = path().at(t);
      fixes.push_back({t, navigation::PositionFix{.p_eb_e = truth.pose.p_eb_e,
                                                  .sigma = Vector3d::Constant(kPositionSigma),
                                                  .axes = C_el,
                                                  .lever_arm = {1, 0.5, -0.3},
                                                  .aid = 0}});
      fixes.push_back({t, navigation::VelocityFix{.v_eb_e = truth.pose.v_eb_e,
                                                  .sigma = Vector3d::Constant(kVelocitySigma),
                                                  .axes = C_el,
                                                  .lever_arm = {1, 0.5, -0.3},
                                                  .aid = 1}});
    }
    Timeline::Options timeline_options;
    timeline_options.step = 0.25;
    timeline_options.report = {0, 50, 150};
    return {path(), fixes, timeline_options};
  }
};

// Largest difference of entries over the standard deviations of `scale`.
double difference(const CoreMatrix& a, const CoreMatrix& b, const CoreMatrix& scale) {
  const Eigen::VectorXd s = scale.diagonal().cwiseSqrt();
  double worst = 0;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) worst = std::max(worst, std::abs(a(i, j) - b(i, j)) / (s[i] * s[j]));
  return worst;
}

}  // namespace

// Where the truth is what the filter was designed for, the sources add up to what it claims, through gains, outage and
// lever arms; and no source alone shows its own claim.
TEST(Budget, SourcesAddUpToTheClaimOfARightFilter) {
  const Aided scene;
  const auto budget = budget::error_budget(scene.timeline, scene.sources, scene.design);
  ASSERT_EQ(budget.times.size(), 4u);
  constexpr double kRounding = 1e-8;  // of Joseph updates over 300 fixes
  for (std::size_t i = 0; i < budget.times.size(); ++i)
    EXPECT_LT(difference(budget.total[i], budget.claimed[i], budget.claimed[i]), kRounding) << budget.times[i];
}

// What is not in the design costs more than it claims: a gyro bias that is driven a hundred times harder.
TEST(Budget, ShowsWhatTheFilterDoesNotKnow) {
  const Aided scene;
  auto sources = scene.sources;
  for (auto& source : sources)
    for (auto& term : source.model.terms)
      if (term.carrier == navigation::Carrier::gyro && term.walk > 0) term.walk *= 100;
  const auto budget = budget::error_budget(scene.timeline, sources, scene.design);
  for (int i = 0; i < 9; ++i) EXPECT_GT(budget.total[2](i, i), 1.2 * budget.claimed[2](i, i)) << i;
}

// The backward pass finds the same for every source and time.
TEST(Budget, AgreesWithTheAdjoint) {
  const Aided scene;
  const auto gains = budget::frozen_gains(scene.timeline, scene.design);
  const auto budget = budget::error_budget(scene.timeline, scene.sources, gains);
  constexpr double kConstants = 1e-8;  // rounding
  constexpr double kProcesses = 2e-3;  // midpoints of steps of 0.25 s
  for (std::size_t i = 1; i < budget.times.size(); ++i) {
    const auto backward = adjoint(scene.timeline, gains, budget.times[i]);
    CoreMatrix walk_forward = CoreMatrix::Zero();
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
      Source source = scene.sources[s];
      const bool white = !source.model.gyro_white.isZero();
      CoreMatrix expected = budget.lines[s].covariance[i];
      if (white) {
        CoreMatrix ours = CoreMatrix::Zero();
        for (const auto carrier : {navigation::Carrier::gyro, navigation::Carrier::accelerometer}) {
          const auto& n =
              carrier == navigation::Carrier::gyro ? source.model.gyro_white : source.model.accelerometer_white;
          ours += process_response(backward, scene.timeline, carrier, {noise::White{n.x()}, 1}, {}, 0.01);
        }
        EXPECT_LT(difference(ours, expected, budget.total[i]), kConstants);
      } else if (!source.model.terms.empty() && source.model.terms[0].walk > 0) {
        walk_forward += expected;  // with the turn-on bias; one axis each
      } else {
        EXPECT_LT(difference(state_response(backward, scene.timeline, source), expected, budget.total[i]), kConstants)
            << source.name << " at " << budget.times[i];
      }
    }
    // Random walk and turn-on bias of all gyro axes together.
    CoreMatrix ours = process_response(backward, scene.timeline, navigation::Carrier::gyro,
                                       {noise::RateRandomWalk{tactical().gyro.rate_random_walk[0]}, 1},
                                       {.powered_on_before = 600}, 0.01);
    noise::SensorModel biased;
    biased.gyro.turn_on_bias = tactical().gyro.turn_on_bias;
    ours += state_response(backward, scene.timeline, source(biased, epoch_of(Aided::kDuration)));
    EXPECT_LT(difference(ours, walk_forward, budget.total[i]), kProcesses) << budget.times[i];
  }
}

// Flicker by three states against its exact structure function, unaided and through a filter that knows nothing of it.
TEST(Budget, HoldsFlickerByStatesAsByItsStructureFunction) {
  const auto path = earth::ascent({});
  Timeline::Options options;
  options.step = 0.5;
  const Timeline timeline(path, {}, options);
  const auto gains = budget::frozen_gains(timeline, {});
  const auto backward = adjoint(timeline, gains, path.duration());
  noise::SensorModel sensor;
  sensor.gyro.bias_instability = 1e-6;
  constexpr double kStates = 0.02;  // of the deviation; SensorStates has 0.012 at midpoints
  for (const navigation::Epoch epoch :
       {navigation::Epoch{}, navigation::Epoch{60}, navigation::Epoch{3600}, navigation::Epoch{0, 83}}) {
    auto states = epoch_of(83);
    states.flicker_states = 3;
    states.gyro = epoch;
    const auto forward = budget::error_budget(timeline, std::vector{source(sensor, states)}, gains).total.back();
    const auto exact =
        process_response(backward, timeline, navigation::Carrier::gyro, {noise::Flicker{1e-6}, 1}, epoch, 0.01);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(std::sqrt(forward(i, i) / exact(i, i)), 1, kStates) << i;
  }
}

// Levelled by the accelerometer that then errs: at rest the tilt cancels the bias, under thrust f only (1 - f/g) of it
// is left. 100 ug, 83 s of 16 m/s^2 upwards: b (1 - f/g) T^2/2 = 2.1 m, not the 6.5 m of independent errors.
TEST(Budget, ChargesTheTiltToTheAccelerometerThatLevelled) {
  constexpr double kScene = 83, kBias = 100 * kMicroG;
  const auto path = climb(kScene);
  const auto frame = earth::LocalFrame::east_north_up(earth::alcantara().position);
  const auto truth = path.at(0);
  std::vector<navigation::PlannedFix> fixes;
  for (const double t : navigation::fix_times({-60, 0, 1, {}}))
    fixes.push_back(
        {t, navigation::VelocityFix{.v_eb_e = Vector3d::Zero(), .sigma = Vector3d::Constant(1e-4), .aid = 0}});
  Timeline::Options options;
  options.step = 0.5;
  options.pad = 60;
  const Timeline timeline(path, fixes, options);

  noise::SensorModel sensor;
  sensor.accelerometer.emplace();
  sensor.accelerometer->turn_on_bias = kBias;
  const auto states = sensor_states(sensor, epoch_of(kScene));
  budget::Design design;
  design.model.gyro_white.setConstant(1e-7);
  design.model.accelerometer_white.setConstant(1e-5);
  design.initial = diagonal(1e-3, 1e-3, 0.1, 1e-3, frame.C_el());  // tilt unknown: levelling finds it

  const Source levelled{.name = "accelerometer.turn_on_bias", .model = states.model, .initial = states.initial};
  const auto budget = budget::error_budget(timeline, std::vector{levelled}, design);
  const auto sigma = navigation::local_sigmas(budget.total.back(), frame.C_el());
  const double g = earth::normal_gravity(truth.pose.p_eb_e).norm();
  const double expected = kBias * (kForce / g - 1) * kScene * kScene / 2;
  constexpr double kPhysics = 0.03;  // Earth's turn and gravity's gradient over 143 s
  EXPECT_NEAR(expected, 2.1, 0.05);
  EXPECT_NEAR(sigma.position.x() / expected, 1, kPhysics);
  EXPECT_NEAR(sigma.position.y() / expected, 1, kPhysics);
  EXPECT_NEAR(kBias * std::hypot(1, kForce / g) * kScene * kScene / 2, 6.5, 0.05);
}

// 83 s of ascent with perfect accelerometers and a perfect start.
TEST(Budget, FindsWhatAnAscentCosts) {
  const auto path = earth::ascent({});
  noise::SensorModel sensor;
  sensor.gyro.white = 5.4e-4 * earth::kDegree / 60;  // fibre-optic
  const double ifog = at_end(path, source(sensor, epoch_of(83)), 0.1).position.norm();
  EXPECT_GT(ifog, 0.045);  // independent checks on point-mass trajectories gave 0.05 to 0.06 m
  EXPECT_LT(ifog, 0.065);
  sensor.gyro.white = 0.15 * earth::kDegree / 60;  // MEMS
  const double mems = at_end(path, source(sensor, epoch_of(83)), 0.1).position.norm();
  EXPECT_NEAR(mems / ifog, 0.15 / 5.4e-4, 1e-6 * mems / ifog);
  noise::SensorModel biased;
  biased.gyro.turn_on_bias = 0.01 * earth::kDegree / 3600;
  EXPECT_NEAR(at_end(path, source(biased, epoch_of(83)), 0.1).position.norm() / ifog, 2, 0.3);
}

// Against a strapdown that leaves Earth's rate out: 0.347 degrees in all, and metres.
TEST(Budget, KnowsWhatEarthsRateCostsUncompensated) {
  const auto path = earth::ascent({});
  const auto truth = path.at(0);
  navigation::Strapdown::Options options;
  options.earth_rate_in_attitude = false;
  navigation::Strapdown navigator(truth.pose, options);
  constexpr double kStep = 0.01;
  for (int k = 0; k < 8300; ++k) navigator.step(path.increment(k * kStep, (k + 1) * kStep), kStep);
  const auto end = path.at(83);
  const Vector3d dp = end.pose.p_eb_e - navigator.state().p_eb_e;

  const auto frame = earth::LocalFrame::east_north_up(earth::alcantara().position);
  const auto sigma = at_end(path, budget::uncompensated_earth_rate(), 0.1);
  EXPECT_NEAR(sigma.attitude.norm() / earth::kDegree, 0.347, 0.001);
  constexpr double kSecondOrder = 0.01;  // half of 0.347 degrees is 3e-3
  const Vector3d expected = (frame.C_el().transpose() * dp).cwiseAbs();
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sigma.position[i], expected[i], kSecondOrder * expected.norm());
}

// A vertical error of gravity falls as a stone does, a deflection sideways.
TEST(Budget, KnowsWhatGravityCosts) {
  const auto path = climb(20);
  const auto vertical = at_end(path, budget::gravity_error(1e-3), 0.1).position;
  EXPECT_NEAR(vertical.z(), 1e-3 * 20 * 20 / 2, 1e-3 * 0.2);
  EXPECT_LT(vertical.head<2>().norm(), 1e-3 * vertical.z());
  const auto deflection = at_end(path, budget::deflection_of_the_vertical(1e-4), 0.1).position;
  EXPECT_NEAR(deflection.x(), 9.78e-4 * 20 * 20 / 2, 1e-3 * 0.2);
  EXPECT_NEAR(deflection.y(), deflection.x(), 1e-4 * deflection.x());
}

TEST(Budget, NamesTheLinesOfASensor) {
  noise::SensorModel sensor = tactical();
  sensor.gyro.bias_instability = 1e-6;
  sensor.gyro.quantization = 1e-6;
  sensor.accelerometer->misalignment = 1e-4;
  const auto [sources, left_out] = budget::sensor_sources(sensor, epoch_of(100));
  std::vector<std::string> names;
  for (const auto& source : sources) names.push_back(source.name);
  EXPECT_EQ(names, (std::vector<std::string>{"gyro.arw", "gyro.bias_instability", "gyro.rrw", "gyro.turn_on_bias",
                                             "gyro.scale_factor", "accelerometer.vrw", "accelerometer.turn_on_bias",
                                             "accelerometer.misalignment"}));
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(left_out[0].what, "gyro quantization");

  const Matrix3d C_el = earth::C_e_enu(0.3, 1);
  EXPECT_EQ(budget::initial_sources({.level = 1e-3}, C_el).size(), 1u);
  const CoreMatrix core = budget::initial_core({.position = {1, 2, 3}, .level = 1e-3, .heading = 1e-2}, C_el);
  const auto sigma = navigation::local_sigmas(core, C_el);
  EXPECT_NEAR(sigma.position.y(), 2, 1e-12);
  EXPECT_NEAR(sigma.attitude.z(), 1e-2, 1e-14);
}

TEST(Budget, RefusesWhatDoesNotFit) {
  const Aided scene;
  EXPECT_THROW((void)budget::error_budget(scene.timeline, scene.sources), std::invalid_argument);  // fixes, no filter
  auto sources = scene.sources;
  sources[0].initial = navigation::StateMatrix::Identity(2, 2);
  EXPECT_THROW((void)budget::error_budget(scene.timeline, sources, scene.design), std::invalid_argument);
  Timeline::Options options;
  options.step = 0;
  EXPECT_THROW(Timeline(climb(10), {}, options), std::invalid_argument);
  options.step = 1e-6;  // ten million steps
  EXPECT_THROW(Timeline(climb(10), {}, options), std::invalid_argument);
  options.step = 1;
  options.pad = 60;  // in flight
  EXPECT_THROW(Timeline(earth::cruise({.speed = 100, .duration = 10}), {}, options), std::invalid_argument);
  options.pad = 0;
  options.report = {11};
  EXPECT_THROW(Timeline(climb(10), {}, options), std::invalid_argument);
  const auto gains = budget::frozen_gains(scene.timeline, scene.design);
  EXPECT_THROW((void)adjoint(scene.timeline, gains, 0.1), std::invalid_argument);
}

// Zero velocity of a body that flies is no aid but a mistake.
TEST(BudgetScene, RefusesRestInFlight) {
  navigation::Scenario scene;
  navigation::Aid pad;
  pad.name = "pad.rest";
  pad.kind = navigation::Aid::Kind::rest;
  pad.sigma = Vector3d::Constant(1e-3);
  scene.aids = {pad};
  const auto path = earth::climb({.acceleration = 5, .duration = 10});
  EXPECT_THROW((void)budget::budget_scene(scene, path, {}), std::invalid_argument);
  EXPECT_EQ(budget::budget_scene(scene, earth::stand({.duration = 10}), {}).timeline.fixes().size(), 11U);
  scene.aids[0].valid.to = 0;
  EXPECT_EQ(budget::budget_scene(scene, path, {}).timeline.fixes().size(), 1U);
}

// As in a run: an outage has both its ends, and a start from an aid has all of the aid's errors.
TEST(BudgetScene, TakesAidsAsARunDoes) {
  navigation::Scenario scene;
  navigation::Aid gnss;
  gnss.name = "gnss.position";
  gnss.sigma = Vector3d::Constant(3);
  gnss.bias_sigma = Vector3d::Constant(4);
  gnss.outages = {{2, 5}};
  scene.aids = {gnss};
  scene.alignment.position = navigation::FromAid{0};
  const auto made = budget::budget_scene(scene, earth::stand({.duration = 10}), {});
  EXPECT_EQ(made.timeline.fixes().size(), 6U);  // 1, 6 ... 10 s: that at 0 is the start
  EXPECT_EQ(made.initial.position[0], 0);       // none of its own
  ASSERT_TRUE(made.design);
  const auto& P0 = made.design->initial;
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(P0(k, k), 25, 1e-12) << k;
  // All of the bias is in the start, with the other sign.
  EXPECT_NEAR(P0.topRightCorner(3, 3).squaredNorm(), 3 * 16. * 16, 1e-9);
}
