// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/plan.h"

#include "gyrobudget/estimation/fit/information.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sensors.h"

namespace gyrobudget::fit {
namespace {

using noise::Term;

noise::ErrorModel mems() {
  const tests::Gyro gyro = tests::mems();
  return {.white = gyro.n, .bias_instability = gyro.b, .rate_random_walk = gyro.k, .rate_ramp = 1e-9};
}

TEST(Plan, TellsApartTheRandomTermsThatTheModelHas) {
  noise::ErrorModel model = mems();
  model.quantization = 1e-6;
  const Plan all = plan(model, {.duration_s = 3600});
  ASSERT_EQ(all.terms.size(), 4U);
  EXPECT_EQ(all.terms[0].term, Term::quantization);
  EXPECT_EQ(all.terms[3].term, Term::rate_random_walk);
  EXPECT_EQ(all.terms[3].value, model.rate_random_walk);
  model = {.white = 1e-4};
  EXPECT_EQ(plan(model).terms.size(), 1U);
}

TEST(Plan, ADurationBuysTheBound) {
  constexpr double kRate = 10, kDuration = 7200;
  const Plan answer = plan(mems(), {.rate_hz = kRate, .duration_s = kDuration});
  ASSERT_EQ(answer.rows.size(), 1U);
  EXPECT_TRUE(answer.answers.empty());
  const Eigen::VectorXd bound = relative_bound(planned_terms(mems()), 72'000, 1 / kRate);
  ASSERT_EQ(answer.rows.front().relative_std.size(), 3U);
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_EQ(answer.rows.front().relative_std[static_cast<std::size_t>(i)], bound(i));
  }
}

TEST(Plan, AWishIsGrantedByTheDurationThatItNames) {
  constexpr double kWish = 0.05;
  const Plan answer = plan(mems(), {.rate_hz = 1, .wishes = {{Term::flicker, kWish}}});
  EXPECT_TRUE(answer.rows.empty());
  ASSERT_EQ(answer.answers.size(), 1U);
  EXPECT_EQ(answer.answers.front().term, Term::flicker);
  const Plan back = plan(mems(), {.rate_hz = 1, .duration_s = answer.answers.front().duration_s});
  // duration_for solves to 1e-6 in ln(length), and whole samples round it by half of one; a bound goes with the length
  // to a power below 1.
  const double tolerance = 1e-6 * std::log(answer.answers.front().duration_s) + 1 / answer.answers.front().duration_s;
  EXPECT_NEAR(back.rows.front().relative_std[1] / kWish, 1, tolerance);
}

TEST(Plan, WithoutAQuestionThereAreRowsAndTenPercentOfEach) {
  const Plan answer = plan(mems());
  EXPECT_EQ(answer.rows.size(), 9U);
  EXPECT_EQ(answer.rows.front().duration_s, 1800);
  EXPECT_EQ(answer.rows.back().duration_s, 300 * 3600.0);
  ASSERT_EQ(answer.answers.size(), 3U);
  for (const auto& a : answer.answers) EXPECT_EQ(a.relative_std, 0.10);
}

TEST(Plan, RefusesWhatItCannotAnswer) {
  EXPECT_THROW((void)plan({}), std::invalid_argument);
  EXPECT_THROW((void)plan({.rate_ramp = 1e-9}), std::invalid_argument);
  EXPECT_THROW((void)plan(mems(), {.wishes = {{Term::quantization, 0.1}}}), std::invalid_argument);
  EXPECT_THROW((void)plan(mems(), {.wishes = {{Term::rate_ramp, 0.1}}}), std::invalid_argument);
  EXPECT_FALSE(can_plan(0.15, 100));
  EXPECT_TRUE(can_plan(0.16, 100));
  EXPECT_FALSE(can_plan(std::nan(""), 100));
  EXPECT_THROW((void)plan(mems(), {.rate_hz = 100, .duration_s = 0.15}), std::invalid_argument);
  EXPECT_THROW((void)plan(mems(), {.rate_hz = 100, .duration_s = 1.1e13}), std::invalid_argument);
}

// x and y are alike, z is better by 5 in its random walk: it needs another length, and all three the longest.
TEST(Plan, OfAxesThatDifferIsThatOfTheWorst) {
  noise::ErrorModel model = mems();
  model.rate_random_walk[2] /= 5;
  const PlanOptions options{.wishes = {{Term::rate_random_walk, 0.1}}};
  const AxesPlan both = plan_axes(model, options);
  ASSERT_EQ(both.parts.size(), 2U);
  EXPECT_EQ(both.parts[0].axes, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(both.parts[1].axes, (std::vector<std::size_t>{2}));
  const double x = plan(mems(), options).answers[0].duration_s, z = both.parts[1].plan.answers[0].duration_s;
  EXPECT_EQ(both.parts[0].plan.answers[0].duration_s, x);
  EXPECT_GT(z, x);
  ASSERT_EQ(both.all.answers.size(), 1U);
  EXPECT_EQ(both.all.answers[0].duration_s, z);
  // Alike axes have one plan, which is all.
  const AxesPlan alike = plan_axes(mems(), {.duration_s = 3600});
  ASSERT_EQ(alike.parts.size(), 1U);
  EXPECT_EQ(alike.all.rows[0].relative_std, plan(mems(), {.duration_s = 3600}).rows[0].relative_std);
  // An axis without the term that is wished for has no part in it; where none has it, that is an error.
  model.rate_random_walk[0] = model.rate_random_walk[1] = 0;
  EXPECT_EQ(plan_axes(model, options).parts.size(), 1U);
  EXPECT_THROW((void)plan_axes({.white = 1e-4}, options), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::fit
