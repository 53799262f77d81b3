// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/taus.h"

#include "gyrobudget/allan/factors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace gyrobudget::allan {
namespace {

using Factors = std::vector<std::int64_t>;
using Kind = Taus::Kind;

constexpr std::int64_t kSamples = 1000;

TEST(Taus, EachKindIsItsList) {
  EXPECT_EQ(factors_of({}, kSamples), octave_factors(kSamples));
  EXPECT_EQ(factors_of({Kind::octave}, kSamples), octave_factors(kSamples));
  EXPECT_EQ(factors_of({Kind::decade}, kSamples), decade_factors(kSamples));
  EXPECT_EQ(factors_of({Kind::all}, kSamples), all_factors(kSamples));
  EXPECT_EQ(factors_of({Kind::logarithmic, 30}, kSamples), log_factors(kSamples, 30));
}

TEST(Taus, TheOverlappedAllanDeviationHasTheRangeOfTheLists) {
  for (const Taus& taus : {Taus{}, Taus{Kind::decade}, Taus{Kind::all}, Taus{Kind::logarithmic, 30}}) {
    EXPECT_EQ(factors_of(taus, Estimator::oadev, kSamples), factors_of(taus, kSamples));
  }
}

// All factors are listed: they must be exactly those at which the estimator has terms.
TEST(Taus, AllFactorsAreThoseWithTerms) {
  for (const Estimator estimator : {Estimator::adev, Estimator::mdev, Estimator::ohdev, Estimator::totdev}) {
    Factors expected;
    for (std::int64_t m = 1; m <= kSamples; ++m) {
      if (has_terms(estimator, kSamples, m)) expected.push_back(m);
    }
    EXPECT_EQ(factors_of({Kind::all}, estimator, kSamples), expected) << name(estimator);
  }
}

TEST(Taus, AnEstimatorGetsItsOwnRange) {
  EXPECT_EQ(factors_of({}, Estimator::oadev, kSamples).back(), 256);
  EXPECT_EQ(factors_of({}, Estimator::totdev, kSamples).back(), 512);  // up to n - 1
  EXPECT_EQ(factors_of({}, Estimator::ohdev, 600).back(), 128);        // up to n/3, not the 256 below n/2
  EXPECT_EQ(factors_of({}, Estimator::theo1, kSamples).back(), 682);   // 0.75 m is nearest to 512, beyond n/2
  for (const Estimator estimator : kEstimators) {
    const Factors factors = factors_of({Kind::logarithmic, 50}, estimator, kSamples);
    EXPECT_FALSE(factors.empty()) << name(estimator);
    EXPECT_TRUE(std::ranges::all_of(factors, [&](auto m) { return has_terms(estimator, kSamples, m); }))
        << name(estimator);
  }
}

TEST(Taus, ACountBelowOneIsRefused) {
  EXPECT_THROW((void)factors_of({Kind::logarithmic}, kSamples), std::invalid_argument);
  EXPECT_THROW((void)factors_of({Kind::logarithmic, 0}, Estimator::theo1, kSamples), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
