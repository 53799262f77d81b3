// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/combine.h"

#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::fit {
namespace {

using noise::Term;

// A result whose K^2 was estimated as `square` with the given standard deviation.
Result record(double square, double deviation) {
  Result r;
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp})
    r.coefficients.push_back({.term = t});
  Coefficient& c = r.coefficients[3];
  c.fitted = true;
  c.status = Status::identified;
  const double low = square - 1.959963984540054 * deviation;
  c.value = std::sqrt(std::max(0.0, square));
  c.lower = std::sqrt(std::max(0.0, low));
  c.upper = c.upper_two_sided = std::sqrt(std::max(0.0, square) + 1.959963984540054 * deviation);
  return r;
}

Combined combined(const std::vector<Result>& records) {
  const auto list = combine(records);
  EXPECT_EQ(list.size(), 1U);
  return list.front();
}

TEST(Combine, OneRecordIsItself) {
  const Combined c = combined({record(4, 0.1)});
  EXPECT_EQ(c.value, 2);
  EXPECT_EQ(c.records, 1U);
  EXPECT_EQ(c.spread, 0);
  EXPECT_LT(c.lower, 2);
  EXPECT_GT(c.upper, 2);
}

TEST(Combine, RecordsThatAgreeHaveNoSpread) {
  const Combined c = combined({record(4, 0.1), record(4, 0.1), record(4, 0.1), record(4, 0.1)});
  EXPECT_NEAR(c.value, 2, 1e-12);
  EXPECT_EQ(c.spread, 0);
  EXPECT_EQ(c.p_value, 1);
  EXPECT_NEAR(c.upper * c.upper - 4, 3.182446 * 0.05, 1e-5);  // t(3) times 0.1/2
}

// Made once by hand: values 1, 2, 3, 6 with variances 0.1 each relative to them being equal; the condition that defines
// the estimate holds for what comes out.
TEST(Combine, SpreadSolvesItsEquation) {
  const std::array values{1.0, 2.0, 3.0, 6.0};
  std::vector<Result> records;
  for (const double v : values) records.push_back(record(v, 0.1 * v));
  const Combined c = combined(records);
  // Relative 10 % at the mean 3: v = 0.09 for all, so mu = 3 and T^2 = sum of squares/3 - v = 14/3 - 0.09.
  EXPECT_NEAR(c.value * c.value, 3, 1e-9);
  const double between = 14.0 / 3 - 0.09;
  EXPECT_NEAR(c.spread, 0.5 * std::sqrt(between / 3), 1e-6);
  EXPECT_NEAR(c.q, 14 / 0.09, 1e-6);
  EXPECT_LT(c.p_value, 1e-10);
  EXPECT_LE(c.next_lower, c.lower);
  EXPECT_GT(c.next_upper, c.upper);
}

// 400 sensor types of 6 records with a true spread: the interval of the mean covers 95 %. Fewer than 0.90 or more than
// 0.99 of 400 has a probability below 1e-4.
TEST(Combine, IntervalsCover) {
  constexpr int kTypes = 400;
  int covered = 0, next_covered = 0;
  double spread = 0;
  for (std::uint64_t type = 0; type < kTypes; ++type) {
    std::array<double, 13> z{};
    noise::fill_normal({77, type}, 0, z);
    std::vector<Result> records;
    for (std::size_t i = 0; i < 6; ++i) {
      const double truth = 4 + 0.8 * z[i];
      records.push_back(record(truth * (1 + 0.1 * z[i + 6]), 0.1 * truth));
    }
    const Combined c = combined(records);
    covered += c.lower <= 2 && 2 <= c.upper;
    const double next = std::sqrt(4 + 0.8 * z[12]);
    next_covered += c.next_lower <= next && next <= c.next_upper;
    spread += c.spread / kTypes;
  }
  EXPECT_GE(covered, 0.90 * kTypes);
  EXPECT_LE(covered, 0.99 * kTypes);
  EXPECT_GE(next_covered, 0.90 * kTypes);
  EXPECT_NEAR(spread / 0.2, 1,
              0.15);  // 0.8/(2*2); the estimate of a spread from six is biased low by 5 to 10 %
}

TEST(Combine, CountsWhatEachRecordSaw) {
  Result blind = record(0, 0.5);
  blind.coefficients[3].status = Status::upper_bound;
  const Combined c = combined({record(1, 0.2), blind, record(0.8, 0.3)});
  EXPECT_EQ(c.records, 3U);
  EXPECT_EQ(c.identified, 2U);
  EXPECT_GT(c.value, 0);
  EXPECT_TRUE(std::isfinite(c.upper));
  EXPECT_THROW((void)combine({}), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::fit
