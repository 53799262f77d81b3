// SPDX-License-Identifier: MIT
// Errors of which most hide in the noise: what they leave there, against what is put in.
#include "gyrobudget/allan/outlier_tail.h"

#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace gyrobudget::allan {
namespace {

constexpr std::int64_t kSamples = 100000;

// White noise of sigma 1; normal errors of `sigmas` in every sample with probability `share`.
std::vector<double> contaminated(double share, double sigmas, std::uint64_t seed) {
  std::vector<double> rate =
      noise::generate_record(std::vector<noise::Process>{noise::White{1}}, kSamples, 1, {seed, 0});
  std::vector<double> error(rate.size()), choice(rate.size());
  noise::fill_normal({seed, 1}, 0, error);
  noise::fill_normal({seed, 2}, 0, choice);
  for (std::size_t k = 0; k < rate.size(); ++k)
    if (0.5 * std::erfc(choice[k] / std::sqrt(2.)) < share) rate[k] += sigmas * error[k];
  return rate;
}

// E[x^2 | |x| < limit] - 1 of the contaminated normal.
double left_within(double share, double sigmas, double limit) {
  const auto squares = [](double c) {
    return std::erf(c / std::sqrt(2.)) - 2 * c * std::exp(-0.5 * c * c) / std::sqrt(2 * std::numbers::pi);
  };
  const auto within = [](double c) { return std::erf(c / std::sqrt(2.)); };
  return ((1 - share) * squares(limit) + share * sigmas * sigmas * squares(limit / sigmas)) /
             ((1 - share) * within(limit) + share * within(limit / sigmas)) -
         1;
}

TEST(OutlierTail, WhatHidesInTheNoiseIsKnown) {
  // Of 95 % intervals fewer than 14 of 20 hold the truth with a probability of 3e-5.
  constexpr int kRecords = 20, kFewest = 14;
  const double kSpread = std::sqrt(1 + std::numbers::pi / 2 / 40);  // of distances from the median of 40 neighbours
  struct Case {
    double share, sigmas;
  };
  for (const Case& c : {Case{0.001, 10}, Case{0.01, 5}, Case{0.05, 3}, Case{0.01, 30}}) {
    int held = 0, found = 0;
    for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
      const std::vector<double> rate = contaminated(c.share, c.sigmas, seed);
      std::vector<Outlier> outliers = find_outliers(rate);
      const std::size_t before = outliers.size();
      const auto tail = find_outlier_tail(rate, outliers);
      if (!tail) continue;
      ++found;
      EXPECT_GT(outliers.size(), before);
      const double truth =
          left_within(c.share, std::hypot(kSpread, c.sigmas) / kSpread, tail->limit * tail->sigma / kSpread);
      held += std::abs(tail->left - truth) < 1.96 * tail->left_sigma ? 1 : 0;
    }
    EXPECT_EQ(found, kRecords) << c.share;
    EXPECT_GE(held, kFewest) << c.share << ", " << c.sigmas;
  }
}

TEST(OutlierTail, NoiseKnocksAndBurstsHaveNone) {
  std::vector<double> rate = contaminated(0, 1, 3);
  std::vector<Outlier> none = find_outliers(rate);
  EXPECT_FALSE(find_outlier_tail(rate, none));
  for (std::size_t k = 1000; k < 1015; ++k) rate[k] += 20;  // two blows
  for (std::size_t k = 7000; k < 7010; ++k) rate[k] -= 25;
  std::vector<Outlier> blows = find_outliers(rate);
  ASSERT_GE(blows.size(), 20U);
  const std::size_t before = blows.size();
  EXPECT_FALSE(find_outlier_tail(rate, blows));
  EXPECT_EQ(blows.size(), before);
}

}  // namespace
}  // namespace gyrobudget::allan
