// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/detail/dst.h"

#include "gyrobudget/noise/fft.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <Eigen/Core>

namespace gyrobudget::fit {
namespace {

using std::numbers::pi;

// The definition.
Eigen::MatrixXd sine_matrix(std::int64_t n) {
  Eigen::MatrixXd V(n - 1, n - 1);
  for (std::int64_t k = 1; k < n; ++k) {
    for (std::int64_t j = 1; j < n; ++j) {
      V(k - 1, j - 1) = std::sqrt(2.0 / static_cast<double>(n)) *
                        std::sin(pi * static_cast<double>(j * k % (2 * n)) / static_cast<double>(n));
    }
  }
  return V;
}

Eigen::VectorXd slow_transform(const std::vector<double>& rate) {
  Eigen::VectorXd z(static_cast<Eigen::Index>(rate.size()) - 1);
  for (Eigen::Index j = 0; j < z.size(); ++j)
    z(j) = rate[static_cast<std::size_t>(j) + 1] - rate[static_cast<std::size_t>(j)];
  return sine_matrix(static_cast<std::int64_t>(rate.size())) * z;
}

TEST(SineTransform, IsItsDefinition) {
  for (const std::int64_t n : {4, 8, 12, 20, 60, 256, 300}) {
    std::vector<double> rate(static_cast<std::size_t>(n));
    noise::fill_normal({3, static_cast<std::uint64_t>(n)}, 0, rate);
    const Eigen::VectorXd expected = slow_transform(rate);
    const auto found = sine_transform_of_differences(rate);
    ASSERT_EQ(static_cast<Eigen::Index>(found.size()), expected.size());
    constexpr double kRounding = 2e-13;  // 300 sums of 300 rounded terms
    for (Eigen::Index k = 0; k < expected.size(); ++k)
      EXPECT_NEAR(found[static_cast<std::size_t>(k)], expected(k), kRounding) << n << ' ' << k;
  }
}

TEST(SineTransform, LengthsAreTheLastWithFactorsTwoThreeFive) {
  EXPECT_EQ(noise::fft_length_within(3), 0);
  EXPECT_EQ(noise::fft_length_within(4), 4);
  EXPECT_EQ(noise::fft_length_within(16), 16);
  EXPECT_EQ(noise::fft_length_within(17), 16);
  EXPECT_EQ(noise::fft_length_within(36000), 36000);
  EXPECT_EQ(noise::fft_length_within(36007), 36000);
  EXPECT_EQ(noise::fft_length_within(1000003), 1000000);
  for (const std::int64_t samples : {64, 997, 5003, 99991, 1299709}) {
    const double loss = 1 - static_cast<double>(noise::fft_length_within(samples)) / static_cast<double>(samples);
    EXPECT_GE(loss, 0);
    EXPECT_LT(loss, samples >= 99991 ? 0.02 : 0.06) << samples;
  }
}

// Covariance of the differences from the structure function D(h): -(D(h+1) - 2 D(h) + D(h-1))/2... of the rates.
Eigen::MatrixXd dense_covariance(const noise::Process& process, std::int64_t n, double dt) {
  const auto D = [&](std::int64_t h) { return noise::structure_function(process, std::abs(h), dt); };
  Eigen::MatrixXd covariance(n - 1, n - 1);
  for (std::int64_t i = 0; i < n - 1; ++i) {
    for (std::int64_t j = 0; j < n - 1; ++j) covariance(i, j) = 0.5 * (D(i - j + 1) + D(i - j - 1) - 2 * D(i - j));
  }
  return covariance;
}

struct Diagonality {
  double variance_error = 0;  // largest, relative, of sine_variance against the exact diagonal
  double correlation = 0;     // largest between two coefficients
};

Diagonality diagonality(const noise::Process& process, std::int64_t n, double dt) {
  const Eigen::MatrixXd V = sine_matrix(n);
  const Eigen::MatrixXd exact = V * dense_covariance(process, n, dt) * V.transpose();
  Diagonality d;
  for (Eigen::Index k = 0; k < n - 1; ++k) {
    const double found = sine_variance(process, static_cast<double>(k) + 1, n, dt);
    d.variance_error = std::max(d.variance_error, std::abs(found / exact(k, k) - 1));
    for (Eigen::Index l = 0; l < k; ++l) {
      d.correlation = std::max(d.correlation, std::abs(exact(k, l)) / std::sqrt(exact(k, k) * exact(l, l)));
    }
  }
  return d;
}

constexpr double kRounding = 1e-9;  // of sums of n^2 = 6e4 terms against variances down to 1e-5 of the largest

TEST(SineVariance, WhiteAndWalkAreExactlyDiagonal) {
  for (const std::int64_t n : {16, 60, 256}) {
    for (const noise::Process& p : {noise::Process{noise::White{2}}, noise::Process{noise::RateRandomWalk{3}}}) {
      const auto d = diagonality(p, n, 0.01);
      EXPECT_LT(d.variance_error, kRounding);
      EXPECT_LT(d.correlation, kRounding);
    }
  }
}

TEST(SineVariance, OfQuantizationIsExact) {
  for (const std::int64_t n : {16, 60, 256})
    EXPECT_LT(diagonality(noise::Quantization{2}, n, 0.01).variance_error, 1e-6);
}

TEST(SineVariance, OfGaussMarkovIsExactAtAnyCorrelationTime) {
  for (const double time : {1e-3, 0.01, 0.1, 1.0, 10.0, 1e4}) {
    const auto d = diagonality(noise::GaussMarkov{2, time}, 128, 0.01);
    EXPECT_LT(d.variance_error, 1e-7) << time;
    // Nearly independent: two coefficients of one parity share what the ends add.
    EXPECT_LT(d.correlation, 0.35) << time;
  }
}

// Flicker: the diagonal to the order stated, and how far from independent its coefficients are.
TEST(SineVariance, OfFlickerIsNearlyDiagonal) {
  const auto coarse = diagonality(noise::Flicker{2}, 16, 0.01), fine = diagonality(noise::Flicker{2}, 256, 0.01);
  EXPECT_LT(coarse.variance_error, 2e-3);
  EXPECT_LT(fine.variance_error, 2e-5);
  EXPECT_GT(fine.correlation, 0.05);
  EXPECT_LT(fine.correlation, 0.13);  // theory section 6: 0.12
}

// Theory section 6: first coefficients 0.774, 0.903, 0.931, 0.950 of the spectrum.
TEST(SineVariance, OfFlickerFallsShortOfTheSpectrumAtTheLongestPeriods) {
  constexpr std::int64_t n = 36000;
  constexpr std::array kTheory{0.774, 0.903, 0.931, 0.950};
  for (std::size_t i = 0; i < kTheory.size(); ++i) {
    const auto k = static_cast<double>(i + 1);
    const double spectrum = 2 * std::sin(pi * k / (2 * n));
    EXPECT_NEAR(sine_variance(noise::Flicker{1}, k, n, 1) / spectrum, kTheory[i], 6e-4);
  }
}

// Far from the ends of the band every variance is the spectrum of the differences.
TEST(SineVariance, IsTheSpectrumOfTheDifferences) {
  constexpr std::int64_t n = 1 << 20;
  constexpr double kDt = 0.01;
  for (const noise::Process& p :
       {noise::Process{noise::Quantization{2}}, noise::Process{noise::White{2}}, noise::Process{noise::Flicker{2}},
        noise::Process{noise::RateRandomWalk{2}}, noise::Process{noise::GaussMarkov{2, 1}}}) {
    for (const double k : {1e5, 5e5, 1e6}) {
      const double s = std::sin(pi * k / (2 * n));
      const double spectrum = 4 * s * s * noise::psd(p, k / (2 * n * kDt), kDt) / kDt;
      EXPECT_NEAR(sine_variance(p, k, n, kDt) / spectrum, 1, 1e-4);
    }
  }
}

TEST(SineMean, OfRampAndLineAreTheirTransforms) {
  constexpr std::int64_t n = 60;
  constexpr double kDt = 0.1;
  std::vector<double> ramp(n), cosine(n), sine(n);
  for (const double w : {0.0123, 1.0, pi * 20 / 60, 3.1}) {
    for (std::int64_t j = 0; j < n; ++j) {
      const auto i = static_cast<std::size_t>(j);
      ramp[i] = kDt * static_cast<double>(j);
      cosine[i] = std::cos(w * static_cast<double>(j));
      sine[i] = std::sin(w * static_cast<double>(j));
    }
    const Eigen::VectorXd r = slow_transform(ramp), c = slow_transform(cosine), s = slow_transform(sine);
    for (std::int64_t k = 1; k < n; ++k) {
      EXPECT_NEAR(sine_mean_of_ramp(k, n, kDt), r(k - 1), 1e-12);
      const auto line = sine_mean_of_line(k, n, w);
      EXPECT_NEAR(line[0], c(k - 1), 1e-11);
      EXPECT_NEAR(line[1], s(k - 1), 1e-11);
    }
  }
}

TEST(SineVariance, RefusesMeans) {
  EXPECT_THROW((void)sine_variance(noise::RateRamp{1}, 1, 16, 1), std::invalid_argument);
  EXPECT_THROW((void)sine_variance(noise::Sinusoid{1, 0.1, 0}, 1, 16, 1), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::fit
