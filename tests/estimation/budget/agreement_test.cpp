// SPDX-License-Identifier: MIT
// What flights say of a covariance, by hand-made studies.
#include "gyrobudget/estimation/budget/agreement.h"

#include "gyrobudget/estimation/budget/sources.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrobudget::budget {
namespace {

using navigation::CoreMatrix;

constexpr int kRuns = 1000;

// Sigmas of position, velocity and attitude, the same on each axis.
CoreMatrix diagonal(double position, double velocity, double attitude) {
  CoreMatrix P = CoreMatrix::Zero();
  P.diagonal().head<3>().setConstant(position * position);
  P.diagonal().segment<3>(3).setConstant(velocity * velocity);
  P.diagonal().tail<3>().setConstant(attitude * attitude);
  return P;
}

// One source that is the total, and flights that found just that.
Study in_agreement() {
  Study study;
  const CoreMatrix P = diagonal(3, 0.3, 1e-3);
  study.budget.times = {0};
  study.budget.lines = {{"gyro.arw", {P}}};
  study.budget.total = {P};
  study.monte_carlo = Study::Flown{.runs = kRuns, .covariance = P, .nees = {.mean = 9, .dof = 9, .left_out = {}}};
  study.monte_carlo->sources = {Study::Flown::Alone{kRuns, P}};
  return study;
}

TEST(Agreement, WhatIsRightIsNotContradicted) {
  const Study study = in_agreement();
  const Agreement total = total_agreement(study);
  for (const auto& axis : total.axes) {
    EXPECT_TRUE(total.compares(axis));
    EXPECT_DOUBLE_EQ(axis.ratio(), 1);
  }
  const AllRatios all = all_ratios(study);
  EXPECT_EQ(all.compared, 18);  // of the source and of the total
  EXPECT_EQ(all.outside, 0);
  EXPECT_TRUE(all.far.empty());
  EXPECT_LT(all.together.lower, all.band.lower);
  EXPECT_GT(all.together.upper, all.band.upper);
  EXPECT_TRUE(contradictions(study).empty());
  EXPECT_TRUE(nees_band(study).holds(9));
}

TEST(Agreement, AnAxisThatIsFoundElsewhereIsNamed) {
  for (const double factor : {1.3, 0.7}) {
    Study study = in_agreement();
    study.monte_carlo->covariance(5, 5) *= factor * factor;  // of the velocity, up
    const auto list = contradictions(study);
    ASSERT_EQ(list.size(), 1U) << factor;
    EXPECT_EQ(list[0].axis, 5U);
    EXPECT_DOUBLE_EQ(list[0].expected, 0.3);
    EXPECT_DOUBLE_EQ(list[0].found, 0.3 * factor);
    const AllRatios all = all_ratios(study);
    EXPECT_EQ(all.outside, 1);
    ASSERT_EQ(all.far.size(), 1U);
    EXPECT_FALSE(all.far[0].line) << "the total";
    EXPECT_EQ(all.far[0].axis, 5U);
    EXPECT_DOUBLE_EQ(all.far[0].ratio, factor);
  }
}

// Of a million runs 1.05 is far beyond chance, and no matter.
TEST(Agreement, LessThanATenthIsNoContradiction) {
  Study study = in_agreement();
  study.monte_carlo->runs = 1'000'000;
  study.monte_carlo->covariance *= 1.05 * 1.05;
  EXPECT_EQ(all_ratios(study).far.size(), 9U);
  EXPECT_TRUE(contradictions(study).empty());
}

TEST(Agreement, NeesContradictsByItself) {
  Study study = in_agreement();
  study.monte_carlo->nees.mean = 9 * 1.3 * 1.3;
  const auto list = contradictions(study);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_FALSE(list[0].axis);
  EXPECT_DOUBLE_EQ(list[0].found, 9 * 1.3 * 1.3);
  EXPECT_EQ(list[0].expected, 9);
  study.monte_carlo->nees.dof = 0;  // no direction has an error of first order
  EXPECT_TRUE(contradictions(study).empty());
}

TEST(Agreement, SourcesAreNamedByTheirLine) {
  Study study = in_agreement();
  study.monte_carlo->sources[0]->covariance(0, 0) *= 4;
  const AllRatios all = all_ratios(study);
  ASSERT_EQ(all.far.size(), 1U);
  EXPECT_EQ(all.far[0].line, 0U);
  EXPECT_EQ(all.far[0].axis, 0U);
  study.budget.lines[0].name = kUncompensatedEarthRate;  // the same in every run: no chi-square
  EXPECT_FALSE(source_agreements(study)[0]->random);
  EXPECT_EQ(all_ratios(study).compared, 9);
  study.monte_carlo->sources[0].reset();
  EXPECT_FALSE(source_agreements(study)[0]);
}

TEST(Agreement, WhatIsSmallOrOfSecondOrderIsNotCompared) {
  Study study = in_agreement();
  CoreMatrix small = diagonal(0.3 * 0.99, 0.3, 1e-3);  // below a hundredth of the variance of 3 m
  EXPECT_FALSE(agreement(study, small, small, kRuns).axes[0].matters);
  small = diagonal(0.3 * 1.01, 0.3, 1e-3);
  EXPECT_TRUE(agreement(study, small, small, kRuns).axes[0].matters);

  CoreMatrix turned = diagonal(3, 0.3, 1e-2);  // attitudes add 10 * 3e-4 of the variance of three axes
  turned(2, 2) = 0.9 * 3e-3 * 18;
  EXPECT_FALSE(agreement(study, turned, turned, kRuns).axes[2].first_order);
  turned(2, 2) = 1.1 * 3e-3 * 18.1;
  EXPECT_TRUE(agreement(study, turned, turned, kRuns).axes[2].first_order);
}

}  // namespace
}  // namespace gyrobudget::budget
