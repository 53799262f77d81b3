// SPDX-License-Identifier: MIT
// What the generators promise beyond the second moments, which process_battery_test checks: epoch, streams,
// linearity, chunking, threads, the 1/f approximation's bound.
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

namespace gyrobudget::noise {
namespace {

constexpr double kDt = 0.01;
const std::vector<Process> kEverything = {
    Quantization{1e-6}, White{1e-4},          Flicker{2e-5},         RateRandomWalk{1e-5},
    RateRamp{3e-6},     GaussMarkov{1e-4, 5}, GaussMarkov{2e-4, 50}, Sinusoid{1e-4, 0.7, 0.3}};

std::vector<double> endless(std::span<const Process> processes, std::size_t samples, const Generator::Options& options,
                            std::size_t chunk = std::numeric_limits<std::size_t>::max()) {
  Generator generator(processes, kDt, options);
  std::vector<double> record(samples);
  for (std::size_t at = 0; at < samples;) {
    const std::size_t count = std::min(chunk, samples - at);
    generator.next(std::span(record).subspan(at, count));
    at += count;
  }
  return record;
}

TEST(Generate, FlickerAndWalkAreZeroAtSampleZero) {
  for (const Process& p : {Process(Flicker{1}), Process(RateRandomWalk{1})}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const std::array one = {p};
      EXPECT_EQ(generate_record(one, 100, kDt, {seed, 0})[0], 0);
      EXPECT_NE(generate_record(one, 100, kDt, {seed, 0})[1], 0);
      EXPECT_EQ(endless(one, 100, {.key = {seed, 0}})[0], 0);
    }
  }
}

TEST(Generate, DeterministicTermsAreTheirFormulas) {
  const auto ramp = generate_record(std::array<Process, 1>{RateRamp{3}}, 5000, kDt, {});
  const auto sinusoid = generate_record(std::array<Process, 1>{Sinusoid{2, 0.7, 0.3}}, 5000, kDt, {});
  for (std::size_t k = 0; k < ramp.size(); ++k) {
    const double t = kDt * static_cast<double>(k);
    ASSERT_NEAR(ramp[k], 3 * t, 4e-16 * 3 * t);
    ASSERT_NEAR(sinusoid[k], 2 * std::sin(2 * 3.141592653589793 * 0.7 * t + 0.3), 1e-12);
  }
}

TEST(Generate, RecordsOfAnyLength) {
  for (const std::int64_t n : {1, 2, 3, 4, 5, 7, 1023, 1024, 1025, 4097}) {
    const auto record = generate_record(kEverything, n, kDt, {1, 2});
    ASSERT_EQ(record.size(), static_cast<std::size_t>(n));
    EXPECT_TRUE(std::ranges::all_of(record, [](double y) { return std::isfinite(y); }));
  }
}

TEST(Generate, ASumOfProcessesIsTheSumOfTheirRecords) {
  constexpr std::int64_t kSamples = 3000;
  const StreamKey key{42, 7};
  const auto sum = generate_record(kEverything, kSamples, kDt, key);
  // The two Gauss-Markov processes are of one term and draw by position among themselves: keep them together.
  std::vector<double> added(kSamples, 0.0);
  for (std::size_t i = 0; i < kEverything.size(); ++i) {
    const std::size_t count = std::holds_alternative<GaussMarkov>(kEverything[i]) ? 2 : 1;
    const auto part = generate_record(std::span(kEverything).subspan(i, count), kSamples, kDt, key);
    for (std::size_t k = 0; k < added.size(); ++k) added[k] += part[k];
    i += count - 1;
  }
  for (std::size_t k = 0; k < added.size(); ++k) ASSERT_NEAR(sum[k], added[k], 1e-17) << k;
}

TEST(Generate, EqualProcessesOfOneTermAreIndependent) {
  constexpr std::int64_t kSamples = 100'000;
  const auto one = generate_record(std::array<Process, 1>{White{1}}, kSamples, 1, {});
  const auto two = generate_record(std::array<Process, 2>{White{1}, White{1}}, kSamples, 1, {});
  double correlation = 0;
  for (std::size_t k = 0; k < one.size(); ++k) correlation += one[k] * (two[k] - one[k]);
  constexpr double kSigmas = 6;
  EXPECT_NEAR(correlation / kSamples, 0, kSigmas / std::sqrt(kSamples));
}

TEST(Generate, BothGeneratorsAgreeInAllButFlicker) {
  std::vector<Process> processes = kEverything;
  std::erase_if(processes, [](const Process& p) { return std::holds_alternative<Flicker>(p); });
  EXPECT_EQ(generate_record(processes, 10'000, kDt, {3, 4}), endless(processes, 10'000, {.key = {3, 4}}));
}

TEST(Generate, SeedsAndStreamsDiffer) {
  const auto base = generate_record(kEverything, 100, kDt, {1, 0});
  EXPECT_EQ(base, generate_record(kEverything, 100, kDt, {1, 0}));
  EXPECT_NE(base, generate_record(kEverything, 100, kDt, {1, 1}));
  EXPECT_NE(base, generate_record(kEverything, 100, kDt, {2, 0}));
}

TEST(Generate, BytesDoNotDependOnChunks) {
  const auto whole = endless(kEverything, 5000, {.key = {9, 1}});
  for (const std::size_t chunk : {1, 7, 1000, 1024, 1025, 4999}) {
    EXPECT_EQ(whole, endless(kEverything, 5000, {.key = {9, 1}}, chunk)) << chunk;
  }
}

TEST(Generate, BytesDoNotDependOnThreads) {
  const RecordGenerator generator(kEverything, 20'000, kDt);
  constexpr std::size_t kThreads = 4;
  std::array<std::vector<double>, kThreads> concurrent;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] { concurrent[i] = generator({5, i}); });
    }
  }
  for (std::size_t i = 0; i < kThreads; ++i) EXPECT_EQ(concurrent[i], generator({5, i}));
}

