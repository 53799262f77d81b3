// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/deviation.h"

#include "gyrobudget/allan/detail/second_difference.h"
#include "gyrobudget/allan/factors.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

using Factors = std::vector<std::int64_t>;

// Issue's bound for the deviation; the variance is twice as sensitive, so it is the stricter one that is tested.
constexpr double kExact = 1e-12;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double relative_error(double value, long double truth) {
  return static_cast<double>(std::abs((static_cast<long double>(value) - truth) / truth));
}

std::vector<double> accumulate(std::vector<double> steps) {
  std::partial_sum(steps.begin(), steps.end(), steps.begin());
  return steps;
}

// ---- against the definition ------------------------------------------------------------------------------------

struct Case {
  const char* name;
  std::vector<double> (*make)(std::size_t samples);
};

const Case kCases[] = {
    {"white", [](std::size_t n) { return reference::normal(n, 1); }},
    {"white_on_earth_rate",
     [](std::size_t n) {
       auto y = reference::normal(n, 2);
       for (double& v : y) v = 15.04 + 0.324 * v;
       return y;
     }},
    {"random_walk", [](std::size_t n) { return accumulate(reference::normal(n, 3)); }},
    {"drift",
     [](std::size_t n) {
       auto y = reference::normal(n, 4);
       for (std::size_t k = 0; k < n; ++k) y[k] += 100 * static_cast<double>(k) / static_cast<double>(n);
       return y;
     }},
    {"spike",
     [](std::size_t n) {
       auto y = reference::normal(n, 5);
       y[n / 3] = 1e6;
       return y;
     }},
};

class AgainstDefinition : public testing::TestWithParam<Case> {};

TEST_P(AgainstDefinition, AgreesAtEveryLengthAndForm) {
  for (const std::size_t samples : {2U, 3U, 7U, 16U, 100U, 1001U, 9000U}) {
    const std::vector<double> rate = GetParam().make(samples);
    const auto n = static_cast<std::int64_t>(samples);
    Factors factors = samples < 200 ? all_factors(n) : log_factors(n, 7);  // to both sides of the border at 4096
    for (const Form form : {Form::full, Form::ieee}) {
      const Curve curve = overlapped_variance(rate, 0.01, factors, {.form = form});
      for (const Point& point : curve.points) {
        const auto truth = reference::overlapped_variance(rate, point.m, form);
        ASSERT_EQ(point.terms, complete_terms(n, point.m, form));
        ASSERT_EQ(point.terms, truth.terms);
        if (truth.terms == 0) {
          ASSERT_TRUE(std::isnan(point.variance));
          continue;
        }
        ASSERT_LT(relative_error(point.variance, truth.variance), kExact) << "n " << samples << " m " << point.m;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Records, AgainstDefinition, testing::ValuesIn(kCases),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- long records, exact integer arithmetic on the very same doubles -------------------------------------------

constexpr std::size_t kTenHours = 3'600'000;

/// Rounds to a grid on which sums are exact integers.
std::vector<double> on_grid(std::vector<double> rate, double offset, double step) {
  for (double& v : rate) v = std::round((v + offset) / step) * step;
  return rate;
}

void expect_exact(const std::vector<double>& rate, double step, double tolerance) {
  const Factors factors = log_factors(static_cast<std::int64_t>(rate.size()), 15);
  for (const Point& point : overlapped_variance(rate, 0.01, factors).points) {
    const long double truth = reference::exact_overlapped_variance(rate, step, point.m);
    EXPECT_LT(relative_error(point.variance, truth), tolerance) << "m " << point.m;
  }
}

TEST(LongRecord, WhiteNoise) { expect_exact(on_grid(reference::normal(kTenHours, 6), 0, 0x1p-36), 0x1p-36, kExact); }

TEST(LongRecord, MeanABillionTimesTheNoise) {
  constexpr double kStep = 0x1p-23;  // one ulp of 1e9
  expect_exact(on_grid(reference::normal(kTenHours, 7), 1e9, kStep), kStep, kExact);
}

TEST(LongRecord, RandomWalk) {
  constexpr double kStep = 0x1p-16;
  expect_exact(accumulate(on_grid(reference::normal(kTenHours, 8), 0, kStep)), kStep, kExact);
}

TEST(LongRecord, DriftOfAThousandTimesTheNoise) {
  constexpr double kStep = 0x1p-22;  // squares of the drift fill 119 bits
  std::vector<double> rate = reference::normal(kTenHours, 9);
  for (std::size_t k = 0; k < rate.size(); ++k) rate[k] += 1000 * static_cast<double>(k) / kTenHours;
  expect_exact(on_grid(rate, 0, kStep), kStep, kExact);
}

// ---- closed forms ----------------------------------------------------------------------------------------------

TEST(ClosedForm, EqualSamplesHaveNoVariance) {
  for (const double value : {0., 1., 0.1, -1e9 / 3, 1e-200}) {
    const std::vector<double> rate(20000, value);
    for (const Point& point : overlapped_variance(rate, 1, octave_factors(20000)).points) {
      EXPECT_EQ(point.variance, 0) << value << " m " << point.m;
    }
  }
}

TEST(ClosedForm, RampIsHalfTheSquareOfTheRiseOverOneCluster) {
  std::vector<double> rate(20000);
  std::iota(rate.begin(), rate.end(), -123.);
  for (const Point& point : overlapped_variance(rate, 1, octave_factors(20000)).points) {
    const double rise = static_cast<double>(point.m);
    EXPECT_NEAR(point.variance / (rise * rise / 2), 1, kExact);
  }
}

TEST(ClosedForm, AlternatingSamplesVanishAtEvenFactors) {
  std::vector<double> rate(10000);
  for (std::size_t k = 0; k < rate.size(); ++k) rate[k] = k % 2 == 0 ? 1 : -1;
  EXPECT_DOUBLE_EQ(overlapped_variance(rate, 1, Factors{1}).points[0].variance, 2);
  EXPECT_EQ(overlapped_variance(rate, 1, Factors{2}).points[0].variance, 0);
  EXPECT_DOUBLE_EQ(overlapped_variance(rate, 1, Factors{5}).points[0].variance, 2. / 25);
}

// ---- the same bytes --------------------------------------------------------------------------------------------

void expect_same_bytes(const Curve& a, const Curve& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a.mean), std::bit_cast<std::uint64_t>(b.mean));
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(a.points[i].variance), std::bit_cast<std::uint64_t>(b.points[i].variance))
        << "m " << a.points[i].m;
    EXPECT_EQ(a.points[i].terms, b.points[i].terms);
  }
}

