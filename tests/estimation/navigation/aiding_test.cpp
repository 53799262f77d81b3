// SPDX-License-Identifier: MIT
// Truth here: what each aid measures as a function of the whole state, written out and differentiated
// numerically.
#include "gyrobudget/estimation/navigation/aiding.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

using namespace gyrobudget;  // NOLINT
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::Carrier;
using navigation::Effect;
using navigation::kAttitude;
using navigation::kCoreStates;
using navigation::kVelocity;
using navigation::Measurement;
using navigation::StateVector;

namespace {

constexpr int kAid = 3;
constexpr double kEps = std::numeric_limits<double>::epsilon();

// A body on its way, with terms of the gyro, of this aid and of another.
struct World {
  earth::Motion motion{.pose = {.p_eb_e = earth::to_ecef({0.7, 2.1, 3000}),
                                .v_eb_e = {120, -200, 90},
                                .q_eb = earth::exp_rotation({0.4, -1.1, 2.0})},
                       .a_eb_e = {3, -2, 1},
                       .w_eb_b = {0.3, -0.2, 0.5}};
  StateVector terms;
};

navigation::ErrorStateModel model() {
  navigation::ErrorStateModel m;
  const auto add = [&](Carrier carrier, Effect effect, int axis, int aid) {
    navigation::ErrorTerm t;
    t.carrier = carrier;
    t.effect = effect;
    t.axis = axis;
    t.aid = aid;
    m.terms.push_back(t);
  };
  for (int i = 0; i < 3; ++i) add(Carrier::gyro, Effect::bias, i, 0);
  for (const int aid : {kAid, kAid + 1}) {
    for (int i = 0; i < 3; ++i) add(Carrier::aid, Effect::bias, i, aid);
    for (int i = 0; i < 3; ++i) add(Carrier::aid, Effect::lever_arm, i, aid);
    add(Carrier::aid, Effect::time_tag, 0, aid);
  }
  add(Carrier::accelerometer, Effect::bias, 0, 0);
  return m;
}
constexpr int kBias = 3, kArm = 6, kTag = 9;  // of kAid among the terms

World moved(World world, int state, double by) {
  StateVector x = StateVector::Zero(kCoreStates + world.terms.size());
  x[state] = by;
  world.motion.pose.p_eb_e += x.segment<3>(0);
  world.motion.pose.v_eb_e += x.segment<3>(kVelocity);
  world.motion.pose.q_eb = earth::exp_rotation(x.segment<3>(kAttitude)) * world.motion.pose.q_eb;
  world.terms += x.tail(world.terms.size());
  world.motion.w_eb_b -= x.segment<3>(kCoreStates);  // more bias in what is measured, less true rate
  return world;
}

// The pose that an aid late by the time tag sees.
World later(World world) {
  const double t = world.terms[kTag];
  world.motion.pose.p_eb_e += t * world.motion.pose.v_eb_e + t * t / 2 * world.motion.a_eb_e;
  world.motion.pose.v_eb_e += t * world.motion.a_eb_e;
  world.motion.pose.q_eb = world.motion.pose.q_eb * earth::exp_rotation(t * world.motion.w_eb_b);
  return world;
}

using Measure = std::function<Measurement(const World& truth, const navigation::Estimate&)>;

double perturbation(int state) { return state < kVelocity ? 10 : state < kAttitude ? 1 : 1e-4; }

// Columns of H against central differences of the residual, at a world whose terms are known exactly but not
// zero. `scale` is the size of what is measured, of which differences are rounded; `curvature` that of its
// third derivative by angle or time, unity within a perturbation of 1e-4.
void expect_rows(const Measure& measure, double scale, double curvature, std::initializer_list<int> exempt = {}) {
  const auto m = model();
  World world;
  world.terms = StateVector::Zero(static_cast<Eigen::Index>(m.terms.size()));
  for (int k = 0; k < 3; ++k) {
    world.terms[kBias + k] = 0.01 * (k + 1);
    world.terms[kArm + k] = 0;
  }
  navigation::Estimate estimate{.motion = world.motion, .model = &m, .terms = world.terms.data()};
  const Measurement at_truth = measure(world, estimate);
  for (int i = 0; i < at_truth.rows; ++i) EXPECT_NEAR(at_truth.residual[i], 0, 4 * kEps * scale);
  for (int j = 0; j < m.states(); ++j) {
    if (std::find(exempt.begin(), exempt.end(), j) != exempt.end()) continue;
    const double e = perturbation(j);
    const Vector3d column =
        (measure(moved(world, j, e), estimate).residual - measure(moved(world, j, -e), estimate).residual) / (2 * e);
    for (int i = 0; i < at_truth.rows; ++i)
      EXPECT_NEAR(at_truth.row[static_cast<std::size_t>(i)].h[j], column[i],
                  4 * kEps * scale / e + curvature * 1e-8 + (j < kVelocity ? 1e-11 : 0))
          << "row " << i << " state " << j;
  }
}

const Vector3d kLeverArm{2, -1, 0.5};
const Matrix3d kAxes = earth::C_e_enu(0.7, 2.1);
const Vector3d kSigma{1, 2, 3};

Vector3d arm(const World& world) { return kLeverArm + world.terms.segment<3>(kArm); }

}  // namespace

