// SPDX-License-Identifier: MIT
// Recorders against what each of their parts is said to do, one at a time.
#include "gyrobudget/noise/recorder.h"

#include "gyrobudget/noise/detail/streams.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

namespace gyrobudget::noise {
namespace {

constexpr double kDt = 0.01, kN = 0.2;
constexpr std::int64_t kSamples = 20'000;
constexpr StreamKey kKey{4, 9};
const std::vector<Process> kWhite{White{kN}};

std::vector<double> recorded(const Recorder& recorder, std::int64_t samples = kSamples) {
  return RecorderGenerator(kWhite, recorder, samples, kDt)(kKey);
}

/// A share of n samples is within five of its standard deviations but for 1 in 2 million.
double share_tolerance(double share, double n) { return 5 * std::sqrt(share * (1 - share) / n); }

TEST(Recorder, OneThatDoesNothingLogsTheSensor) {
  EXPECT_EQ(recorded({}), generate_record(kWhite, kSamples, kDt, kKey));
  EXPECT_NEAR(RecorderGenerator(kWhite, {}, kSamples, kDt).sigma(), kN / std::sqrt(kDt), 1e-12);
}

TEST(Recorder, DecimationKeepsOneOfSoManySamples) {
  const auto faster = generate_record(kWhite, 3 * kSamples, kDt / 3, kKey);
  const auto logged = recorded({.decimation = 3});
  ASSERT_EQ(logged.size(), static_cast<std::size_t>(kSamples));
  for (std::size_t k = 0; k < logged.size(); ++k) ASSERT_EQ(logged[k], faster[3 * k]);
}

// Of first order and bandwidth far below the rate, a sample has the variance N^2 times pi/2 of twice the bandwidth.
TEST(Recorder, SigmaIsThatOfFilteredSamples) {
  constexpr double kBandwidth = 0.01 / kDt, kPi = 3.14159265358979;
  const Recorder recorder{.front_end = FrontEnd{FrontEnd::Kind::first_order, kBandwidth}};
  const RecorderGenerator generator(kWhite, recorder, kSamples, kDt);
  const double w = 2 * kPi * kBandwidth * kDt;  // folding adds w^2/12 of it
  EXPECT_NEAR(generator.sigma(), kN * std::sqrt(kPi * kBandwidth), kN * std::sqrt(kPi * kBandwidth) * w * w);
  double squares = 0;
  for (const double y : generator(kKey)) squares += y * y / static_cast<double>(kSamples);
  const double independent = static_cast<double>(kSamples) * w;  // the correlation falls by 1/e in 1/w samples
  EXPECT_NEAR(squares / (generator.sigma() * generator.sigma()), 1, 5 * std::sqrt(2 / independent));
}

TEST(Recorder, RoundingLeavesMultiplesOfItsStepAndAtMostHalfOfOne) {
  const double step = 0.3 * kN / std::sqrt(kDt);
  const auto whole = recorded({}), rounded = recorded({.rounding = 0.3});
  double least = 1, most = -1;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    ASSERT_NEAR(rounded[k] / step, std::nearbyint(rounded[k] / step), 1e-9);
    const double off = rounded[k] / step - whole[k] / step;  // but for the offset, which is one for all
    least = std::min(least, off), most = std::max(most, off);
  }
  EXPECT_LE(most - least, 1 + 1e-9);
  EXPECT_GT(most - least, 0.99);
}

TEST(Recorder, HeldRowsRepeatTheOneBefore) {
  const auto whole = recorded({}), held = recorded({.held = 3});
  for (std::size_t k = 0; k < whole.size(); ++k) ASSERT_EQ(held[k], whole[k % 3 == 2 ? k - 1 : k]) << k;
}

// N of the log, by the mean of many samples: var = N^2/T of a record of length T. Of 4000 records one standard
// deviation of the ratio of variances is sqrt(2/4000).
TEST(Recorder, TheNoiseOfTheLogHoldsWhatHoldingAndRoundingAdd) {
  constexpr int kRecords = 4000, kLength = 600;
  constexpr double kSigmas = 5;
  const FrontEnd filter{FrontEnd::Kind::first_order, 20};
  for (const Recorder& recorder : {Recorder{.held = 2}, Recorder{.held = 3}, Recorder{.rounding = 1},
                                   Recorder{.front_end = filter, .held = 3}, Recorder{.rounding = 0.5, .held = 2}}) {
    const RecorderGenerator generator(kWhite, recorder, kLength, kDt);
    double squares = 0;
    for (std::uint64_t i = 0; i < kRecords; ++i) {
      const auto record = generator({4, i});
      double mean = 0, offset = 0;
      for (const double y : record) mean += y / kLength;
      fill_uniform(detail::source_stream({4, i}, 'r'), 0, std::span(&offset, 1));  // where between two steps it lies
      mean -= recorder.rounding * generator.sigma() * offset;
      squares += mean * mean / kRecords;
    }
    const double n = coefficient(generator.processes()[0]), expected = n * n / (kLength * kDt);
    // The ends of the record lack the memory of the filter, 0.01 of it.
    EXPECT_NEAR(squares / expected, 1, kSigmas * std::sqrt(2. / kRecords) + 0.02) << recorder.held << ' ' << n;
  }
}

TEST(Recorder, GapsAndOutliersHaveTheirShare) {
  const auto whole = recorded({});
  const auto gaps = recorded({.gaps = 0.02}), outliers = recorded({.outliers = 0.01});
  const auto n = static_cast<double>(kSamples);
  EXPECT_NEAR(static_cast<double>(std::ranges::count_if(gaps, [](double y) { return std::isnan(y); })) / n, 0.02,
              share_tolerance(0.02, n));
  double count = 0, squares = 0;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    if (outliers[k] == whole[k]) continue;
    ++count;
    const double size = (outliers[k] - whole[k]) / (kN / std::sqrt(kDt));
    squares += size * size;
  }
  EXPECT_NEAR(count / n, 0.01, share_tolerance(0.01, n));
  EXPECT_NEAR(squares / count, kOutlierSize * kOutlierSize, kOutlierSize * kOutlierSize * 5 * std::sqrt(2 / count));
}

