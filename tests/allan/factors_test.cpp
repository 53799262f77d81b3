// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/factors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::allan {
namespace {

using Factors = std::vector<std::int64_t>;

TEST(Factors, OctavesReachHalfTheRecord) {
  EXPECT_EQ(octave_factors(16), (Factors{1, 2, 4, 8}));
  EXPECT_EQ(octave_factors(15), (Factors{1, 2, 4}));
  EXPECT_EQ(octave_factors(3'600'000).size(), 21U);
  EXPECT_EQ(octave_factors(1'000'000'000).size(), 29U);
}

TEST(Factors, DecadesAreOneTwoFour) {
  EXPECT_EQ(decade_factors(1000), (Factors{1, 2, 4, 10, 20, 40, 100, 200, 400}));
  EXPECT_EQ(decade_factors(799), (Factors{1, 2, 4, 10, 20, 40, 100, 200}));
}

TEST(Factors, AllStopsAtHalf) { EXPECT_EQ(all_factors(9), (Factors{1, 2, 3, 4})); }

TEST(Factors, LogSpacingIsEvenWithinRounding) {
  constexpr std::int64_t kSamples = 3'600'000;
  const Factors factors = log_factors(kSamples, 100);
  EXPECT_EQ(factors.front(), 1);
  EXPECT_EQ(factors.back(), kSamples / 2);
  const double step = std::log(kSamples / 2) / 99;
  for (std::size_t i = 1; i < factors.size(); ++i) {
    ASSERT_LT(factors[i - 1], factors[i]);
    const double ratio = static_cast<double>(factors[i]) / static_cast<double>(factors[i - 1]);
    if (factors[i] > 1000) {
      EXPECT_NEAR(std::log(ratio), step, 1e-3);
    }
  }
}

TEST(Factors, RecordsTooShortForOneTermHaveNone) {
  for (const std::int64_t samples : {-1, 0, 1}) {
    EXPECT_TRUE(octave_factors(samples).empty());
    EXPECT_TRUE(decade_factors(samples).empty());
    EXPECT_TRUE(all_factors(samples).empty());
    EXPECT_TRUE(log_factors(samples, 10).empty());
  }
  EXPECT_EQ(log_factors(2, 10), Factors{1});
  EXPECT_EQ(log_factors(1000, 1), Factors{1});
  EXPECT_THROW((void)log_factors(1000, 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
