// SPDX-License-Identifier: MIT
// The dyadic recursion on samples at irregular times.
#include "gyrobudget/allan/favar.h"

#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

TEST(IrregularFavar, OneSampleACellIsTheRegularRecursion) {
  std::vector<double> rate = reference::normal(1000, 61), time;
  for (double& y : rate) y += 1e3;
  for (std::size_t k = 0; k < rate.size(); ++k) time.push_back(100 + 0.25 * static_cast<double>(k));
  const Curve regular = recursive_variance(rate, 0.25);
  const auto irregular = irregular_variance(time, rate, 0.25);
  ASSERT_EQ(irregular.size(), regular.points.size());
  for (std::size_t i = 0; i < irregular.size(); ++i) {
    EXPECT_EQ(irregular[i].terms, regular.points[i].terms);
    EXPECT_EQ(irregular[i].tau, regular.tau(i));
    EXPECT_NEAR(irregular[i].variance / regular.points[i].variance, 1, 1e-11);
    EXPECT_NEAR(irregular[i].white_ratio, 1, 1e-12);
  }
}

TEST(IrregularFavar, IsItsDefinition) {
  std::mt19937_64 random(7);
  std::exponential_distribution<double> step(1);
  std::vector<double> rate = reference::normal(200, 62), time;
  double now = 0;
  for (std::size_t k = 0; k < rate.size(); ++k) time.push_back(now += step(random));
  rate[20] = std::numeric_limits<double>::quiet_NaN();
  std::swap(time[3], time[90]), std::swap(rate[3], rate[90]);  // in any order
  const double start = *std::min_element(time.begin(), time.end());
  for (const IrregularPoint& point : irregular_variance(time, rate, 1.5)) {
    // Straight from the samples of each cluster.
    const auto cells = static_cast<std::int64_t>(std::floor((now - start) / 1.5)) + 1;
    long double squares = 0, weights = 0;
    std::int64_t terms = 0;
    const auto mean_of = [&](std::int64_t cell, long double& count) {
      long double sum = 0;
      count = 0;
      for (std::size_t i = 0; i < rate.size(); ++i) {
        const auto at = static_cast<std::int64_t>(std::floor((time[i] - start) / 1.5));
        if (at < cell || at >= cell + point.m || std::isnan(rate[i])) continue;
        sum += rate[i];
        ++count;
      }
      return sum / count;
    };
    for (std::int64_t k = 0; k + 2 * point.m <= cells; ++k) {
      long double c = 0, d = 0;
      const long double step_up = mean_of(k + point.m, d) - mean_of(k, c);
      if (c == 0 || d == 0) continue;
      squares += c * d / (c + d) * step_up * step_up;
      weights += c * d / (c + d);
      ++terms;
    }
    EXPECT_EQ(point.terms, terms) << point.m;
    EXPECT_NEAR(point.variance / static_cast<double>(squares / (2 * weights)), 1, 1e-12) << point.m;
  }
}

TEST(IrregularFavar, KnowsWhiteNoiseAndRandomWalkOfPoissonTimes) {
  // 400 records of 2000 samples at random times: the mean over the records, and the truth.
  constexpr int kRecords = 400, kSamples = 2000;
  constexpr double kSigmas = 4;
  std::mt19937_64 random(8);
  std::exponential_distribution<double> step(1);
  std::normal_distribution<double> normal;
  std::vector<double> white_mean, walk_mean, white_square, walk_square;
  for (int r = 0; r < kRecords; ++r) {
    std::vector<double> time, white, walk;
    double now = 0, level = 0;
    for (int k = 0; k < kSamples; ++k) {
      const double wait = step(random);
      now += wait;
      level += std::sqrt(wait) * normal(random);
      time.push_back(now);
      white.push_back(normal(random));
      walk.push_back(level);
    }
    const auto of_white = irregular_variance(time, white, 1), of_walk = irregular_variance(time, walk, 1);
    white_mean.resize(9), walk_mean.resize(9), white_square.resize(9), walk_square.resize(9);
    for (std::size_t i = 0; i < 9; ++i) {  // one sample a second: q/tau; walk K^2 tau/3
      const double w = of_white[i].variance / of_white[i].white_ratio * of_white[i].tau;
      const double k = of_walk[i].variance * 3 / of_walk[i].tau;
      white_mean[i] += w / kRecords, white_square[i] += w * w / kRecords;
      walk_mean[i] += k / kRecords, walk_square[i] += k * k / kRecords;
    }
  }
  for (std::size_t i = 0; i < 9; ++i) {
    const auto scatter = [&](double mean, double square) {
      return kSigmas * std::sqrt(std::max(0., square - mean * mean) / kRecords);
    };
    EXPECT_NEAR(white_mean[i], 1, scatter(white_mean[i], white_square[i]) + 0.005) << i;
    const double wander = 2 / std::pow(2., static_cast<double>(i));  // of few samples within their cluster
    EXPECT_NEAR(walk_mean[i], 1, scatter(walk_mean[i], walk_square[i]) + wander) << i;
  }
}

TEST(IrregularFavar, EdgesAndMisuse) {
  const std::vector<double> two{0, 1};
  EXPECT_TRUE(irregular_variance(std::span<const double>{}, {}, 1).empty());
  EXPECT_EQ(irregular_variance(two, two, 1).size(), 1U);
  EXPECT_THROW((void)irregular_variance(two, std::span(two).first(1), 1), std::invalid_argument);
  EXPECT_THROW((void)irregular_variance(two, two, 0), std::invalid_argument);
  EXPECT_THROW((void)irregular_variance(two, two, 1e-12), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
