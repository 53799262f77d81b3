// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/psd.h"

#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

using std::numbers::pi;

/// Mean and scatter of each point over many records, relative to the truth.
struct Moments {
  std::vector<double> mean, variance, coverage;
};
template <typename Estimate>
Moments moments(const noise::Process& process, std::int64_t samples, double dt, int records, Estimate estimate) {
  const noise::RecordGenerator generate(std::span(&process, 1), samples, dt);
  Moments m;
  for (int r = 0; r < records; ++r) {
    const Spectrum spectrum = estimate(generate({.seed = 81, .stream = static_cast<std::uint64_t>(r)}), dt);
    const std::size_t points = spectrum.density.size();
    m.mean.resize(points), m.variance.resize(points), m.coverage.resize(points);
    for (std::size_t i = 0; i < points; ++i) {
      const double truth = noise::psd(process, std::min(spectrum.frequency[i], 0.5 / dt), dt);
      const double value = spectrum.density[i] / truth;
      const Interval interval = spectrum.interval(i);
      m.mean[i] += value / records;
      m.variance[i] += value * value / records;
      m.coverage[i] += (interval.lower <= truth && truth <= interval.upper ? 1. : 0.) / records;
    }
  }
  for (std::size_t i = 0; i < m.mean.size(); ++i) m.variance[i] -= m.mean[i] * m.mean[i];
  return m;
}

constexpr int kRecords = 2000;
constexpr double kSigmas = 5;  // about 600 checks in all: false alarm 4e-4

void expect_chi_square(const Moments& m, const Spectrum& shape, double bias) {
  for (std::size_t i = 0; i < m.mean.size(); ++i) {
    const double dof = shape.dof[i];
    EXPECT_NEAR(m.mean[i], 1, kSigmas * std::sqrt(2 / dof / kRecords) + bias) << shape.frequency[i];
    EXPECT_NEAR(m.variance[i] * dof / 2, 1, kSigmas * std::sqrt((2 + 12 / dof) / kRecords) + 0.03 + 2 * bias)
        << shape.frequency[i];
    EXPECT_GT(m.coverage[i], 0.95 - kSigmas * std::sqrt(0.05 * 0.95 / kRecords) - bias) << shape.frequency[i];
  }
}

TEST(Welch, WhiteNoiseReadsItsDensity) {
  const noise::Process white = noise::White{3e-5};
  const auto estimate = [](std::span<const double> rate, double dt) { return welch(rate, dt, 64); };
  const Spectrum shape = estimate(reference::normal(512, 82), 0.01);
  EXPECT_EQ(shape.frequency.front(), 2 / 0.64);
  EXPECT_EQ(shape.frequency.back(), 50);
  EXPECT_NEAR(shape.dof[0], 2 * 15 / (1 + 2 * (1 - 1. / 15) / 36), 1e-12);
  expect_chi_square(moments(white, 512, 0.01, kRecords, estimate), shape, 0);
}

TEST(Multitaper, WhiteNoiseReadsItsDensity) {
  const noise::Process white = noise::White{3e-5};
  const auto estimate = [](std::span<const double> rate, double dt) { return multitaper(rate, dt, 5); };
  const Moments m = moments(white, 127, 0.01, kRecords, estimate);
  const Spectrum shape = estimate(reference::normal(127, 82), 0.01);
  EXPECT_EQ(shape.frequency.size(), 64u);
  // Away from 0 and fs/2 to the letter; the lowest lose what the mean takes.
  const double full = kSigmas * std::sqrt(2. / 10 / kRecords);
  for (std::size_t i = 3; i + 4 < shape.density.size(); ++i) {
    EXPECT_NEAR(m.mean[i], 1, full);
    EXPECT_NEAR(m.variance[i] * 5, 1, kSigmas * std::sqrt(3.2 / kRecords) + 0.03) << i;
    EXPECT_GT(m.coverage[i], 0.925);
  }
  for (std::size_t i = 0; i < 3; ++i) EXPECT_GT(m.coverage[i], 0.9) << i;
}

TEST(Multitaper, RandomWalkReadsItsDensity) {
  // Sine tapers leak little: a steep spectrum is right from a few bandwidths on, where its curvature is
  // small.
  const noise::Process walk = noise::RateRandomWalk{1e-6};
  const Moments m =
      moments(walk, 1079, 1, 300, [](std::span<const double> rate, double dt) { return multitaper(rate, dt, 4); });
  for (std::size_t i = 15; i + 4 < m.mean.size(); i += 7)
    EXPECT_NEAR(m.mean[i], 1, 5 * std::sqrt(2. / 8 / 300) + 0.05) << i;
}

