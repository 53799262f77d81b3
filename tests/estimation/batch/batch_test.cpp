// SPDX-License-Identifier: MIT
// Truth here: simulated flights, and the smoother where the problem is linear.
#include "gyrobudget/estimation/batch/batch.h"

#include "gyrobudget/vehicle/earth/attitude.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scene.h"

namespace gyrobudget::batch {
namespace {

using Eigen::Vector3d;

// Estimate less truth in east, north, up.
struct Error {
  Vector3d position, velocity, attitude;
};
Error error_of(const earth::Pose& estimate, const earth::Pose& truth) {
  const earth::Geodetic at = earth::to_geodetic(truth.p_eb_e);
  const Eigen::Matrix3d C_le = earth::C_e_enu(at.latitude, at.longitude).transpose();
  return {C_le * (estimate.p_eb_e - truth.p_eb_e), C_le * (estimate.v_eb_e - truth.v_eb_e),
          C_le * earth::log_rotation(estimate.q_eb * truth.q_eb.conjugate())};
}

// The largest component of an error in its own sigmas.
double in_sigmas(const Error& e, const navigation::Solution& s) {
  return std::max({e.position.cwiseQuotient(s.position_sigma).cwiseAbs().maxCoeff(),
                   e.velocity.cwiseQuotient(s.velocity_sigma).cwiseAbs().maxCoeff(),
                   e.attitude.cwiseQuotient(s.attitude_sigma).cwiseAbs().maxCoeff()});
}

double worst_in_sigmas(const std::vector<navigation::Solution>& solutions, const earth::Trajectory& truth) {
  double worst = 0;
  for (const auto& s : solutions) worst = std::max(worst, in_sigmas(error_of(s.state, truth.at(s.time).pose), s));
  return worst;
}

Estimate estimated(const tests::Scene& s, const Options& options = {}) {
  Estimate found = estimate(s.scenario, s.recording, options);
  EXPECT_EQ(found.status, Estimate::Status::estimated) << found.why;
  return found;
}

// Small errors: linear and Gaussian. The filter linearises about another path, which moves sigmas by a few percent.
TEST(Batch, EqualsTheSmootherWhereTheProblemIsLinear) {
  constexpr double kSame = 0.1;     // sigma
  constexpr double kSigmas = 0.05;  // relative
  tests::Scene s = tests::scene(20, 3);
  const Estimate batch = estimated(s);
  s.scenario.smooth = true;
  const navigation::Navigation smoothed = navigation::navigate(s.scenario, s.recording);
  ASSERT_EQ(batch.solutions.size(), smoothed.solutions.size());
  for (std::size_t k = 0; k < batch.solutions.size(); ++k) {
    const auto &ours = batch.solutions[k], &theirs = smoothed.solutions[k];
    EXPECT_DOUBLE_EQ(ours.time, theirs.time);
    EXPECT_LT(in_sigmas(error_of(ours.state, theirs.state), theirs), kSame) << "at " << ours.time;
    EXPECT_LT((ours.position_sigma.cwiseQuotient(theirs.position_sigma).array() - 1).abs().maxCoeff(), kSigmas);
    EXPECT_LT((ours.velocity_sigma.cwiseQuotient(theirs.velocity_sigma).array() - 1).abs().maxCoeff(), kSigmas);
    EXPECT_LT((ours.attitude_sigma.cwiseQuotient(theirs.attitude_sigma).array() - 1).abs().maxCoeff(), kSigmas);
    for (std::size_t i = 0; i < ours.terms.size(); ++i) {
      EXPECT_LT(std::abs(ours.terms[i] - theirs.terms[i]), kSame * theirs.term_sigmas[i]);
      EXPECT_NEAR(ours.term_sigmas[i] / theirs.term_sigmas[i], 1, kSigmas);
    }
  }
}

// A heading that is the wrong way: what the smoother holds of its linearisation is no answer, the batch's is.
TEST(Batch, FindsAHeadingThatTheStartHadWrong) {
  for (const double off : {80.0, 175.0}) {
    tests::Scene s = tests::scene(20, 5);
    auto& attitude = std::get<earth::Euler>(s.scenario.alignment.attitude);
    attitude.yaw += off * earth::kDegree;
    s.scenario.alignment.heading_sigma = 60 * earth::kDegree;
    const Estimate batch = estimated(s);
    s.scenario.smooth = true;
    const navigation::Navigation smoothed = navigation::navigate(s.scenario, s.recording);
    // 21 epochs of 9 components: 4.5 sigma has a false alarm of 1.3e-3.
    EXPECT_LT(worst_in_sigmas(batch.solutions, s.truth), 4.5) << off;
    EXPECT_GT(worst_in_sigmas(smoothed.solutions, s.truth), 4.5) << off << ": the smoother needs no batch here";
  }
}

TEST(Batch, FindsALeverArm) {
  const Vector3d arm(2, -1, 0.5);
  const tests::Scene s = tests::scene(20, 6, 1e-3, arm, 3);
  const Estimate batch = estimated(s);
  EXPECT_LT(worst_in_sigmas(batch.solutions, s.truth), 4.5);
  const auto& last = batch.solutions.back();
  int found = 0;
  for (std::size_t k = 0; k < batch.model.terms.size(); ++k) {
    if (batch.model.terms[k].effect != navigation::Effect::lever_arm) continue;
    ++found;
    EXPECT_LT(std::abs(last.terms[k] - arm[batch.model.terms[k].axis]), 4.5 * last.term_sigmas[k]);
    EXPECT_LT(last.term_sigmas[k], 2) << "nothing was learnt";
  }
  EXPECT_EQ(found, 3);
}

// Stamps that are 0.1 s late, on turns whose jerk of 3 m/s^2 over 10 s leaves 1e-3 m of that: nothing beside 0.5 m.
TEST(Batch, FindsADelay) {
  tests::Scene s = tests::scene(20, 8);
  for (navigation::Fix& fix : s.recording.fixes[0]) fix.stamp += 100'000'000;
  s.scenario.aids[0].time_tag_sigma = 0.3;
  const Estimate batch = estimated(s);
  EXPECT_LT(worst_in_sigmas(batch.solutions, s.truth), 4.5);
  ASSERT_EQ(batch.model.terms.back().effect, navigation::Effect::time_tag);
  const auto& last = batch.solutions.back();
  EXPECT_LT(std::abs(last.terms.back() + 0.1), 4.5 * last.term_sigmas.back());
  EXPECT_LT(last.term_sigmas.back(), 0.03) << "nothing was learnt";
}

// Every eighth fix 20 m off: squares follow them, Cauchy's loss names them and no others.
TEST(Batch, ARobustLossFindsOutliers) {
  tests::Scene s = tests::scene(20, 7);
  s.scenario.filter.gate_false_alarm = 0;  // the filter begins from them too
  auto& fixes = s.recording.fixes[0];
  for (std::size_t k = 4; k < fixes.size(); k += 8) fixes[k].value += Vector3d(20, -20, 20);
  EXPECT_GT(worst_in_sigmas(estimated(s).solutions, s.truth), 6);
  for (const Loss loss : {Loss::huber, Loss::cauchy}) {
    const Estimate batch = estimated(s, {.loss = loss, .scale = 2});
    for (std::size_t k = 0; k < batch.fixes.size(); ++k)
      EXPECT_EQ(batch.fixes[k].weight < 0.1, k % 8 == 4) << k << ", weight " << batch.fixes[k].weight;
    if (loss == Loss::cauchy) {
      EXPECT_LT(worst_in_sigmas(batch.solutions, s.truth), 4.5);
    }
  }
}

// Squared errors of independent runs over their sigmas: components are correlated within a run, so the test is on one
// of them at one time. Chi-square of as many degrees of freedom as runs, false alarm 1e-4 a component.
TEST(Batch, ErrorsAreAsLargeAsItsSigmas) {
  constexpr int kRuns = 24;
  constexpr double kLow = 6.4, kHigh = 58.6;  // chi-square of 24: 0.5e-4 and 1 - 0.5e-4
  std::array<double, 9> sum{};
  for (int run = 0; run < kRuns; ++run) {
    const tests::Scene s = tests::scene(6, static_cast<std::uint64_t>(100 + run));
    const auto& solution = estimated(s).solutions[3];
    const Error e = error_of(solution.state, s.truth.at(solution.time).pose);
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      sum[k] += std::pow(e.position[i] / solution.position_sigma[i], 2);
      sum[3 + k] += std::pow(e.velocity[i] / solution.velocity_sigma[i], 2);
      sum[6 + k] += std::pow(e.attitude[i] / solution.attitude_sigma[i], 2);
    }
  }
  for (const double chi_square : sum) {
    EXPECT_GT(chi_square, kLow);
    EXPECT_LT(chi_square, kHigh);
  }
}

TEST(Batch, GivesTheSameBytesAgain) {
  const tests::Scene s = tests::scene(4, 9);
  const Estimate one = estimated(s), two = estimated(s);
  EXPECT_EQ(one.cost, two.cost);
  for (std::size_t k = 0; k < one.solutions.size(); ++k) {
    EXPECT_EQ(one.solutions[k].state.p_eb_e, two.solutions[k].state.p_eb_e);
    EXPECT_EQ(one.solutions[k].position_sigma, two.solutions[k].position_sigma);
  }
}

TEST(Batch, RefusesOptionsOutOfRange) {
  const tests::Scene s = tests::scene(2, 1);
  EXPECT_THROW((void)estimate(s.scenario, s.recording, {.scale = 0}), navigation::SetupError);
  EXPECT_THROW((void)estimate(s.scenario, s.recording, {.longest_interval = 0}), navigation::SetupError);
  EXPECT_THROW((void)estimate(s.scenario, s.recording, {.longest_interval = 11}), navigation::SetupError);
  EXPECT_THROW((void)estimate(s.scenario, s.recording, {.longest_interval = 1e-6}), navigation::SetupError) << "nodes";
  EXPECT_THROW((void)estimate(s.scenario, s.recording, {.iterations = 0}), navigation::SetupError);
  EXPECT_THROW((void)estimate(s.scenario, s.recording, {.integrations = 0}), navigation::SetupError);
}

TEST(Batch, SaysWhereItHasNotSettled) {
  tests::Scene s = tests::scene(10, 5);
  std::get<earth::Euler>(s.scenario.alignment.attitude).yaw += 80 * earth::kDegree;
  s.scenario.alignment.heading_sigma = 60 * earth::kDegree;
  const Estimate found = estimate(s.scenario, s.recording, {.iterations = 1, .integrations = 1});
  EXPECT_EQ(found.status, Estimate::Status::not_converged);
  EXPECT_FALSE(found.why.empty());
}

TEST(Batch, NeedsAFilterToBeginFrom) {
  tests::Scene s = tests::scene(4, 5);
  s.scenario.alignment.position = navigation::FromAid{0};
  s.recording.fixes[0].clear();
  const Estimate found = estimate(s.scenario, s.recording);
  EXPECT_EQ(found.status, Estimate::Status::no_filter);
  EXPECT_FALSE(found.why.empty());
}

}  // namespace
}  // namespace gyrobudget::batch
