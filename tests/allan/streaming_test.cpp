// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/streaming.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/family.h"
#include "gyrobudget/allan/favar.h"
#include "gyrobudget/allan/statistics.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-12;

std::vector<double> with_losses(std::vector<double> rate, double share, unsigned seed) {
  std::mt19937 bits(seed);
  for (double& y : rate) {
    if (static_cast<double>(bits()) < share * 4294967296.) y = kNaN;
  }
  return rate;
}

StreamingDeviation stream_of(std::span<const double> rate, const StreamingOptions& options = {}) {
  StreamingDeviation stream(1, options);
  stream.push(rate);
  return stream;
}

void expect_same(const Curve& a, const Curve& b, double tolerance) {
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_NEAR(a.mean, b.mean, 1e-12 * (1 + std::abs(b.mean)));
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].m, b.points[i].m);
    EXPECT_EQ(a.points[i].terms, b.points[i].terms) << "m " << a.points[i].m;
    EXPECT_EQ(a.points[i].stride, b.points[i].stride);
    if (b.points[i].terms > 0) {
      EXPECT_NEAR(a.points[i].variance / b.points[i].variance, 1, tolerance) << "m " << a.points[i].m;
    }
  }
}

/// The strided estimator of a whole record at octaves.
Curve whole_record(std::span<const double> rate, const StreamingOptions& options = {}) {
  return deviation(Series(rate, 1, options.minimum_fill), Estimator::oadev,
                   octave_factors(static_cast<std::int64_t>(rate.size())),
                   {.overlap = options.overlap, .least_stride = 1});
}

// ---- against the estimators of whole records
// -----------------------------------------------------------------------