TEST(Multitaper, IsTheDefinition) {
  const std::vector<double> rate = reference::normal(47, 83);  // 2 * 48 = 2^5 * 3: nothing is cut off
  double mean = 0;
  for (const double y : rate) mean += y / 47;
  const Spectrum spectrum = multitaper(rate, 0.1, 3);
  for (std::size_t p = 1; p <= 24; ++p) {
    double power = 0;
    for (int k = 1; k <= 3; ++k) {
      std::complex<double> sum = 0;
      for (int j = 0; j < 47; ++j) {
        const double taper = std::sqrt(2. / 48) * std::sin(pi * k * (j + 1) / 48);
        sum += taper * (rate[static_cast<std::size_t>(j)] - mean) *
               std::polar(1., -2 * pi * static_cast<double>(p) / 48 * j);
      }
      power += std::norm(sum) / 3;
    }
    EXPECT_NEAR(spectrum.density[p - 1], 0.1 * power, 1e-13);
    EXPECT_NEAR(spectrum.frequency[p - 1], static_cast<double>(p) / 4.8, 1e-12);
  }
}

TEST(Psd, TwoSidedDensityIntegratesToTheVariance) {
  const std::vector<double> rate = reference::normal(1 << 14, 84);
  double variance = 0;
  for (const double y : rate) variance += y * y / (1 << 14);
  for (const Spectrum& spectrum : {welch(rate, 0.02), multitaper(rate, 0.02)}) {
    double sum = 0;
    for (const double density : spectrum.density) sum += density * (spectrum.frequency[1] - spectrum.frequency[0]);
    EXPECT_NEAR(2 * sum / variance, 1, 0.02);
  }
}

TEST(Psd, SinusoidHasItsPower) {
  std::vector<double> rate(1 << 12);
  for (std::size_t k = 0; k < rate.size(); ++k) rate[k] = 0.3 * std::cos(2 * pi * 0.125 * static_cast<double>(k));
  for (const Spectrum& spectrum : {welch(rate, 1, 256), multitaper(rate, 1, 6)}) {
    double power = 0;
    for (std::size_t i = 0; i < spectrum.density.size(); ++i)
      power += 2 * spectrum.density[i] * (spectrum.frequency[1] - spectrum.frequency[0]);
    EXPECT_NEAR(power / (0.3 * 0.3 / 2), 1, 0.01);
  }
}

TEST(Psd, LogBinsKeepTheDensityAndAddDegreesOfFreedom) {
  const noise::Process white = noise::White{1};
  for (const bool tapers : {false, true}) {
    const auto estimate = [&](std::span<const double> rate, double dt) {
      return log_binned(tapers ? multitaper(rate, dt, 6) : welch(rate, dt, 400), 10);
    };
    const Spectrum shape = estimate(reference::normal(2047, 85), 1);
    EXPECT_LT(shape.density.size(), 35u);
    const Moments m = moments(white, 2047, 1, kRecords, estimate);
    for (std::size_t i = tapers ? 3 : 0; i < m.mean.size(); ++i) {
      EXPECT_NEAR(m.mean[i], 1, kSigmas * std::sqrt(2 / shape.dof[i] / kRecords));
      EXPECT_GT(m.coverage[i], 0.925) << shape.frequency[i] << " dof " << shape.dof[i];
      EXPECT_LT(m.variance[i] * shape.dof[i] / 2, 1.3) << shape.frequency[i];
      EXPECT_GT(m.variance[i] * shape.dof[i] / 2, 0.5) << shape.frequency[i];
    }
  }
}

TEST(Psd, LargeMeanAndGaps) {
  std::vector<double> rate = reference::normal(1 << 15, 86);
  for (std::size_t k = 0; k < rate.size(); ++k) {
    rate[k] += 1e6;
    if (k % 10 == 3) rate[k] = std::numeric_limits<double>::quiet_NaN();
  }
  for (const Spectrum& spectrum : {welch(rate, 1), multitaper(rate, 1)}) {
    const Spectrum coarse = log_binned(spectrum, 3);
    EXPECT_NEAR(coarse.density.back(), 1, 5 * std::sqrt(2 / coarse.dof.back()));
  }
  const std::vector<double> nothing(100, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(welch(nothing, 1).density.empty());
  EXPECT_TRUE(multitaper(nothing, 1).density.empty());
  EXPECT_TRUE(log_binned(welch(nothing, 1)).density.empty());
}

TEST(Psd, MisuseThrows) {
  const std::vector<double> rate = reference::normal(100, 87);
  EXPECT_THROW((void)welch(rate, 0), std::invalid_argument);
  EXPECT_THROW((void)welch(rate, 1, 101), std::invalid_argument);
  EXPECT_THROW((void)welch(rate, 1, 4), std::invalid_argument);
  EXPECT_THROW((void)welch(std::span(rate).first(7), 1), std::invalid_argument);
  EXPECT_THROW((void)multitaper(rate, 1, 0), std::invalid_argument);
  EXPECT_THROW((void)multitaper(rate, 1, 26), std::invalid_argument);
  EXPECT_THROW((void)multitaper(rate, -1), std::invalid_argument);
  EXPECT_THROW((void)log_binned(welch(rate, 1), 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
