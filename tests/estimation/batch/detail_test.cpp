// SPDX-License-Identifier: MIT
// Truth here: differences of the functions themselves, integration anew, and the inverse of the whole matrix.
#include "gyrobudget/estimation/batch/detail/costs.h"
#include "gyrobudget/estimation/batch/detail/increment.h"
#include "gyrobudget/estimation/batch/detail/marginals.h"
#include "gyrobudget/vehicle/earth/attitude.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene.h"
#include <Eigen/LU>

namespace gyrobudget::batch::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using navigation::kCoreStates;

// Terms of each kind: a constant, a random walk, one that decays without noise, and aids'.
navigation::ErrorStateModel model() {
  using navigation::Carrier;
  using navigation::Effect;
  navigation::ErrorStateModel m;
  m.gyro_white.setConstant(1e-4);
  m.accelerometer_white.setConstant(1e-3);
  for (int axis = 0; axis < 3; ++axis) {
    m.terms.push_back({.carrier = Carrier::gyro, .effect = Effect::bias, .axis = axis, .walk = 1e-5});
    m.terms.push_back({.carrier = Carrier::accelerometer, .effect = Effect::scale_factor, .axis = axis});
    m.terms.push_back({.carrier = Carrier::aid, .effect = Effect::lever_arm, .axis = axis});
    m.terms.push_back(
        {.carrier = Carrier::aid, .effect = Effect::bias, .axis = axis, .correlation_time = 5, .walk = 1});
  }
  m.terms.push_back({.carrier = Carrier::accelerometer, .effect = Effect::bias, .axis = 1, .correlation_time = 7});
  m.terms.push_back({.carrier = Carrier::aid, .effect = Effect::time_tag});
  return m;
}

Node moved(Node node, const VectorXd& x) {
  node.pose.p_eb_e += x.segment<3>(0);
  node.pose.v_eb_e += x.segment<3>(3);
  node.pose.q_eb = earth::exp_rotation(x.segment<3>(6)) * node.pose.q_eb;
  node.chained += x.tail(node.chained.size());
  return node;
}

// Steps at which truncation and rounding of a central difference are alike; positions have 1e-9 m of rounding.
double step_of(int i) { return i < 3 ? 1.0 : i < 6 ? 0.1 : 1e-4; }

class BatchDetail : public testing::Test {
 protected:
  BatchDetail() : scene(tests::scene(2, 1)), layout(model()), global(VectorXd::Constant(layout.global_size(), 1e-4)) {
    for (const double t : {0.25, 0.9, 1.4}) {
      Node node{t, scene.truth.at(t).pose, VectorXd::Constant(static_cast<int>(layout.chained.size()), 2e-5)};
      nodes.push_back(node);
    }
    increments = Preintegrator(scene.recording, layout, {})(nodes, global);
  }

  // Positions are rounded at a nanometre, and what a cost makes of one over the step is the differences' rounding.
  static double rounding(const Linear& linear, double step) {
    return 2e-9 * linear.nodes[0].leftCols<3>().norm() / step;
  }
  // Every column of a cost's Jacobian against differences, relative to the column's largest entry.
  void expect_derivatives(const Cost& cost, const std::vector<Node>& at, double tolerance, double absolute = 1e-9,
                          bool core_alone = false) const {
    const Linear linear = cost.linearise(at, global);
    for (std::size_t k = 0; k < at.size(); ++k)
      for (int i = 0; i < (core_alone ? kCoreStates : layout.node_size()); ++i) {
        const VectorXd x = step_of(i) * VectorXd::Unit(layout.node_size(), i);
        std::vector<Node> plus = at, minus = at;
        plus[k] = moved(at[k], x);
        minus[k] = moved(at[k], -x);
        expect_column(
            linear.nodes[k].col(i), cost.linearise(plus, global).residual, cost.linearise(minus, global).residual,
            tolerance * linear.nodes[k].col(i).norm() + rounding(linear, step_of(i)) + absolute, step_of(i), i);
      }
    for (int i = 0; !core_alone && i < layout.global_size(); ++i) {
      const VectorXd x = 1e-4 * VectorXd::Unit(layout.global_size(), i);
      expect_column(linear.global.col(i), cost.linearise(at, global + x).residual,
                    cost.linearise(at, global - x).residual,
                    tolerance * linear.global.col(i).norm() + rounding(linear, 1e-4) + absolute, 1e-4, 100 + i);
    }
  }
  static void expect_column(const VectorXd& ours, const VectorXd& plus, const VectorXd& minus, double tolerance,
                            double step, int column) {
    const VectorXd truth = (plus - minus) / (2 * step);
    EXPECT_LE((ours - truth).norm(), tolerance)
        << "column " << column << "\nours  " << ours.transpose() << "\ntruth " << truth.transpose();
  }

  tests::Scene scene;
  Layout layout;
  VectorXd global;
  std::vector<Node> nodes;
  std::vector<Increment> increments;
};

