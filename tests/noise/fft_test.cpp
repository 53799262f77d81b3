// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/fft.h"

#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::noise {
namespace {

using Complex = std::complex<double>;

/// The definition, in O(n^2).
std::vector<Complex> slow_transform(const std::vector<Complex>& x) {
  const std::size_t n = x.size();
  std::vector<Complex> result(n);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const double turn = static_cast<double>(j * k % n) / static_cast<double>(n);
      result[k] += x[j] * std::polar(1.0, -2 * std::numbers::pi * turn);
    }
  }
  return result;
}

TEST(Fft, LengthsAreTheNextWithFactorsTwoThreeFive) {
  const auto smooth = [](std::int64_t n) {
    for (const std::int64_t p : {2, 3, 5}) {
      while (n % p == 0) n /= p;
    }
    return n == 1;
  };
  for (std::int64_t n = 1; n < 3000; ++n) {
    std::int64_t expected = n;
    while (!smooth(expected)) ++expected;
    ASSERT_EQ(fft_length(n), expected);
  }
  EXPECT_EQ(fft_length(3'600'001), 3'645'000);
  EXPECT_EQ(fft_length((std::int64_t{1} << 60)), std::int64_t{1} << 60);
  EXPECT_THROW((void)fft_length(0), std::invalid_argument);
  EXPECT_THROW((void)fft_length((std::int64_t{1} << 60) + 1), std::invalid_argument);
}

TEST(Fft, TransformsMatchTheDefinition) {
  constexpr double kTolerance = 1e-12;
  for (const std::size_t n : {1, 2, 3, 4, 7, 12, 20, 60, 64, 120, 200}) {
    std::vector<double> numbers(2 * n);
    fill_normal({1, n}, 0, numbers);
    std::vector<Complex> x(n);
    for (std::size_t j = 0; j < n; ++j) x[j] = {numbers[2 * j], numbers[2 * j + 1]};
    const auto expected = slow_transform(x);
    auto actual = x;
    fft(actual);
    for (std::size_t k = 0; k < n; ++k) ASSERT_LT(std::abs(actual[k] - expected[k]), kTolerance) << n << ' ' << k;
    if (n % 4 != 0) continue;

    const std::vector<double> real(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(n));
    const auto spectrum = real_spectrum(real);
    const auto full = slow_transform({real.begin(), real.end()});
    ASSERT_EQ(spectrum.size(), n / 2 + 1);
    for (std::size_t k = 0; k <= n / 2; ++k) ASSERT_LT(std::abs(spectrum[k] - full[k]), kTolerance) << n << ' ' << k;
    const auto back = real_signal(spectrum);
    ASSERT_EQ(back.size(), n);
    for (std::size_t j = 0; j < n; ++j) ASSERT_NEAR(back[j] / static_cast<double>(n), real[j], kTolerance);
  }
}

TEST(Fft, LongTransformsComeBack) {
  constexpr std::size_t kPoints = 300'000;  // beyond the lengths whose tables are kept
  std::vector<double> x(kPoints);
  fill_normal({1, 0}, 0, x);
  const auto back = real_signal(real_spectrum(x));
  for (std::size_t j = 0; j < kPoints; ++j) ASSERT_NEAR(back[j] / kPoints, x[j], 1e-14);
}

TEST(Fft, RefusesOddLengths) {
  EXPECT_THROW((void)real_spectrum(std::vector<double>(6)), std::invalid_argument);
  EXPECT_THROW((void)real_spectrum({}), std::invalid_argument);
  EXPECT_THROW((void)real_signal({}), std::invalid_argument);
  EXPECT_THROW((void)real_signal(std::vector<Complex>(2)), std::invalid_argument);
  std::vector<Complex> empty;
  EXPECT_THROW(fft(empty), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::noise
