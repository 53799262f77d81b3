// SPDX-License-Identifier: MIT
// Random numbers: published known answers, the transform against the mathematical library, and the
// distribution. Statistical limits are set so that one run of this file fails by chance with probability
// below 1e-6 (and the streams are fixed, so it either always passes or has found something).
#include "gyrobudget/noise/normal.h"

#include "gyrobudget/noise/detail/normal_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

namespace gyrobudget::noise {
namespace {

constexpr double kSigmas = 6;  // two-sided 2e-9 for each of fewer than 200 statistics

std::vector<double> normal(StreamKey key, std::uint64_t first, std::size_t count) {
  std::vector<double> numbers(count);
  fill_normal(key, first, numbers);
  return numbers;
}

std::vector<double> uniform(StreamKey key, std::uint64_t first, std::size_t count) {
  std::vector<double> numbers(count);
  fill_uniform(key, first, numbers);
  return numbers;
}

double expected_uniform(std::uint64_t word) { return (static_cast<double>(word >> 12) + 0.5) * 0x1p-52; }

// Philox4x32-10 of the known-answer file of Random123 (kat_vectors), as {counter or stream, key} through our
// indices.
TEST(Normal, PhiloxKnownAnswers) {
  const auto all = ~std::uint64_t{0};
  // counter ffffffff x4, key ffffffff x2 -> 408f276d 41c83b0e a20bc7c6 6d5451fd
  EXPECT_EQ(uniform({all, all}, all - 1, 2),
            (std::vector{expected_uniform(0x41c83b0e408f276d), expected_uniform(0x6d5451fda20bc7c6)}));
  // counter 243f6a88 85a308d3 13198a2e 03707344, key a4093822 299f31d0 -> d16cfe09 94fdcceb 5001e420 24126ea1
  const StreamKey pi_digits{0x299f31d0a4093822, 0x0370734413198a2e};
  EXPECT_EQ(uniform(pi_digits, 2 * (0x85a308d3243f6a88 << 1 >> 1), 2),
            (std::vector{expected_uniform(0x94fdccebd16cfe09), expected_uniform(0x24126ea15001e420)}));
  // counter 0, key 0 -> 6627e8d5 e169c58d bc57ac4c 9b00dbd8, through Box-Muller
  const std::uint64_t radius_word = 0xe169c58d6627e8d5,
                      angle_word = 0x9b00dbd8bc57ac4c;  // low bits 00: cos, +
  const double radius = std::sqrt(-2 * std::log(expected_uniform(radius_word)));
  const double angle = (expected_uniform(angle_word) - 0.5) * std::numbers::pi / 2;
  const auto numbers = normal({0, 0}, 0, 2);
  EXPECT_NEAR(numbers[0], radius * std::cos(angle), 1e-15);
  EXPECT_NEAR(numbers[1], radius * std::sin(angle), 1e-15);
}

TEST(Normal, TransformMatchesTheMathematicalLibrary) {
  // Box-Muller of the same words, in long double. The words are those of the uniform stream's neighbour
  // block, so take them from the kernel: uniforms of the same blocks show their upper 52 bits, and axis and
  // sign show in the result.
  constexpr std::int64_t kBlocks = 200'000;
  constexpr double kRelative = 1e-15;
  std::vector<double> u(2 * kBlocks), z(2 * kBlocks);
  detail::uniform_blocks(detail::best_target(), {7, 3}, 0, kBlocks, u.data());
  detail::normal_blocks(detail::best_target(), {7, 3}, 0, kBlocks, z.data());
  for (std::size_t i = 0; i < u.size(); i += 2) {
    const long double radius = std::sqrt(-2 * std::log(static_cast<long double>(u[i])));
    const long double angle = (static_cast<long double>(u[i + 1]) - 0.5L) * std::numbers::pi_v<long double> / 2;
    const double along = static_cast<double>(radius * std::cos(angle));
    const double across = static_cast<double>(radius * std::sin(angle));
    const double sign = std::max(std::abs(z[i]), std::abs(z[i + 1])) == std::abs(z[i]) ? std::copysign(1, z[i])
                                                                                       : std::copysign(1, z[i + 1]);
    const bool swapped = std::abs(z[i]) < std::abs(z[i + 1]);
    ASSERT_NEAR(sign * z[swapped ? i + 1 : i], along, kRelative * along) << i;
    ASSERT_NEAR(sign * z[swapped ? i : i + 1], across, kRelative * std::abs(across)) << i;
  }
}

TEST(Normal, EveryTargetGivesTheSameBytes) {
  if (!detail::supported(detail::Target::avx2)) GTEST_SKIP() << "this processor has nothing to compare with";
  for (const auto target : {detail::Target::avx2, detail::Target::avx512}) {
    if (!detail::supported(target)) continue;
    for (const std::int64_t blocks : {0, 1, 5, 8, 127, 128, 129, 5000}) {
      for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{0xfffffff0}, ~std::uint64_t{0} - 3}) {
        const detail::BlockKey key{0x0123456789abcdef, 0xfedcba9876543210};
        std::vector<double> baseline(static_cast<std::size_t>(2 * blocks)), wide(baseline.size());
        for (const auto generate : {detail::normal_blocks, detail::uniform_blocks}) {
          generate(detail::Target::baseline, key, first, blocks, baseline.data());
          generate(target, key, first, blocks, wide.data());
          EXPECT_EQ(baseline, wide) << blocks << " blocks from " << first;
        }
      }
    }
  }
}

