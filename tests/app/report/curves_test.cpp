// SPDX-License-Identifier: MIT
#include "gyrobudget/app/report/curves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fixtures.h"

namespace gyrobudget::report {
namespace {

using noise::Term;

constexpr double kDegPerHour = std::numbers::pi / 180 / 3600;

const Mark* find_mark(const AxisCurves& curves, const std::string& name) {
  const auto it = std::find_if(curves.marks.begin(), curves.marks.end(), [&](const Mark& m) { return m.name == name; });
  return it == curves.marks.end() ? nullptr : &*it;
}

TEST(Curves, ModelIsTheRootOfTheSumOfSquares) {
  const LogResult result = fixtures::mems();
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  ASSERT_EQ(curves.terms.size(), 3U);
  ASSERT_EQ(curves.model.size(), curves.tau_s.size());
  for (std::size_t i = 0; i < curves.tau_s.size(); ++i) {
    double sum = 0;
    for (const TermCurve& t : curves.terms) sum += t.deviation[i] * t.deviation[i];
    EXPECT_NEAR(curves.model[i] / std::sqrt(sum), 1, 1e-14);
    // IEEE Std 952 asymptotes in deg/h, an independent form; the sampled ones differ below a few samples.
    const double tau = curves.tau_s[i];
    const double asymptote =
        std::sqrt(81 / tau + 2 * std::numbers::ln2 / std::numbers::pi * 0.49 + 0.072 * 0.072 * tau / 3);
    EXPECT_NEAR(curves.model[i] / kDegPerHour / asymptote, 1, 1e-3) << tau;
  }
}

TEST(Curves, CoverTheMeasuredTaus) {
  const LogResult result = fixtures::mems();
  const auto& points = result.axes.front().points;
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  EXPECT_DOUBLE_EQ(curves.tau_s.front(), points.front().tau_s);
  EXPECT_DOUBLE_EQ(curves.tau_s.back(), points.back().tau_s);
  EXPECT_TRUE(std::is_sorted(curves.tau_s.begin(), curves.tau_s.end()));
  EXPECT_LE(curves.tau_s.size(), 200U);
  for (const allan::DeviationPoint& p : points) {
    EXPECT_GT(p.deviation, curves.deviation_low);
    EXPECT_LT(p.deviation, curves.deviation_high);
  }
}

TEST(Curves, ReadingPointsGiveTheCoefficients) {
  const LogResult result = fixtures::mems();
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  const Mark* n = find_mark(curves, "N");
  const Mark* b = find_mark(curves, "B");
  const Mark* k = find_mark(curves, "K");
  const Mark* minimum = find_mark(curves, "min");
  ASSERT_TRUE(n && b && k && minimum);
  EXPECT_DOUBLE_EQ(n->tau_s, 1);
  EXPECT_NEAR(n->deviation / kDegPerHour, 60 * 0.15, 1e-9);
  EXPECT_DOUBLE_EQ(k->tau_s, 3);
  EXPECT_NEAR(k->deviation / kDegPerHour, 4.32 / 60, 1e-12);
  EXPECT_NEAR(b->deviation / kDegPerHour, std::sqrt(2 * std::numbers::ln2 / std::numbers::pi) * 0.70, 1e-8);
  EXPECT_NEAR(b->tau_s, std::numbers::sqrt3 * 9 / 0.072, 1e-6);
  EXPECT_EQ(minimum->deviation, result.axes.front().fit->minimum_deviation);
}

TEST(Curves, ALimitIsDrawnButNeitherSummedNorMarked) {
  const LogResult result = fixtures::bounded();
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  ASSERT_EQ(curves.terms.size(), 2U);  // K is left out at zero
  EXPECT_FALSE(curves.terms[0].limit);
  EXPECT_EQ(curves.terms[1].term, Term::flicker);
  EXPECT_TRUE(curves.terms[1].limit);
  EXPECT_DOUBLE_EQ(curves.model.back(), curves.terms[0].deviation.back());
  EXPECT_EQ(find_mark(curves, "B"), nullptr);
  EXPECT_EQ(find_mark(curves, "K"), nullptr);
}

TEST(Curves, WhatMustNotBeQuotedHasNoReadingPoints) {
  const LogResult result = fixtures::not_described();
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  EXPECT_EQ(curves.terms.size(), 3U);
  ASSERT_EQ(curves.marks.size(), 1U);
  EXPECT_EQ(curves.marks.front().name, "min");
}

TEST(Curves, WithoutFitThereIsOnlyARange) {
  const LogResult result = fixtures::mems_curve_only();
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  EXPECT_TRUE(curves.model.empty());
  EXPECT_TRUE(curves.terms.empty());
  EXPECT_TRUE(curves.marks.empty());
  EXPECT_GT(curves.deviation_high, curves.deviation_low);
  EXPECT_TRUE(axis_curves(AxisResult{}, 100).tau_s.empty());
}

TEST(Curves, OnePointIsEnough) {
  LogResult result = fixtures::mems();
  result.axes.front().points.resize(1);
  const AxisCurves curves = axis_curves(result.axes.front(), result.rate_hz);
  EXPECT_EQ(curves.tau_s.size(), 1U);
  EXPECT_EQ(thinned(result.axes.front().points, 300).size(), 1U);
}

TEST(Curves, ThinningKeepsEndsAndSpreadsEvenly) {
  std::vector<allan::DeviationPoint> points(100000);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].m = static_cast<std::int64_t>(i) + 1;
    points[i].tau_s = 0.01 * static_cast<double>(i + 1);
  }
  const auto kept = thinned(points, 300);
  EXPECT_LE(kept.size(), 300U);
  EXPECT_GE(kept.size(), 200U);
  EXPECT_EQ(kept.front().m, 1);
  EXPECT_EQ(kept.back().m, 100000);
  for (std::size_t i = 2; i + 1 < kept.size(); ++i) {
    const double step = std::log(kept[i].tau_s / kept[i - 1].tau_s);
    EXPECT_GE(step, std::log(1e5) / 298 * (1 - 1e-9));
  }
  EXPECT_EQ(thinned(points, 100000).size(), points.size());
}

}  // namespace
}  // namespace gyrobudget::report
