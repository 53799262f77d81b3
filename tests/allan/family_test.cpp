// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/family.h"

#include "gyrobudget/allan/detail/family_kernel.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "family_reference.h"
#include "reference.h"

namespace gyrobudget::allan {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double one(Estimator estimator, std::span<const double> rate, double dt, std::int64_t m,
           EstimatorOptions options = {}) {
  return deviation(rate, dt, estimator, std::span(&m, 1), options).points[0].variance;
}

std::vector<std::int64_t> some_factors(Estimator estimator, std::int64_t samples) {
  const FactorRange range = factor_range(estimator, samples);
  std::vector<std::int64_t> factors;
  for (const std::int64_t m :
       {1L, 2L, 3L, 4L, 5L, 7L, 10L, 16L, 33L, 50L, 64L, 97L, 98L, 120L, 150L, 200L, 298L, 300L}) {
    if (has_terms(estimator, samples, m)) factors.push_back(m);
  }
  factors.push_back(range.most);
  return factors;
}

// ---- against the definitions
// -----------------------------------------------------------------------------------

constexpr double kExact = 1e-12;

TEST(Family, IsTheTextbookOnWhiteNoise) {
  std::vector<double> rate = reference::normal(300, 11);
  for (double& y : rate) y = 40 + 0.2 * y;
  for (const Estimator estimator : kEstimators) {
    const auto factors = some_factors(estimator, 300);
    const Curve curve = deviation(rate, 0.02, estimator, factors);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const auto truth = static_cast<double>(reference::family_variance(estimator, rate, 0.02, factors[i]));
      EXPECT_NEAR(curve.points[i].variance / truth, 1, kExact) << name(estimator) << " m " << factors[i];
    }
  }
}

TEST(Family, IsTheTextbookOnRandomWalkAtAnyStride) {
  std::vector<double> rate = reference::normal(301, 12);
  std::partial_sum(rate.begin(), rate.end(), rate.begin());
  for (const Estimator estimator : kEstimators) {
    for (const std::int64_t overlap : {1, 3, 16}) {
      const auto factors = some_factors(estimator, 301);
      const Curve curve = deviation(rate, 1, estimator, factors, {.overlap = overlap, .least_stride = 1});
      for (std::size_t i = 0; i < factors.size(); ++i) {
        const std::int64_t m = factors[i];
        const std::int64_t stride = std::max<std::int64_t>(1, basis_of(estimator, 301, m).m / overlap);
        const auto truth = static_cast<double>(reference::family_variance(estimator, rate, 1, m, stride));
        EXPECT_NEAR(curve.points[i].variance / truth, 1, kExact)
            << name(estimator) << " m " << m << " stride " << stride;
      }
    }
  }
}