TEST(Generate, WalkCarriesItsRoundingErrors) {
  // Against the same steps summed in long double, whose own error is 1000 (the walk) * 5e-20 * sqrt(2^20
  // steps).
  constexpr double kReference = 1e-13;
  constexpr std::size_t kSamples = 1 << 20;
  const StreamKey key{1, 0};
  const auto walk = generate_record(std::array<Process, 1>{RateRandomWalk{1}}, kSamples, 1, key);
  std::vector<double> steps(kSamples);
  fill_normal({key.seed, key.stream | std::uint64_t{'K'} << 48}, 0, steps);
  long double exact = 0;
  double bare = 0, worst_of_bare = 0;
  for (std::size_t k = 0; k < kSamples; ++k) {
    const double expected = static_cast<double>(exact);
    ASSERT_NEAR(walk[k], expected, 2e-16 * std::abs(expected) + kReference) << k;
    worst_of_bare = std::max(worst_of_bare, std::abs(bare - expected));
    exact += static_cast<long double>(steps[k]);
    bare += steps[k];
  }
  EXPECT_GT(worst_of_bare, 10 * kReference) << "a bare sum would pass too";
}

TEST(Generate, FlickerApproximationKeepsItsBound) {
  struct Stated {
    double poles_per_decade, bound;
  };
  for (const auto& [poles, bound] : {Stated{0.5, 0.32}, Stated{1, 0.0405}, Stated{1.5, 0.0065}, Stated{2, 1.6e-4},
                                     Stated{3, 8e-5}, Stated{10, 8e-5}}) {
    double worst = 0;
    // Band ends that fall anywhere between two poles.
    for (const double longest : {1., 1.3, 2., 5., 17., 30., 100., 333., 1e4, 2.5e5, 1e7, 4e9}) {
      const auto states = flicker_approximation(Flicker{2e-5}, kDt, longest * kDt, poles);
      for (double m = 1; m <= longest; m = std::max(m + 1, std::floor(1.1 * m))) {
        const auto factor = static_cast<std::int64_t>(m);
        const double ratio = allan_variance(states, factor, kDt) / allan_variance(Flicker{2e-5}, factor, kDt);
        worst = std::max(worst, std::abs(std::sqrt(ratio) - 1));
      }
    }
    EXPECT_LE(worst, bound) << poles << " poles per decade";
    EXPECT_GE(worst, bound / 3) << "the stated bound is loose for " << poles << " poles per decade";
  }
}

TEST(Generate, FlickerApproximationStatesPerDecade) {
  // 7 decades of tau at 2 poles each, 1.5 decades slower, 1.5 faster, and the walk.
  const auto states = flicker_approximation(Flicker{1}, 1, 1e7, 2);
  EXPECT_EQ(states.size(), 22u);
  EXPECT_TRUE(std::holds_alternative<RateRandomWalk>(states.back()));
  for (const Process& p : flicker_approximation(Flicker{0}, 1, 10, 1)) EXPECT_EQ(coefficient(p), 0);
}

TEST(Generate, RefusesMisuse) {
  const std::array<Process, 1> white = {White{1}}, flicker = {Flicker{1}};
  EXPECT_THROW((void)generate_record(white, 0, 1, {}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(white, -5, 1, {}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(flicker, 500'000'001, 1, {}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(white, 10, 0, {}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(white, 10, NAN, {}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(white, 10, 1, {1, 1ULL << 48}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(std::array<Process, 1>{White{NAN}}, 10, 1, {}), std::invalid_argument);
  EXPECT_THROW((void)generate_record(std::array<Process, 1>{GaussMarkov{1, -1}}, 10, 1, {}), std::invalid_argument);
  EXPECT_THROW(Generator(white, -1, {}), std::invalid_argument);
  EXPECT_THROW(Generator(flicker, 1, {.longest_tau = 0.5}), std::invalid_argument);
  EXPECT_THROW(Generator(flicker, 1, {.longest_tau = INFINITY}), std::invalid_argument);
  EXPECT_THROW(Generator(flicker, 1, {.poles_per_decade = 0.1}), std::invalid_argument);
  const std::vector<Process> many(257, White{1});
  EXPECT_THROW((void)generate_record(many, 10, 1, {}), std::invalid_argument);
}

TEST(Generate, NothingInNothingOut) {
  EXPECT_EQ(generate_record({}, 3, 1, {}), std::vector<double>(3, 0.0));
  Generator generator({}, 1, {});
  generator.next({});
}

}  // namespace
}  // namespace gyrobudget::noise