TEST(Normal, AnyChunkingGivesTheSameBytes) {
  constexpr std::size_t kCount = 3001;
  for (const auto draw : {normal, uniform}) {
    const auto whole = draw({5, 9}, 17, kCount);
    for (const std::size_t chunk : {1, 2, 3, 255, 256, 257, 1000}) {
      std::vector<double> pieces;
      for (std::size_t at = 0; at < kCount; at += chunk) {
        const auto piece = draw({5, 9}, 17 + at, std::min(chunk, kCount - at));
        pieces.insert(pieces.end(), piece.begin(), piece.end());
      }
      EXPECT_EQ(whole, pieces) << "chunks of " << chunk;
    }
  }
}

TEST(Normal, TailReachesEightSigma) {
  // The smallest uniform, 2^-53, gives sqrt(2 * 53 ln 2) = 8.57; a word of zeros cannot be asked for, so
  // check the law's arithmetic and that 4e7 numbers reach 5 sigma as often as they should.
  EXPECT_GT(std::sqrt(-2 * std::log(0x1p-53)), 8.5);
  constexpr std::size_t kCount = 1 << 20;
  constexpr int kRounds = 40;
  double beyond_4 = 0, beyond_5 = 0;
  for (int round = 0; round < kRounds; ++round) {
    for (const double z : normal({11, 0}, static_cast<std::uint64_t>(round) * kCount, kCount)) {
      beyond_4 += std::abs(z) > 4;
      beyond_5 += std::abs(z) > 5;
    }
  }
  constexpr double kTotal = static_cast<double>(kCount) * kRounds;
  const double expected_4 = kTotal * std::erfc(4 / std::numbers::sqrt2);  // 2657
  const double expected_5 = kTotal * std::erfc(5 / std::numbers::sqrt2);  // 24
  EXPECT_NEAR(beyond_4, expected_4, kSigmas * std::sqrt(expected_4));
  EXPECT_NEAR(beyond_5, expected_5, kSigmas * std::sqrt(expected_5));
}

TEST(Normal, MomentsOfTheStandardNormal) {
  constexpr std::size_t kCount = 4'000'000;
  const double n = static_cast<double>(kCount);
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0, m6 = 0;
  for (const double z : normal({1, 0}, 0, kCount)) {
    const double z2 = z * z;
    m1 += z;
    m2 += z2;
    m3 += z * z2;
    m4 += z2 * z2;
    m6 += z2 * z2 * z2;
  }
  // Moments 0, 1, 0, 3, 15 and their variances (E z^2k - (E z^k)^2)/n: 1, 2, 15, 96, 10170.
  EXPECT_NEAR(m1 / n, 0, kSigmas * std::sqrt(1 / n));
  EXPECT_NEAR(m2 / n, 1, kSigmas * std::sqrt(2 / n));
  EXPECT_NEAR(m3 / n, 0, kSigmas * std::sqrt(15 / n));
  EXPECT_NEAR(m4 / n, 3, kSigmas * std::sqrt(96 / n));
  EXPECT_NEAR(m6 / n, 15, kSigmas * std::sqrt(10170 / n));
}

/// Largest distance between the empirical distribution of `sample` and `cdf`, times sqrt(n).
template <typename Cdf>
double kolmogorov_smirnov(std::vector<double> sample, Cdf cdf) {
  std::ranges::sort(sample);
  const double n = static_cast<double>(sample.size());
  double distance = 0;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double p = cdf(sample[i]), rank = static_cast<double>(i);
    distance = std::max({distance, p - rank / n, (rank + 1) / n - p});
  }
  return distance * std::sqrt(n);
}