TEST(Family, TilesMeetWithoutSeams) {
  // Many tiles of every kind, with factors on both sides of a tile's length where the definition is
  // affordable.
  constexpr std::int64_t kSamples = 70'000;
  const std::vector<double> rate = reference::normal(kSamples, 13);
  const struct {
    Estimator estimator;
    std::vector<std::int64_t> factors;
  } cases[] = {{Estimator::oadev, {1000, 34'000}},  {Estimator::ohdev, {1000, 23'000}},
               {Estimator::adev, {3, 700}},         {Estimator::totdev, {1000, 34'000, 40'000, 69'999}},
               {Estimator::mdev, {3, 500, 23'300}}, {Estimator::mtotdev, {5}},
               {Estimator::htotdev, {5}},           {Estimator::theo1, {12, 69'990}}};
  for (const auto& [estimator, factors] : cases) {
    for (const std::int64_t m : factors) {
      const auto truth = static_cast<double>(reference::family_variance(estimator, rate, 1, m));
      EXPECT_NEAR(one(estimator, rate, 1, m, {.overlap = estimator == Estimator::oadev ? m : 0}) / truth, 1, kExact)
          << name(estimator) << " m " << m;
    }
  }
}

TEST(Family, ThinsOnlyWhatWouldTakeLong) {
  EXPECT_EQ(stride_of(Estimator::mdev, 1'000'000'000, 1000), 1);
  EXPECT_EQ(stride_of(Estimator::mtotdev, 10'000, 300), 1);
  EXPECT_EQ(stride_of(Estimator::theo1, 10'000, 10'000), 1);
  const std::int64_t stride = stride_of(Estimator::mtotdev, 3'600'000, 4096);
  EXPECT_GT(stride, 1);
  EXPECT_LE(stride, 4096 / 4);
  EXPECT_EQ(stride_of(Estimator::adev, 1000, 7, {.overlap = 16}), 7);
  EXPECT_EQ(stride_of(Estimator::oadev, 1000, 160, {.overlap = 16}), 10);
  EXPECT_EQ(stride_of(Estimator::oadev, 1000, 100, {.overlap = 16}), 1);
}

TEST(Family, LargeMeanCostsNoDigits) {
  const std::vector<double> noise = reference::normal(400, 14);
  std::vector<double> rate(noise.size()), small(noise.size());
  for (std::size_t k = 0; k < noise.size(); ++k) {
    rate[k] = 1e6 + noise[k];
    small[k] = rate[k] - 1e6;  // exactly the noise that is left in `rate`
  }
  for (const Estimator estimator : kEstimators) {
    EXPECT_NEAR(one(estimator, rate, 1, 50) / one(estimator, small, 1, 50), 1, 1e-11) << name(estimator);
  }
}

TEST(Family, BlindToWhatTheyShouldBeBlindTo) {
  std::vector<double> ramp(200);
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = 0.01 * static_cast<double>(k);
  for (const Estimator estimator : {Estimator::hdev, Estimator::ohdev}) EXPECT_LT(one(estimator, ramp, 1, 20), 1e-25);
  EXPECT_NEAR(one(Estimator::mdev, ramp, 1, 20), 0.5 * std::pow(0.01 * 20, 2), 1e-12);  // R^2 tau^2 / 2
  const std::vector<double> constant(200, 3.5);
  for (const Estimator estimator : kEstimators) EXPECT_EQ(one(estimator, constant, 1, 20), 0) << name(estimator);
}

TEST(Family, UnitOfTimeEntersAsItShould) {
  const std::vector<double> rate = reference::normal(200, 15);
  for (const Estimator estimator : kEstimators) {
    const bool time = estimator == Estimator::tdev || estimator == Estimator::ttotdev;
    EXPECT_NEAR(one(estimator, rate, 0.1, 20) / one(estimator, rate, 1, 20), time ? 0.01 : 1, 1e-14);
  }
}

TEST(Family, SameBytesAtAnyNumberOfThreads) {
  const std::vector<double> rate = reference::normal(50'000, 16);
  for (const Estimator estimator : kEstimators) {
    const auto factors = usable_factors(estimator, 50'000, std::vector<std::int64_t>{1, 12, 300, 9000});
    const auto run = [&](std::size_t threads) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      return deviation(rate, 1, estimator, factors, {.overlap = 16});
    };
    const Curve alone = run(1), together = run(4);
    for (std::size_t i = 0; i < factors.size(); ++i)
      EXPECT_EQ(alone.points[i].variance, together.points[i].variance) << name(estimator);
  }
}

TEST(FamilyKernel, SameBytesFromEveryInstructionSet) {
  const std::vector<double> x = reference::normal(2000, 21);
  std::vector<double> scratch(2000);
  using detail::InstructionSet;
  const auto& plain = detail::family_kernel(InstructionSet::baseline);
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    if (!detail::supported(set)) continue;
    const auto& wide = detail::family_kernel(set);
    for (const std::int64_t m : {1L, 2L, 7L, 16L, 33L, 100L, 331L}) {
      EXPECT_EQ(plain.third_differences(x.data(), 1003, m), wide.third_differences(x.data(), 1003, m));
      EXPECT_EQ(plain.even_continuation(x.data(), m, scratch.data()),
                wide.even_continuation(x.data(), m, scratch.data()));
      EXPECT_EQ(plain.theo1(x.data(), 2 * m, x.data() + 900), wide.theo1(x.data(), 2 * m, x.data() + 900));
    }
  }
}

// ---- gaps
// ------------------------------------------------------------------------------------------------------

TEST(FamilyGaps, StrictFormCountsWholeTermsOnly) {
  // With a fill of 1 a lost sample removes the terms that span it, and nothing else.
  std::vector<double> rate = reference::normal(300, 17);
  std::vector<double> head(rate.begin(), rate.begin() + 150), tail(rate.begin() + 151, rate.end());
  rate[150] = kNaN;
  const Series record(rate, 1, 1.0), first(head), second(tail);
  for (const Estimator estimator :
       {Estimator::mdev, Estimator::ohdev, Estimator::mtotdev, Estimator::htotdev, Estimator::theo1}) {
    for (const std::int64_t m : {10L, 22L, 40L}) {
      const std::span factor(&m, 1);
      const Point whole = deviation(record, estimator, factor).points[0];
      const Point a = deviation(first, estimator, factor).points[0], b = deviation(second, estimator, factor).points[0];
      const auto A = static_cast<double>(a.terms), B = static_cast<double>(b.terms);
      EXPECT_EQ(whole.terms, a.terms + b.terms) << name(estimator) << " m " << m;
      EXPECT_NEAR(whole.variance, (A * a.variance + B * b.variance) / (A + B), 1e-11 * whole.variance)
          << name(estimator) << " m " << m;
    }
  }
}

TEST(FamilyGaps, FewLossesChangeLittle) {
  constexpr std::int64_t kSamples = 20'000;
  constexpr double kLost = 0.02;
  const noise::Process mix[] = {noise::White{1}, noise::RateRandomWalk{0.01}};
  const std::vector<double> complete = noise::generate_record(mix, kSamples, 1, {.seed = 3});
  std::vector<double> rate = complete;
  std::mt19937 bits(4);
  for (double& y : rate) {
    if (static_cast<double>(bits()) < kLost * 4294967296.) y = kNaN;
  }
  for (const Estimator estimator : kEstimators) {
    const auto factors = usable_factors(estimator, kSamples, std::vector<std::int64_t>{40, 300, 1000});
    const Curve whole = deviation(complete, 1, estimator, factors), holed = deviation(rate, 1, estimator, factors);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      // A term loses about kLost of its variance, at random: over edf ~ n / 2m independent terms that is the
      // chance.
      const double edf = static_cast<double>(kSamples) / static_cast<double>(2 * factors[i]);
      const double chance = 4 * 2 * std::sqrt(kLost / edf);
      EXPECT_NEAR(holed.points[i].variance / whole.points[i].variance, 1, kLost + chance)
          << name(estimator) << " m " << factors[i];
    }
  }
}

TEST(FamilyGaps, NothingLeftIsNaNWithNoTerms) {
  std::vector<double> rate = reference::normal(100, 18);
  for (std::size_t k = 0; k < rate.size(); k += 5) rate[k] = kNaN;
  for (const Estimator estimator : kEstimators) {
    const std::int64_t m = 20;
    const Point point = deviation(rate, 1, estimator, std::span(&m, 1)).points[0];
    EXPECT_EQ(point.terms, 0) << name(estimator);
    EXPECT_TRUE(std::isnan(point.variance));
  }
}

// ---- names, factors, input
// ---------------------------------------------------------------------------------------

TEST(Estimators, NamesGoBothWays) {
  for (const Estimator estimator : kEstimators) EXPECT_EQ(estimator_named(name(estimator)), estimator);
  EXPECT_FALSE(estimator_named("ADEV").has_value());
}

TEST(Estimators, FactorsEndWhereTermsDo) {
  for (const Estimator estimator : kEstimators) {
    for (std::int64_t samples = 0; samples < 40; ++samples) {
      const std::vector<double> rate = reference::normal(static_cast<std::size_t>(samples), 19);
      const FactorRange range = factor_range(estimator, samples);
      for (const std::int64_t m : octave_factors(estimator, samples)) EXPECT_GT(one(estimator, rate, 1, m), 0);
      if (range.most >= range.least) {
        EXPECT_GT(one(estimator, rate, 1, range.most), 0);
      }
      EXPECT_THROW((void)one(estimator, rate, 1, std::max<std::int64_t>(range.most, 0) + range.step),
                   std::invalid_argument);
      EXPECT_THROW((void)one(estimator, rate, 1, 0), std::invalid_argument);
    }
  }
  EXPECT_THROW((void)one(Estimator::theo1, reference::normal(100, 20), 1, 11), std::invalid_argument);
  EXPECT_THROW((void)one(Estimator::mdev, reference::normal(100, 20), 1, 5, {.overlap = -1}), std::invalid_argument);
  EXPECT_EQ(octave_factors(Estimator::theo1, 100), (std::vector<std::int64_t>{10, 22, 42, 86}));
  EXPECT_EQ(octave_factors(Estimator::hdev, 100), (std::vector<std::int64_t>{1, 2, 4, 8, 16, 32}));
}

TEST(Estimators, AnglesAndIncrementsAreRates) {
  const std::vector<double> angles{0.5, 1, 3, 4}, increments{0.5, 2, 1};
  EXPECT_EQ(rates_of_angles(angles, 0.5), (std::vector<double>{1, 4, 2}));
  EXPECT_EQ(rates_of_increments(increments, 0.5), (std::vector<double>{1, 4, 2}));
  EXPECT_TRUE(rates_of_angles({}, 1).empty());
}

}  // namespace
}  // namespace gyrobudget::allan