TEST(Recorder, AWarmUpFadesAndAKnockIsShort) {
  const auto whole = recorded({}), warm = recorded({.warm_up = 5}), knocked = recorded({.knock = 30});
  const double sigma = kN / std::sqrt(kDt);
  for (const std::size_t k : {0, 1000, 5000})
    EXPECT_NEAR((warm[k] - whole[k]) / sigma, 5 * std::exp(-20. * static_cast<double>(k) / kSamples), 1e-9) << k;
  double most = 0;
  std::size_t touched = 0;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    const double size = std::abs(knocked[k] - whole[k]) / sigma;
    touched += size > 0;
    most = std::max(most, size);
  }
  EXPECT_EQ(touched, 50U);     // half a second
  EXPECT_NEAR(most, 30, 0.4);  // the samples next to a crest are 9 degrees off it
}

TEST(Recorder, RefusesWhatNoRecorderDoes) {
  const auto refused = [](const Recorder& r) {
    EXPECT_THROW(RecorderGenerator(kWhite, r, 100, kDt), std::invalid_argument);
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  refused({.decimation = 0});
  refused({.held = 0});
  refused({.held = 1001});
  for (const double bad : {-0.1, kNaN}) {
    refused({.warm_up = bad});
    refused({.knock = bad});
    refused({.outliers = bad});
    refused({.rounding = bad});
    refused({.gaps = bad});
  }
  refused({.outliers = 1});
  refused({.gaps = 1});
  refused({.front_end = FrontEnd{FrontEnd::Kind::first_order, 0}});
}

}  // namespace
}  // namespace gyrobudget::noise