TEST(Streaming, IsTheStridedEstimator) {
  for (const std::size_t samples : {2u, 3u, 31u, 1000u, 4096u, 4097u, 70'001u}) {
    for (const std::int64_t overlap : {1, 2, 16, 64}) {
      const std::vector<double> rate = reference::normal(samples, 51);
      expect_same(stream_of(rate, {.overlap = overlap}).curve(), whole_record(rate, {.overlap = overlap}), kRounding);
    }
  }
}

TEST(Streaming, SkipsClustersWithGapsAsOtherwise) {
  for (const double share : {0.002, 0.04, 0.3}) {
    std::vector<double> rate = with_losses(reference::normal(30'000, 52), share, 53);
    std::fill_n(rate.begin() + 9000, 5000, kNaN);  // a gap longer than a tile
    rate[20'000] = std::numeric_limits<double>::infinity();
    Curve truth = whole_record(rate);
    std::erase_if(truth.points, [](const Point& point) { return point.terms == 0; });
    expect_same(stream_of(rate).curve(), truth, kRounding);
  }
}

TEST(Streaming, SameBytesHoweverItIsCut) {
  const std::vector<double> rate = with_losses(reference::normal(50'000, 54), 0.001, 55);
  const Curve once = stream_of(rate).curve();
  for (const std::size_t chunk : {1u, 7u, 4095u, 4096u, 10'000u}) {
    StreamingDeviation stream(1);
    for (std::size_t k = 0; k < rate.size(); k += chunk) {
      stream.push(std::span(rate).subspan(k, std::min(chunk, rate.size() - k)));
      if (k % 3 == 0 && chunk > 1000) (void)stream.curve();  // looking changes nothing
    }
    const Curve cut = stream.curve();
    ASSERT_EQ(cut.points.size(), once.points.size());
    for (std::size_t i = 0; i < cut.points.size(); ++i) EXPECT_EQ(cut.points[i].variance, once.points[i].variance);
  }
}

TEST(Streaming, LargeMeanCostsNoDigits) {
  std::vector<double> rate = reference::normal(100'000, 56), small(rate.size());
  for (std::size_t k = 0; k < rate.size(); ++k) {
    rate[k] = 1e6 + rate[k];
    small[k] = rate[k] - 1e6;
  }
  expect_same(
      stream_of(rate).curve(),
      [&] {
        Curve curve = stream_of(small).curve();
        curve.mean += 1e6;
        return curve;
      }(),
      1e-10);
}

TEST(Streaming, NothingYet) {
  StreamingDeviation stream(0.5);
  EXPECT_TRUE(stream.curve().points.empty());
  EXPECT_TRUE(std::isnan(stream.curve().mean));
  const double one = 3;
  stream.push(std::span(&one, 1));
  EXPECT_TRUE(stream.curve().points.empty());
  EXPECT_EQ(stream.curve().mean, 3);
  EXPECT_EQ(stream.samples(), 1);
}

TEST(Streaming, DegreesOfFreedomAreThoseOfItsStride) {
  const noise::Process white[] = {noise::White{1}};
  const Curve curve = stream_of(reference::normal(100'000, 57)).curve();
  const auto facts = statistics(curve, white);
  for (std::size_t i = 0; i < facts.size(); ++i) {
    const Point& point = curve.points[i];
    EXPECT_EQ(point.stride, std::max<std::int64_t>(1, point.m / 16));
    const double full = equivalent_dof(100'000, point.m, 1, white);
    EXPECT_NEAR(facts[i].edf / full, 1, 0.006) << point.m;  // the 0.5 % that the stride costs
  }
}

// ---- joining
// ---------------------------------------------------------------------------------------------------------

TEST(Streaming, PartsJoinedAreTheWhole) {
  std::mt19937 bits(58);
  for (int trial = 0; trial < 60; ++trial) {
    const auto samples = static_cast<std::size_t>(trial < 30 ? 1 + bits() % 300 : 5000 + bits() % 20'000);
    const std::int64_t overlap = std::int64_t{1} << bits() % 5;
    std::vector<double> rate = reference::normal(samples, 59 + static_cast<unsigned>(trial));
    for (double& y : rate) y += 1000;
    if (trial % 3 == 0) rate = with_losses(rate, 0.01, 60);

    // Cut at random places, joined in random order of neighbours.
    std::vector<StreamingDeviation> parts;
    for (std::size_t k = 0; k < samples;) {
      const auto length = std::min<std::size_t>(samples - k, 1 + bits() % (1 + samples / 3));
      parts.emplace_back(1, StreamingOptions{.overlap = overlap, .first_sample = static_cast<std::int64_t>(k)});
      parts.back().push(std::span(rate).subspan(k, length));
      k += length;
    }
    while (parts.size() > 1) {
      const auto at = static_cast<std::ptrdiff_t>(bits() % (parts.size() - 1));
      parts[static_cast<std::size_t>(at)].append(parts[static_cast<std::size_t>(at) + 1]);
      parts.erase(parts.begin() + at + 1);
    }
    expect_same(parts[0].curve(), stream_of(rate, {.overlap = overlap}).curve(), 1e-11);

    // And it goes on from there.
    const std::vector<double> more = reference::normal(500, 61);
    parts[0].push(more);
    rate.insert(rate.end(), more.begin(), more.end());
    expect_same(parts[0].curve(), stream_of(rate, {.overlap = overlap}).curve(), 1e-11);
  }
}

TEST(Streaming, MisuseThrows) {
  EXPECT_THROW(StreamingDeviation(0), std::invalid_argument);
  EXPECT_THROW(StreamingDeviation(1, {.overlap = 12}), std::invalid_argument);
  EXPECT_THROW(StreamingDeviation(1, {.overlap = 0}), std::invalid_argument);
  EXPECT_THROW(StreamingDeviation(1, {.minimum_fill = 0}), std::invalid_argument);
  EXPECT_THROW(StreamingDeviation(1, {.first_sample = -1}), std::invalid_argument);
  StreamingDeviation stream = stream_of(reference::normal(100, 62));
  EXPECT_THROW(stream.append(StreamingDeviation(1, {.first_sample = 99})), std::invalid_argument);
  EXPECT_THROW(stream.append(StreamingDeviation(2, {.first_sample = 100})), std::invalid_argument);
  EXPECT_THROW(stream.append(StreamingDeviation(1, {.overlap = 8, .first_sample = 100})), std::invalid_argument);
}

// ---- the recursion on cluster sums
// -----------------------------------------------------------------------------------

TEST(Favar, IsTheOverlappedVariance) {
  for (const std::size_t samples : {0u, 1u, 2u, 5u, 1000u, 20'000u}) {
    for (const double share : {0., 0.01}) {
      const std::vector<double> rate = with_losses(reference::normal(samples, 63), share, 64);
      const Curve ours = recursive_variance(rate, 1);
      const Curve truth = overlapped_variance(rate, 1, octave_factors(static_cast<std::int64_t>(samples)));
      ASSERT_EQ(ours.points.size(), truth.points.size());
      for (std::size_t i = 0; i < ours.points.size(); ++i) {
        EXPECT_EQ(ours.points[i].terms, truth.points[i].terms);
        if (truth.points[i].terms > 0) {
          EXPECT_NEAR(ours.points[i].variance / truth.points[i].variance, 1, kRounding);
        }
      }
    }
  }
}

// ---- statistics without the samples

TEST(StreamStatistics, IntervalsFromSlopesCoverTheTruth) {
  constexpr int kRecords = 400;
  constexpr std::int64_t kSamples = 4096;
  constexpr double kSigmas = 3.5;     // 33 checks: false alarm 8e-3
  constexpr double kMisread = 0.015;  // where few clusters tell a neighbour's law
  const noise::Process kinds[] = {noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}};
  for (const noise::Process& kind : kinds) {
    const noise::RecordGenerator generate(std::span(&kind, 1), kSamples, 1);
    std::vector<double> covered;
    Curve curve;
    for (int r = 0; r < kRecords; ++r) {
      StreamingDeviation stream(1);
      stream.push(generate({.seed = 91, .stream = static_cast<std::uint64_t>(r)}));
      curve = stream.curve();
      const auto facts = statistics(curve, identify_noise(curve));
      covered.resize(facts.size());
      for (std::size_t i = 0; i < facts.size(); ++i) {
        const double truth = noise::allan_variance(kind, curve.points[i].m, 1);
        const Interval& interval = facts[i].interval;
        covered[i] += interval.lower <= truth && truth <= interval.upper ? 1. / kRecords : 0;
      }
    }
    for (std::size_t i = 0; i < covered.size(); ++i)
      EXPECT_GT(covered[i], 0.95 - kMisread - kSigmas * std::sqrt(0.05 * 0.95 / kRecords))
          << static_cast<char>(noise::term(kind)) << " m " << curve.points[i].m;
  }
  Curve modified;
  modified.estimator = Estimator::mdev;
  EXPECT_THROW((void)identify_noise(modified), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