TEST(Aiding, PositionRowsAreDerivatives) {
  expect_rows(
      [](const World& truth, const navigation::Estimate& estimate) {
        const World seen = later(truth);
        return measure(navigation::PositionFix{seen.motion.pose.p_eb_e + seen.motion.pose.q_eb * arm(truth) +
                                                   kAxes * truth.terms.segment<3>(kBias),
                                               kSigma, kAxes, kLeverArm, kAid},
                       estimate);
      },
      6.4e6, 10);
}

TEST(Aiding, VelocityRowsAreDerivatives) {
  expect_rows(
      [](const World& truth, const navigation::Estimate& estimate) {
        // Late by t, the antenna's swing about the IMU also turns: left out of the column, so held here.
        const World seen = later(truth);
        return measure(navigation::VelocityFix{seen.motion.pose.v_eb_e +
                                                   truth.motion.pose.q_eb * truth.motion.w_eb_b.cross(arm(truth)) +
                                                   kAxes * truth.terms.segment<3>(kBias),
                                               kSigma, kAxes, kLeverArm, kAid},
                       estimate);
      },
      300, 10);
}

TEST(Aiding, HeightRowsAreDerivatives) {
  expect_rows(
      [](const World& truth, const navigation::Estimate& estimate) {
        return measure(
            navigation::HeightFix{earth::to_geodetic(later(truth).motion.pose.p_eb_e).height + truth.terms[kBias], 2,
                                  kAid},
            estimate);
      },
      6.4e6, 10, {kCoreStates + kBias + 1, kCoreStates + kBias + 2});  // a height has one bias, axis 0
}

TEST(Aiding, AttitudeRowsAreDerivatives) {
  expect_rows(
      [](const World& truth, const navigation::Estimate& estimate) {
        // Small known mounting errors turn the rest by themselves: of second order, so none here.
        const World seen = later(truth);
        World at = truth;
        const Vector3d mounting = at.terms.segment<3>(kBias) - Vector3d(0.01, 0.02, 0.03);
        Measurement m = measure(
            navigation::AttitudeFix{seen.motion.pose.q_eb * earth::exp_rotation(mounting), {1e-3, 2e-3, 3e-3}, kAid},
            estimate);
        m.residual += Vector3d(0.01, 0.02, 0.03);
        return m;
      },
      4, 10);
}

TEST(Aiding, VariancesAreThoseOfTheFix) {
  const auto m = model();
  const StateVector terms = StateVector::Zero(static_cast<Eigen::Index>(m.terms.size()));
  const World world;
  const navigation::Estimate estimate{.motion = world.motion, .model = &m, .terms = terms.data()};
  const auto position = measure(navigation::PositionFix{world.motion.pose.p_eb_e, kSigma, kAxes}, estimate);
  const auto attitude = measure(navigation::AttitudeFix{world.motion.pose.q_eb, kSigma}, estimate);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(position.row[i].variance, kSigma[static_cast<int>(i)] * kSigma[static_cast<int>(i)]);
    EXPECT_EQ(attitude.row[i].variance, kSigma[static_cast<int>(i)] * kSigma[static_cast<int>(i)]);
  }
  EXPECT_EQ(measure(navigation::HeightFix{3000, 2}, estimate).row[0].variance, 4);
  // An aid without number has no terms
  EXPECT_EQ(position.row[0].h.tail(terms.size()).norm(), 0);
}

TEST(Aiding, RefusesASigmaThatIsNone) {
  const auto m = model();
  const StateVector terms = StateVector::Zero(static_cast<Eigen::Index>(m.terms.size()));
  const World world;
  const navigation::Estimate estimate{.motion = world.motion, .model = &m, .terms = terms.data()};
  for (const double bad :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const Vector3d sigma{1, bad, 1};
    EXPECT_THROW((void)measure(navigation::PositionFix{world.motion.pose.p_eb_e, sigma}, estimate),
                 std::invalid_argument);
    EXPECT_THROW((void)measure(navigation::VelocityFix{world.motion.pose.v_eb_e, sigma}, estimate),
                 std::invalid_argument);
    EXPECT_THROW((void)measure(navigation::AttitudeFix{world.motion.pose.q_eb, sigma}, estimate),
                 std::invalid_argument);
    EXPECT_THROW((void)measure(navigation::HeightFix{0, bad}, estimate), std::invalid_argument);
  }
}