// Carried to a start 23 m, 1.5 m/s and 0.6 rad away, an increment is what integrating from there gives, except for
// gravitation: on the way the paths part by 1.5 m/s and 6 m/s^2 over 0.65 s, and its gradient is 3.1e-6 /s^2.
TEST_F(BatchDetail, AnIncrementIsCarriedToAnotherStart) {
  VectorXd x = VectorXd::Zero(layout.node_size());
  x.head<kCoreStates>() << 20, -10, 5, 1, 0.5, -1, 0.3, -0.2, 0.5;
  std::vector<Node> elsewhere = nodes;
  elsewhere[0] = moved(nodes[0], x);
  const Increment anew = Preintegrator(scene.recording, layout, {})(elsewhere, global)[0];
  const VectorXd terms = terms_at(layout, nodes[0], global, nodes[0].time);
  const Prediction carried = predict(increments[0], elsewhere[0].pose, terms);
  constexpr double kVelocity = 3.1e-6 * (1.5 * 0.65 * 0.65 / 2 + 6 * 0.65 * 0.65 * 0.65 / 6);
  constexpr double kPosition = 0.65 * kVelocity, kAttitude = 1e-12;
  EXPECT_LT((carried.pose.p_eb_e - anew.to.p_eb_e).norm(), kPosition);
  EXPECT_LT((carried.pose.v_eb_e - anew.to.v_eb_e).norm(), kVelocity);
  EXPECT_LT(carried.pose.q_eb.angularDistance(anew.to.q_eb), kAttitude);
}

// Other values of the terms: right to first order, so a hundredth of the change leaves a ten-thousandth of the error.
TEST_F(BatchDetail, TermsChangeAnIncrementToFirstOrder) {
  double left[2];
  for (int i = 0; i < 2; ++i) {
    const double change = i == 0 ? 1e-2 : 1e-3;
    std::vector<Node> other = nodes;
    other[0].chained.array() += change;
    const VectorXd all = global.array() + change;
    const Increment anew = Preintegrator(scene.recording, layout, {})(other, all)[0];
    const Prediction first = predict(increments[0], nodes[0].pose, terms_at(layout, other[0], all, nodes[0].time));
    left[i] = (first.pose.p_eb_e - anew.to.p_eb_e).norm();
    EXPECT_LT(left[i], 0.1 * (first.pose.p_eb_e - increments[0].to.p_eb_e).norm());
  }
  EXPECT_LT(left[1], left[0] / 30) << "not of second order";
}

// Differences: truncation 1e-8 of curvature, and of the model's own Jacobian what error_state.h leaves out in dt^2.
TEST_F(BatchDetail, DerivativesOfIncrementsAreRight) {
  std::vector<Node> at{nodes[0], nodes[1]};
  at[1].pose = increments[0].to;
  VectorXd x = VectorXd::Zero(layout.node_size());
  x.head<kCoreStates>() << 1, -1, 1, 0.1, 0.2, -0.1, 0.2, -0.1, 0.15;
  at[0] = moved(at[0], x);
  expect_derivatives(*increment_cost(layout, 0, increments[0], nodes[0].time), at, 1e-6);
}

TEST_F(BatchDetail, DerivativesOfThePriorAreRight) {
  const int n = layout.model.states();
  const navigation::StateMatrix P0 = 0.01 * navigation::StateMatrix::Identity(n, n);
  Node at = nodes[0];
  at.pose.q_eb = earth::exp_rotation({0.2, 0.1, -0.3}) * at.pose.q_eb;
  expect_derivatives(*prior_cost(layout, nodes[0].pose, P0), {at}, 1e-6);
}

// aiding.h leaves out how axes of a fix turn with the place, speed/R/sigma, and of attitudes half the residual. With a
// time tag of 0.2 s that is so for what moves in it, but the sensor's terms are taken at the fix.
TEST_F(BatchDetail, DerivativesOfFixesAreRight) {
  using Kind = navigation::Aid::Kind;
  for (const Kind kind : {Kind::position, Kind::velocity, Kind::height, Kind::attitude, Kind::rest}) {
    navigation::Aid aid;
    aid.kind = kind;
    aid.sigma.setConstant(0.1);
    aid.lever_arm = {1, -2, 0.5};
    navigation::Fix fix;
    const earth::TrajectoryPoint truth = scene.truth.at(0.9);
    const earth::Geodetic place = earth::to_geodetic(truth.pose.p_eb_e);
    const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
    if (kind == Kind::position) fix.value = truth.pose.p_eb_e;
    if (kind == Kind::velocity) fix.value = C_en.transpose() * truth.pose.v_eb_e;
    if (kind == Kind::height) fix.value[0] = place.height;
    fix.q_nb = Eigen::Quaterniond(C_en).conjugate() * truth.pose.q_eb;
    SCOPED_TRACE(navigation::name(kind));
    constexpr double kModel = 2e-3, kPlace = 30 / 6.4e6 / 0.1 * 2;
    const auto cost = fix_cost(layout, 1, increments[0].end, aid, 0, fix, nodes[0].time);
    const int tag = layout.global_size() - 1;  // the model's last term
    global[tag] = 0;
    expect_derivatives(*cost, {nodes[1]}, kModel, kPlace);
    if (kind == Kind::attitude) continue;  // residuals of 0.2 s of turning are not small
    global[tag] = 0.2;
    expect_derivatives(*cost, {nodes[1]}, kModel, 10 * kPlace, true);
  }
}

