// SPDX-License-Identifier: MIT
// Filtered white noise: its exact moments against closed forms, quadrature of the spectrum and sums over all
// pairs of samples; its two ways of running against the difference equation.
#include "gyrobudget/noise/filter.h"

#include "gyrobudget/noise/detail/streaming_filter.h"
#include "gyrobudget/noise/normal.h"
#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace gyrobudget::noise {
namespace {

using std::numbers::pi;

TEST(Filter, TapsOfTheFractionalDifference) {
  // Kasdin 1995, eq. 104 at alpha = 1, and its reciprocal.
  EXPECT_EQ(fractional_difference(0.5, 4), (std::vector<double>{1, -1. / 2, -1. / 8, -1. / 16, -5. / 128}));
  EXPECT_EQ(fractional_difference(-0.5, 4), (std::vector<double>{1, 1. / 2, 3. / 8, 5. / 16, 35. / 128}));
  EXPECT_EQ(fractional_difference(1, 3), (std::vector<double>{1, -1, 0, 0}));
  EXPECT_EQ(fractional_difference(0, 2), (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(fractional_difference(0.5, 0), (std::vector<double>{1}));
}

/// Allan variance of y_k = phi y_{k-1} + v_k, Var v = 1.
double allan_of_ar1(double m, double phi) {
  return (m - 3 * phi - m * phi * phi + 4 * std::pow(phi, m + 1) - std::pow(phi, 2 * m + 1)) /
         (m * m * (1 - phi) * (1 - phi) * (1 - phi * phi));
}

TEST(Filter, MomentsOfFirstOrderAutoregression) {
  constexpr double kBound = 1e-9;
  constexpr std::int64_t kFactors[] = {1, 2, 5, 50, 300, 4097, 100'000};
  for (const double phi : {0.5, -0.7}) {
    const FilterMoments moments({3, {1}, {1, -phi}});
    EXPECT_NEAR(moments.variance(), 9 / (1 - phi * phi), kBound * moments.variance());
    for (const std::int64_t m : kFactors) {
      const double expected = 9 * allan_of_ar1(static_cast<double>(m), phi);
      EXPECT_NEAR(moments.allan_variance(m), expected, kBound * expected) << phi << ' ' << m;
    }
  }
  for (const double phi : {0.99, 0.9999}) {  // where the closed form above cancels
    const FilterMoments moments({3, {1}, {1, -phi}});
    const GaussMarkov process{3 / std::sqrt((1 - phi) * (1 + phi)), -1 / std::log(phi)};
    for (const std::int64_t m : kFactors) {
      const double expected = allan_variance(process, m, 1);
      EXPECT_NEAR(moments.allan_variance(m), expected, kBound * expected) << phi << ' ' << m;
    }
  }
  EXPECT_DOUBLE_EQ(FilterMoments({1, {1}, {1, -0.5}}).allan_variance(1), 2. / 3);
  EXPECT_DOUBLE_EQ(FilterMoments({1, {1}, {1, -0.5}}).allan_variance(5), 0.49322916666666666);
  EXPECT_NEAR(FilterMoments({1, {1}, {1, -0.99}}).allan_variance(50), 11.74914733751716, 1e-9);
  EXPECT_NEAR(FilterMoments({1, {1}, {1, -0.99}}).allan_variance(300), 17.821446015208743, 1e-9);
}

TEST(Filter, MomentsWithManyTapsAreExact) {
  // y_k = phi y_{k-L} + v_k is L interleaved first-order autoregressions: white within L samples, and over
  // clusters of k L samples the mean of L independent ones.
  constexpr std::size_t kTaps = 100'000;
  constexpr double kPhi = 0.1, kBound = 1e-9;
  std::vector<double> comb(kTaps + 1);
  comb.front() = 1;
  comb.back() = -kPhi;
  const FilterMoments moments({1, {1}, comb});
  for (const std::int64_t m : {1, 10, 50'000}) {
    const double expected = 1 / (1 - kPhi * kPhi) / static_cast<double>(m);
    EXPECT_NEAR(moments.allan_variance(m), expected, kBound * expected) << m;
  }
  for (const std::int64_t k : {1, 2, 10}) {
    const double expected = allan_of_ar1(static_cast<double>(k), kPhi) / kTaps;
    EXPECT_NEAR(moments.allan_variance(k * static_cast<std::int64_t>(kTaps)), expected, kBound * expected) << k;
  }
}

/// 4 int_0^{1/2} S sin^4(pi m u) / (m^2 sin^2(pi u)) du by the midpoint rule, which converges geometrically on
/// a periodic analytic function.
double allan_from_psd(const FilteredNoise& noise, std::int64_t m) {
  constexpr int kPoints = 1 << 13;
  const auto M = static_cast<double>(m);
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double u = (i + 0.5) / (2 * kPoints), s = std::sin(pi * M * u);
    sum += psd(noise, u, 1) * 4 * std::pow(s, 4) / std::pow(M * std::sin(pi * u), 2) / (2 * kPoints);
  }
  return sum;
}

TEST(Filter, SpectrumGivesAllanVariance) {
  constexpr double kBound = 1e-9;
  const FilteredNoise resonant{2, {1, 0.4, -0.2}, {2, -1.5, 0.9}};  // poles at 0.67 e^{+-0.98 i}
  for (const FilteredNoise& noise :
       {autoregressive_flicker(1, 1), autoregressive_flicker(1, 100), moving_average_flicker(1, 100), resonant}) {
    const FilterMoments moments(noise);
    for (const std::int64_t m : {1, 2, 3, 17, 100, 1000}) {
      const double expected = allan_from_psd(noise, m);
      EXPECT_NEAR(moments.allan_variance(m), expected, kBound * expected) << noise.denominator.size() << ' ' << m;
    }
  }
}

TEST(Filter, SpectrumDoesNotKnowTheSampleInterval) {
  const FilteredNoise noise = autoregressive_flicker(2, 50);
  for (const double dt : {1e-9, 0.01, 1e6}) {
    EXPECT_NEAR(psd(noise, 0.1 / dt, dt), psd(noise, 0.1, 1) * dt, 1e-12 * psd(noise, 0.1, 1) * dt);
  }
  // Flicker where the taps reach, white where they do not: B sqrt(dt) / sum(a) with sum(a) = 1/sqrt(pi p).
  const double flicker = psd(Flicker{2}, 0.1, 1);
  EXPECT_NEAR(psd(noise, 0.1, 1), flicker, 0.01 * flicker);
  EXPECT_NEAR(psd(noise, 1e-6, 1), 4 * pi * 50, 0.01 * 4 * pi * 50);
}

/// Mean of the overlapped estimate over n samples from rest, from the covariance of all pairs of samples.
double brute_force(const std::vector<double>& response, std::int64_t m, std::int64_t n) {
  const auto h = [&](std::int64_t j) { return j < std::ssize(response) ? response[static_cast<std::size_t>(j)] : 0.0; };
  const auto covariance = [&](std::int64_t i, std::int64_t k) {
    double sum = 0;
    for (std::int64_t s = 0; s <= std::min(i, k); ++s) sum += h(i - s) * h(k - s);
    return sum;
  };
  double sum = 0;
  for (std::int64_t first = 0; first + 2 * m <= n; ++first) {
    for (std::int64_t i = 0; i < 2 * m; ++i) {
      for (std::int64_t k = 0; k < 2 * m; ++k) {
        sum += ((i < m) == (k < m) ? 1 : -1) * covariance(first + i, first + k);
      }
    }
  }
  return sum / (2 * static_cast<double>(m * m * (n - 2 * m + 1)));
}

TEST(Filter, RecordsFromRestAgainstAllPairsOfSamples) {
  constexpr std::int64_t kSamples = 40;
  for (const std::int64_t taps : {1, 5, 39, 200}) {
    for (const FilteredNoise& noise : {autoregressive_flicker(1, taps), moving_average_flicker(1, taps)}) {
      std::vector<double> response(1024);
      response[0] = 1;
      detail::make_direct_filter(noise.numerator, noise.denominator)->run(response);
      const FilterMoments moments(noise);
      for (const std::int64_t m : {1, 2, 7, 13, 20}) {
        const double expected = brute_force(response, m, kSamples);
        EXPECT_NEAR(moments.allan_variance(m, kSamples), expected, 1e-11 * expected) << taps << ' ' << m;
        EXPECT_LE(moments.allan_variance(m, kSamples), moments.allan_variance(m));
      }
    }
  }
}

TEST(Filter, LongRecordsForgetTheirStart) {
  const FilterMoments moments(autoregressive_flicker(1, 10));
  for (const std::int64_t m : {1, 100, 10'000}) {
    EXPECT_NEAR(moments.allan_variance(m, 1'000'000'000'000) / moments.allan_variance(m), 1, 1e-9);
  }
}

TEST(Filter, TruncationTables) {
  // The tables of filter.h, to the digits given.
  struct Row {
    double clusters_per_tap, ratio, digit;
  };
  const auto expect_table = [](const FilterMoments& moments, std::int64_t taps, std::initializer_list<Row> rows) {
    for (const auto& [per_tap, ratio, digit] : rows) {
      const auto m = static_cast<std::int64_t>(std::llround(per_tap * static_cast<double>(taps)));
      EXPECT_NEAR(std::sqrt(moments.allan_variance(m) / allan_variance(Flicker{1}, m, 1)), ratio, 0.6 * digit)
          << m << ' ' << taps;
    }
  };
  for (const std::int64_t taps : {1000, 10'000}) {
    expect_table(FilterMoments(autoregressive_flicker(1, taps)), taps,
                 {{0.1, 1.001, 1e-3},
                  {0.3, 1.005, 1e-3},
                  {1, 1.063, 1e-3},
                  {2, 1.105, 1e-3},
                  {3, 1.076, 1e-3},
                  {5, 0.973, 1e-3},
                  {10, 0.77, 1e-2},
                  {30, 0.47, 1e-2},
                  {100, 0.265, 1e-3}});
    expect_table(FilterMoments(moving_average_flicker(1, taps)), taps,
                 {{0.1, 1.013, 1e-3}, {0.3, 1.043, 1e-3}, {1, 1.20, 1e-2}, {3, 0.895, 1e-3}, {10, 0.52, 1e-2}});
  }
}

TEST(Filter, ZeroStartBiasOfFlicker) {
  // With as many taps as samples no truncation shows: what is missing is the past before the record.
  constexpr std::int64_t kSamples = 10'000;
  const FilterMoments moments(moving_average_flicker(1, kSamples));
  const auto bias = [&](std::int64_t m) {
    return moments.allan_variance(m, kSamples) / allan_variance(Flicker{1}, m, 1) - 1;
  };
  constexpr double kDigit = 6e-4;
  EXPECT_NEAR(bias(kSamples / 16), -0.0035, kDigit);
  EXPECT_NEAR(bias(kSamples / 8), -0.0076, kDigit);
  EXPECT_NEAR(bias(kSamples / 4), -0.0185, kDigit);
  EXPECT_NEAR(bias(kSamples / 2), -0.0785, kDigit);
  // The autoregression of as many taps is the same filter from rest.
  const FilterMoments autoregression(autoregressive_flicker(1, kSamples));
  for (const std::int64_t m : {1, 625, 5000}) {
    const double expected = moments.allan_variance(m, kSamples);
    EXPECT_NEAR(autoregression.allan_variance(m, kSamples), expected, 1e-9 * expected);
  }
}

TEST(Filter, MomentsScaleWithSigma) {
  for (const double sigma : {0.0, 1e-30, 1e30}) {
    const FilterMoments moments(autoregressive_flicker(sigma, 100)), unit(autoregressive_flicker(1, 100));
    for (const std::int64_t m : {1, 1000}) {
      const double expected = sigma * sigma * unit.allan_variance(m);
      EXPECT_NEAR(moments.allan_variance(m), expected, 1e-14 * expected);
      EXPECT_NEAR(moments.allan_variance(m, 5000), sigma * sigma * unit.allan_variance(m, 5000), 1e-14 * expected);
    }
  }
}

TEST(Filter, RefusesMisuse) {
  EXPECT_THROW(FilterMoments({1, {}, {1}}), std::invalid_argument);
  EXPECT_THROW(FilterMoments({1, {1}, {}}), std::invalid_argument);
  EXPECT_THROW(FilterMoments({1, {1}, {0, 1}}), std::invalid_argument);
  EXPECT_THROW(FilterMoments({1, {NAN}, {1}}), std::invalid_argument);
  EXPECT_THROW(FilterMoments({INFINITY, {1}, {1}}), std::invalid_argument);
  EXPECT_THROW((void)fractional_difference(0.5, -1), std::invalid_argument);
  EXPECT_THROW((void)fractional_difference(3, 1), std::invalid_argument);
  EXPECT_THROW((void)autoregressive_flicker(1, 0), std::invalid_argument);
  EXPECT_THROW((void)moving_average_flicker(1, 0), std::invalid_argument);
  const FilterMoments moments({1, {1}, {1, -0.5}});
  EXPECT_THROW((void)moments.allan_variance(0), std::invalid_argument);
  EXPECT_THROW((void)moments.allan_variance(51, 100), std::invalid_argument);
  EXPECT_NO_THROW((void)moments.allan_variance(50, 100));
  EXPECT_THROW((void)psd(FilteredNoise{1, {1}, {1}}, 0, 1), std::invalid_argument);
  EXPECT_THROW((void)psd(FilteredNoise{1, {1}, {1}}, 0.6, 1), std::invalid_argument);
  EXPECT_NO_THROW((void)psd(FilteredNoise{1, {1}, {1}}, 0.5, 1));
}

TEST(Filter, RefusesWhatIsNotStable) {
  for (const std::vector<double>& denominator :
       {std::vector<double>{1, -2}, {1, 0, 4}, {1, -1}, {1, 1}, {1, 0, -1.01}, {0.5, -0.5000001}, {1, -2.5, 1}}) {
    EXPECT_THROW(FilterMoments({1, {1}, denominator}), std::invalid_argument) << denominator[1];
  }
  EXPECT_NO_THROW(FilterMoments({1, {1, -7, 12}, {1, 0, 0.81}})) << "zeros may lie anywhere";
}

// --- Running -----------------------------------------------------------------------------------------------

std::vector<double> by_definition(const FilteredNoise& noise, const std::vector<double>& x) {
  std::vector<double> y(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    double sum = 0;
    for (std::size_t j = 0; j < std::min(noise.numerator.size(), k + 1); ++j) sum += noise.numerator[j] * x[k - j];
    for (std::size_t j = 1; j < std::min(noise.denominator.size(), k + 1); ++j) {
      sum -= noise.denominator[j] * y[k - j];
    }
    y[k] = sum / noise.denominator[0];
  }
  return y;
}

TEST(Filter, BothWaysOfRunningAreTheDifferenceEquation) {
  constexpr double kRounding = 1e-12;
  const FilteredNoise mixed{1, fractional_difference(-0.3, 700), fractional_difference(0.2, 300)};
  FilteredNoise scaled = mixed;
  for (double& a : scaled.denominator) a *= -4;
  std::vector<double> x(8192);
  fill_normal({11, 3}, 0, x);
  for (const FilteredNoise& noise :
       {FilteredNoise{1, {2}, {0.5}}, FilteredNoise{1, {1, 3}, {1, -0.5}}, autoregressive_flicker(1, 1),
        autoregressive_flicker(1, 255), autoregressive_flicker(1, 256), autoregressive_flicker(1, 1500),
        moving_average_flicker(1, 256), moving_average_flicker(1, 257), moving_average_flicker(1, 1500), mixed,
        scaled}) {
    const auto expected = by_definition(noise, x);
    for (const auto make : {detail::make_direct_filter, detail::make_block_filter}) {
      const auto filter = make(noise.numerator, noise.denominator);
      const std::size_t size = filter->block_size();
      auto y = x;
      for (std::size_t at = 0; at < y.size(); at += size) filter->run(std::span(y).subspan(at, size));
      for (std::size_t k = 0; k < y.size(); ++k) {
        ASSERT_NEAR(y[k], expected[k], kRounding)
            << k << ", " << noise.numerator.size() << '/' << noise.denominator.size() << ", block " << size;
      }
    }
  }
}

}  // namespace
}  // namespace gyrobudget::noise