TEST(Normal, KolmogorovSmirnov) {
  constexpr double kLimit = 3.0;  // P(exceeded) = 2 exp(-2 * 9) = 3e-8
  const auto normal_cdf = [](double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); };
  const auto uniform_cdf = [](double u) { return u; };
  for (const StreamKey key : {StreamKey{1, 0}, StreamKey{1, 1}, StreamKey{2, 0}}) {
    EXPECT_LT(kolmogorov_smirnov(normal(key, 0, 1'000'000), normal_cdf), kLimit);
    EXPECT_LT(kolmogorov_smirnov(uniform(key, 0, 1'000'000), uniform_cdf), kLimit);
  }
}

TEST(Normal, DirectionOfAPairIsUniform) {
  // Chi-square over 64 sectors of the angle and 16 rings of equal probability of the radius, jointly:
  // octants, axes and signs of the transform cannot be lopsided.
  constexpr std::size_t kPairs = 2'000'000, kSectors = 64, kRings = 16;
  std::vector<double> cells(kSectors * kRings);
  const auto z = normal({3, 0}, 0, 2 * kPairs);
  for (std::size_t i = 0; i < z.size(); i += 2) {
    const double turn = 0.5 + std::atan2(z[i], z[i + 1]) / (2 * std::numbers::pi);
    const double ring = std::exp(-0.5 * (z[i] * z[i] + z[i + 1] * z[i + 1]));
    const auto sector = std::min(static_cast<std::size_t>(turn * kSectors), kSectors - 1);
    ++cells[sector * kRings + std::min(static_cast<std::size_t>(ring * kRings), kRings - 1)];
  }
  const double expected = static_cast<double>(kPairs) / static_cast<double>(cells.size());
  double chi2 = 0;
  for (const double count : cells) chi2 += (count - expected) * (count - expected) / expected;
  const double dof = static_cast<double>(cells.size() - 1);
  EXPECT_NEAR(chi2, dof, kSigmas * std::sqrt(2 * dof));
}

TEST(Normal, NeighboursStreamsAndSeedsAreUncorrelated) {
  constexpr std::size_t kCount = 1'000'000;
  const double limit = kSigmas / std::sqrt(static_cast<double>(kCount));
  const auto correlation = [](const std::vector<double>& a, const std::vector<double>& b, std::size_t lag, int power) {
    double sum = 0;
    for (std::size_t i = 0; i + lag < kCount; ++i) {
      // Squares have variance 2 and show dependence that signs hide.
      sum += power == 1 ? a[i] * b[i + lag] : (a[i] * a[i] - 1) * (b[i + lag] * b[i + lag] - 1) / 2;
    }
    return sum / static_cast<double>(kCount);
  };
  const auto z = normal({1, 0}, 0, kCount);
  for (const int power : {1, 2}) {
    for (const std::size_t lag : {1, 2, 3, 4, 8, 256, 512}) EXPECT_NEAR(correlation(z, z, lag, power), 0, limit) << lag;
    for (const StreamKey other : {StreamKey{1, 1}, StreamKey{1, 1ULL << 32}, StreamKey{1, 1ULL << 48}, StreamKey{2, 0},
                                  StreamKey{1ULL << 32, 0}, StreamKey{0, 1}}) {
      const auto w = normal(other, 0, kCount);
      for (const std::size_t lag : {0, 1, 2}) {
        EXPECT_NEAR(correlation(z, w, lag, power), 0, limit) << other.seed << ' ' << other.stream << ' ' << lag;
      }
    }
  }
}

TEST(Normal, UniformsOfAStreamAreNotItsNormals) {
  // Same seed, stream and index: the radius of the normal must not be that of the uniform.
  constexpr std::size_t kCount = 100'000;
  const auto u = uniform({1, 0}, 0, kCount);
  const auto z = normal({1, 0}, 0, kCount);
  double sum = 0;
  for (std::size_t i = 0; i < kCount; i += 2) {
    sum += (std::log(u[i]) + 1) * (0.5 * (z[i] * z[i] + z[i + 1] * z[i + 1]) - 1);  // both of mean 0, variance 1
  }
  const double pairs = kCount / 2;
  EXPECT_NEAR(sum / pairs, 0, kSigmas / std::sqrt(pairs));
}

}  // namespace
}  // namespace gyrobudget::noise