// A clock that two aids share moves the fixes of the second as those of the first.
TEST_F(BatchDetail, ASharedClockIsTheSecondAidsToo) {
  layout.model.terms.back().aids = 2;
  const int tag = layout.global_size() - 1;
  global.setZero();
  global[tag] = 0.2;
  Node node = nodes[1];
  node.chained.setZero();  // some of them are the first aid's alone
  navigation::Aid aid;
  aid.kind = navigation::Aid::Kind::velocity;
  const navigation::Fix fix{.value = {20, 5, 0}};
  const auto of = [&](int number) {
    return fix_cost(layout, 1, increments[0].end, aid, number, fix, nodes[0].time)->linearise({node}, global);
  };
  const Linear first = of(0), second = of(1), other = of(2);
  EXPECT_EQ(second.residual, first.residual);
  EXPECT_EQ(second.global.col(tag), first.global.col(tag));
  EXPECT_GT(second.global.col(tag).norm(), 0.1);
  EXPECT_EQ(other.global.col(tag).norm(), 0);
}

TEST(BatchMarginals, AreBlocksOfTheInverse) {
  constexpr int kNodes = 6, kSize = 4, kShared = 3, kAll = kNodes * kSize + kShared;
  // Rows that touch two neighbours and the shared, as costs do, on scales far apart.
  std::srand(7);
  Information information(kNodes, kSize, kShared);
  MatrixXd H = MatrixXd::Zero(kAll, kAll);
  for (int k = 0; k + 1 < kNodes; ++k) {
    MatrixXd J = MatrixXd::Random(3 * kSize, 2 * kSize + kShared);
    J.rightCols(kShared) *= 1e4;
    const MatrixXd JJ = J.transpose() * J;
    const auto i = static_cast<std::size_t>(k);
    information.own[i] += JJ.topLeftCorner(kSize, kSize);
    information.own[i + 1] += JJ.block(kSize, kSize, kSize, kSize);
    information.next[i] += JJ.block(0, kSize, kSize, kSize);
    information.shared[i] += JJ.block(0, 2 * kSize, kSize, kShared);
    information.shared[i + 1] += JJ.block(kSize, 2 * kSize, kSize, kShared);
    information.among_shared += JJ.bottomRightCorner(kShared, kShared);
    H.block(k * kSize, k * kSize, 2 * kSize, 2 * kSize) += JJ.topLeftCorner(2 * kSize, 2 * kSize);
    H.block(k * kSize, kAll - kShared, 2 * kSize, kShared) += JJ.topRightCorner(2 * kSize, kShared);
    H.block(kAll - kShared, k * kSize, kShared, 2 * kSize) += JJ.bottomLeftCorner(kShared, 2 * kSize);
    H.bottomRightCorner(kShared, kShared) += JJ.bottomRightCorner(kShared, kShared);
  }
  const MatrixXd inverse = H.inverse();
  const auto ours = marginals(information);
  ASSERT_EQ(ours.size(), std::size_t{kNodes});
  constexpr double kRounding = 1e-10;  // a condition of some 1e3 once scaled
  for (int k = 0; k < kNodes; ++k) {
    MatrixXd truth(kSize + kShared, kSize + kShared);
    truth << inverse.block(k * kSize, k * kSize, kSize, kSize),
        inverse.block(k * kSize, kAll - kShared, kSize, kShared),
        inverse.block(kAll - kShared, k * kSize, kShared, kSize), inverse.bottomRightCorner(kShared, kShared);
    EXPECT_LT((ours[static_cast<std::size_t>(k)] - truth).norm(), kRounding * truth.norm());
  }
}

TEST(BatchMarginals, WhatIsNotKnownHasNoCovariance) {
  Information information(2, 1, 0);
  information.own[0](0, 0) = information.own[1](0, 0) = 1;
  information.next[0](0, 0) = -1;  // a difference alone
  EXPECT_TRUE(marginals(information).empty());
}

TEST(BatchWhitening, MakesACovarianceTheUnit) {
  const MatrixXd root = MatrixXd::Random(5, 5) + 2 * MatrixXd::Identity(5, 5);
  const Eigen::VectorXd units = (Eigen::VectorXd(5) << 1e-6, 1, 1e4, 1e-9, 1).finished();
  const MatrixXd P = units.asDiagonal() * root * root.transpose() * units.asDiagonal();
  const MatrixXd W = whitening(P);
  EXPECT_LT((W * P * W.transpose() - MatrixXd::Identity(5, 5)).norm(), 1e-11);
}

}  // namespace
}  // namespace gyrobudget::batch::detail
