// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/identify.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace gyrobudget::allan {
namespace {

constexpr std::int64_t kSamples = 1 << 15;
constexpr int kRecords = 30;

struct PowerLaw {
  int alpha;
  noise::Process process;
  bool differenced;      // S_y gains f^2
  std::int64_t longest;  // factor up to which it keeps its exponent
  noise::Term term;
};

// n/m = 500 clusters, but flicker of phase, which aliasing whitens.
const PowerLaw kLaws[] = {
    {2, noise::White{1}, true, kSamples / 500, noise::Term::quantization},
    {1, noise::Flicker{1}, true, 4, noise::Term::quantization},
    {0, noise::White{1}, false, kSamples / 500, noise::Term::white},
    {-1, noise::Flicker{1}, false, kSamples / 500, noise::Term::flicker},
    {-2, noise::RateRandomWalk{1}, false, kSamples / 500, noise::Term::rate_random_walk},
};

std::vector<double> record(const PowerLaw& law, std::uint64_t stream) {
  std::vector<double> rate = noise::generate_record(std::span(&law.process, 1), kSamples + 1, 1, {5, stream});
  if (law.differenced) {
    for (std::size_t k = 0; k + 1 < rate.size(); ++k) rate[k] = rate[k + 1] - rate[k];
  }
  rate.pop_back();
  return rate;
}

class Identify : public testing::TestWithParam<PowerLaw> {};

TEST_P(Identify, FindsTheExponentOfEveryRecordWithManyClusters) {
  for (std::uint64_t stream = 0; stream < kRecords; ++stream) {
    const std::vector<double> rate = record(GetParam(), stream);
    std::vector<std::int64_t> factors = octave_factors(kSamples);
    std::erase_if(factors, [](std::int64_t m) { return m > GetParam().longest; });
    const std::vector<Identified> found = identify_noise(rate, factors);
    ASSERT_EQ(found.size(), factors.size());
    for (std::size_t i = 0; i < factors.size(); ++i) {
      EXPECT_EQ(found[i].alpha, GetParam().alpha) << "m " << factors[i] << " stream " << stream;
      EXPECT_EQ(found[i].term, GetParam().term);
      EXPECT_EQ(found[i].m, factors[i]);
    }
  }
}

TEST_P(Identify, IsMostlyWithinOneAtThirtyClusters) {
  int right = 0, near = 0;
  for (std::uint64_t stream = 0; stream < kRecords; ++stream) {
    const Identified found = identify_noise(record(GetParam(), stream), kSamples / 2);
    EXPECT_EQ(found.m, kSamples / 30);
    right += found.alpha == GetParam().alpha ? 1 : 0;
    near += std::abs(found.alpha - GetParam().alpha) <= 1 ? 1 : 0;
  }
  EXPECT_GE(near, kRecords * 9 / 10);
  if (GetParam().alpha != 1) {
    EXPECT_GT(right, kRecords / 2);
  }
}

TEST_P(Identify, SkipsWhatIsMissing) {
  for (std::uint64_t stream = 0; stream < 5; ++stream) {
    std::vector<double> rate = record(GetParam(), stream);
    for (std::size_t k = 5; k < rate.size(); k += 97) rate[k] = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t k = 9000; k < 12'000; ++k) rate[k] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(identify_noise(rate, 1).alpha, GetParam().alpha);
    // Angle noise no longer telescopes across a gap: alpha 2 may read 1, the term stays.
    EXPECT_EQ(identify_noise(rate, GetParam().longest).term, GetParam().term);
  }
}

INSTANTIATE_TEST_SUITE_P(PowerLaws, Identify, testing::ValuesIn(kLaws), [](const auto& law) {
  std::string name = law.param.alpha < 0 ? "minus" : "plus";
  return name += std::to_string(std::abs(law.param.alpha));
});

TEST(IdentifyStretches, StandForAllClustersOfALongRecord) {
  constexpr std::int64_t kLong = 1 << 18;  // 8 times what is looked at for m = 1
  // Standard error of r1 from 2^15 clusters: 1/sqrt(2^15) at most; 4 of them fail one record in 16 000.
  constexpr double kScatter = 4 / 181.;
  const auto record_of = [](const noise::Process& process, std::uint64_t stream) {
    return noise::generate_record(std::span(&process, 1), kLong, 1, {9, stream});
  };
  const std::vector<double> white = record_of(noise::White{1}, 0);
  EXPECT_NEAR(identify_noise(white, 1).lag1, 0, kScatter);
  EXPECT_EQ(identify_noise(white, 1).alpha, 0);
  // Flicker and walk are differenced across no gap between stretches: a jump there would show as white.
  const std::vector<double> walk = record_of(noise::RateRandomWalk{1}, 1);
  EXPECT_NEAR(identify_noise(walk, 2).lag1, 1. / 6, kScatter);
  EXPECT_EQ(identify_noise(walk, 2).alpha, -2);
  const std::vector<double> flicker = record_of(noise::Flicker{1}, 2);
  EXPECT_EQ(identify_noise(flicker, 4).alpha, -1);
}

TEST(IdentifyEdge, ReadsEqualSamplesAsWhiteAndATrendAsRandomWalk) {
  EXPECT_EQ(identify_noise(std::vector<double>(100, 3.3), 1).alpha, 0);
  std::vector<double> ramp(1000);
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = static_cast<double>(k);
  EXPECT_EQ(identify_noise(ramp, 1).alpha, -2);
}

TEST(IdentifyEdge, HoldsOnTheShortestRecords) {
  EXPECT_EQ(identify_noise(std::vector<double>{1, 2}, 1).m, 1);
  EXPECT_EQ(identify_noise(std::vector<double>(60, std::numeric_limits<double>::quiet_NaN()), 2).alpha, 0);
}

TEST(IdentifyEdge, MisuseThrows) {
  const std::vector<double> rate(10, 1.);
  EXPECT_THROW((void)identify_noise(rate, 0), std::invalid_argument);
  EXPECT_THROW((void)identify_noise(rate, 6), std::invalid_argument);
  EXPECT_THROW((void)identify_noise({}, 1), std::invalid_argument);
  EXPECT_TRUE(identify_noise(rate, std::span<const std::int64_t>{}).empty());
}

}  // namespace
}  // namespace gyrobudget::allan