std::vector<double> with_gaps(std::vector<double> rate) {
  for (std::size_t k = 17; k < rate.size(); k += 61) rate[k] = kNaN;
  for (std::size_t k = rate.size() / 2; k < rate.size() / 2 + 500; ++k) rate[k] = kInfinity;
  return rate;
}

TEST(SameBytes, AnyNumberOfThreads) {
  const std::vector<double> complete = reference::normal(300'000, 10), gaps = with_gaps(complete);
  const Factors factors = log_factors(300'000, 40);
  for (const auto& rate : {complete, gaps}) {
    Curve one;
    {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
      one = overlapped_variance(rate, 1, factors);
    }
    for (const std::size_t threads : {2U, 3U, 8U}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      expect_same_bytes(one, overlapped_variance(rate, 1, factors));
    }
  }
}

class EveryInstructionSet : public testing::TestWithParam<detail::InstructionSet> {};

TEST_P(EveryInstructionSet, GivesTheBytesOfTheBaseline) {
  if (!detail::supported(GetParam())) GTEST_SKIP() << "this machine has no such instructions";
  const detail::SecondDifference& baseline = detail::second_difference(detail::InstructionSet::baseline);
  const detail::SecondDifference& other = detail::second_difference(GetParam());
  const std::vector<double> x = accumulate(reference::normal(10'000, 11));
  std::vector<std::uint32_t> missing(x.size());
  for (std::size_t k = 1; k < x.size(); ++k) missing[k] = missing[k - 1] + (k % 37 == 0 || k / 100 == 7 ? 1U : 0U);
  for (const std::int64_t m : {1, 2, 3, 7, 64, 1000, 3333}) {
    for (std::int64_t count = 0; count < 40; ++count) {
      const double a = baseline.complete(x.data(), count, m), b = other.complete(x.data(), count, m);
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b));
    }
    const std::int64_t count = 10'000 - 2 * m, least = (19 * m + 19) / 20;
    const auto a = baseline.masked(x.data(), missing.data(), count, m, least);
    const auto b = other.masked(x.data(), missing.data(), count, m, least);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.squares), std::bit_cast<std::uint64_t>(b.squares));
    ASSERT_EQ(a.terms, b.terms);
    ASSERT_GT(a.terms, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(SameBytes, EveryInstructionSet,
                         testing::Values(detail::InstructionSet::avx2, detail::InstructionSet::avx512));

TEST(SameBytes, AnyOrderOfFactorsAndAnyScaleByTwo) {
  const std::vector<double> rate = reference::normal(30'000, 12);
  const Curve curve = overlapped_variance(rate, 1, Factors{1, 7, 5000, 9000, 15000});
  const Curve mixed = overlapped_variance(rate, 1, Factors{9000, 7, 1, 15000, 7, 5000});
  const std::size_t place[] = {3, 1, 0, 4, 1, 2};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(mixed.points[i].m, curve.points[place[i]].m);
    EXPECT_EQ(mixed.points[i].variance, curve.points[place[i]].variance);
  }
  std::vector<double> scaled = rate;
  for (double& v : scaled) v *= 0x1p-40;
  const Curve small = overlapped_variance(scaled, 1, Factors{1, 7, 5000, 9000, 15000});
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(small.points[i].variance, curve.points[i].variance * 0x1p-80);
}

// ---- what is refused, and what has no answer -------------------------------------------------------------------

TEST(Domain, MisuseThrows) {
  const std::vector<double> rate(100, 1.);
  for (const double dt : {0., -1., kNaN, kInfinity}) {
    EXPECT_THROW((void)overlapped_variance(rate, dt, Factors{1}), std::invalid_argument);
  }
  for (const std::int64_t m : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{51}}) {
    EXPECT_THROW((void)overlapped_variance(rate, 1, Factors{1, m}), std::invalid_argument);
  }
  for (const double fill : {0., -0.5, 1.01, kNaN}) {
    EXPECT_THROW((void)overlapped_variance(rate, 1, Factors{1}, {.minimum_fill = fill}), std::invalid_argument);
  }
  EXPECT_THROW((void)overlapped_variance(std::vector<double>(2, 1.7e308), 1, Factors{1}), std::invalid_argument);
  EXPECT_THROW((void)overlapped_variance(std::vector<double>{1}, 1, Factors{1}), std::invalid_argument);
  try {
    (void)overlapped_variance(rate, 1, Factors{51});
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "averaging factor is 51; for a record of 100 samples it must be from 1 to 50");
  }
}

TEST(Domain, EmptyAndShortRecordsGiveEmptyCurves) {
  const Curve empty = overlapped_variance({}, 1, {});
  EXPECT_TRUE(empty.points.empty());
  EXPECT_TRUE(std::isnan(empty.mean));
  const Curve one = overlapped_variance(std::vector<double>{3}, 1, octave_factors(1));
  EXPECT_TRUE(one.points.empty());
  EXPECT_EQ(one.mean, 3);
  EXPECT_EQ(one.samples, 1);
}

TEST(Domain, IeeeFormHasNoTermAtHalfTheRecord) {
  const Curve curve = overlapped_variance(reference::normal(10, 13), 2, Factors{5}, {.form = Form::ieee});
  EXPECT_EQ(curve.points[0].terms, 0);
  EXPECT_TRUE(std::isnan(curve.points[0].variance));
  EXPECT_EQ(curve.tau(0), 10);
}

// ---- missing samples -------------------------------------------------------------------------------------------

TEST(Missing, AgreesWithTheDefinition) {
  const std::vector<double> rate = with_gaps(accumulate(reference::normal(9'000, 8)));
  for (const double fill : {0.5, 0.95, 1.}) {
    for (const Form form : {Form::full, Form::ieee}) {
      const Curve curve = overlapped_variance(rate, 1, log_factors(9'000, 8), {.form = form, .minimum_fill = fill});
      ASSERT_NE(curve.mask, nullptr);
      for (const Point& point : curve.points) {
        const auto truth = reference::overlapped_variance(rate, point.m, form, fill);
        ASSERT_EQ(point.terms, truth.terms) << "m " << point.m;
        if (truth.terms > 0) {
          ASSERT_LT(relative_error(point.variance, truth.variance), kExact) << point.m;
        } else {
          ASSERT_TRUE(std::isnan(point.variance));
        }
      }
    }
  }
}

TEST(Missing, RunsAreThoseOfTheRecord) {
  std::vector<double> rate = reference::normal(100, 15);
  rate[0] = rate[50] = rate[51] = kNaN;
  rate[99] = -kInfinity;
  const Curve curve = overlapped_variance(rate, 1, Factors{1});
  ASSERT_NE(curve.mask, nullptr);
  EXPECT_EQ(curve.mask->missing(), 4);
  ASSERT_EQ(curve.mask->runs().size(), 3U);
  EXPECT_EQ(curve.mask->runs()[1].first, 50);
  EXPECT_EQ(curve.mask->runs()[1].count, 2);
  EXPECT_EQ(curve.samples, 100);
}

TEST(Missing, NothingLeftIsNoAnswer) {
  const Curve curve = overlapped_variance(std::vector<double>(64, kNaN), 1, octave_factors(64));
  EXPECT_TRUE(std::isnan(curve.mean));
  for (const Point& point : curve.points) {
    EXPECT_EQ(point.terms, 0);
    EXPECT_TRUE(std::isnan(point.variance));
  }
}

TEST(Missing, CompleteRecordHasNoMask) {
  EXPECT_EQ(overlapped_variance(reference::normal(64, 16), 1, Factors{1}).mask, nullptr);
}

}  // namespace
}  // namespace gyrobudget::allan
