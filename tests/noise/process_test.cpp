// SPDX-License-Identifier: MIT
// Second moments of the noise processes against published and hand-derived values. The relations between the
// moments of one process (spectrum, structure function, phase covariance, Allan variance, samples) are in
// process_battery_test.
#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace gyrobudget::noise {
namespace {

using std::numbers::ln2;
using std::numbers::pi;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 50 * kEpsilon;  // a few dozen roundings

#define EXPECT_REL(actual, expected, tolerance) \
  EXPECT_NEAR(actual, expected, (tolerance)*std::abs(expected)) << "relative tolerance " << (tolerance)

/// h_n by its definition, smallest terms first.
double odd_harmonic_sum(std::int64_t n) {
  long double sum = 0;
  for (std::int64_t k = n; k >= 1; --k) sum += 1.0L / static_cast<long double>(2 * k - 1);
  return static_cast<double>(sum);
}

TEST(Process, KnowsItsTermAndCoefficient) {
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp,
                       Term::gauss_markov, Term::sinusoid}) {
    const Process unit = unit_process(t);
    EXPECT_EQ(term(unit), t);
    EXPECT_EQ(coefficient(unit), 1);
    const Process other = with_coefficient(unit, 2.5);
    EXPECT_EQ(term(other), t);
    EXPECT_EQ(coefficient(other), 2.5);
  }
  const auto slow = std::get<GaussMarkov>(with_coefficient(GaussMarkov{1, 300}, 4));
  EXPECT_EQ(slow.sigma, 4);
  EXPECT_EQ(slow.correlation_time, 300);
  EXPECT_THROW((void)unit_process(static_cast<Term>('X')), std::invalid_argument);
}

TEST(Process, FlickerAllanVarianceOfKasdinSamples) {
  // Quadrature of 4 S sin^4/(m^2 sin^2) with S = B^2 dt/(2 sin(pi f dt)), B = 1, to 16 digits.
  const std::vector<std::pair<std::int64_t, double>> table = {{1, 0.6366197723675813}, {2, 0.5092958178940652},
                                                              {3, 0.4767350182491621}, {5, 0.4564485080469557},
                                                              {10, 0.445889791439050}, {100, 0.441344860873598}};
  constexpr double kTableDigits = 2e-15;
  for (const auto& [m, value] : table) EXPECT_REL(allan_variance(Flicker{1}, m, 0.01), value, kTableDigits) << m;
}

TEST(Process, FlickerAllanVarianceMatchesItsSumWithoutCancellation) {
  for (const std::int64_t m : {1, 2, 7, 15, 16, 17, 31, 32, 33, 1000, 100'000}) {
    const double M = static_cast<double>(m);
    const double h_m = odd_harmonic_sum(m), h_2m = odd_harmonic_sum(2 * m);
    const double direct = ((16 * M * M - 1) * h_2m - 4 * (4 * M * M - 1) * h_m) / (4 * pi * M * M);
    constexpr double kDirectCancels = 40;  // 16 h_2m / (h_2m - h_m) at m = 1e5
    EXPECT_REL(allan_variance(Flicker{1}, m, 1), direct, kDirectCancels * kEpsilon) << m;
  }
}

TEST(Process, FlickerAllanVarianceTendsToTheFlat) {
  // Next order of the closed form: sigma^2 = B^2/(4 pi) [8 ln 2 + (3 ln m/2 ...)/m^2], so 1e-12 of the flat
  // at 1e7.
  const double flat = 2 * ln2 / pi;
  for (const std::int64_t m : {10'000'000LL, 1'000'000'000LL, 1LL << 40}) {
    EXPECT_REL(allan_variance(Flicker{1}, m, 1), flat, 1e-12) << m;
  }
}

TEST(Process, FlickerPhaseCovarianceBetweenWholeLags) {
  // h_n = (psi(n + 1/2) - psi(1/2))/2 has h_{1/2} = ln 2 and h_{n+1} = h_n + 1/(2n + 1); R/(B^2/(4 pi)) = (4
  // n^2 - 1) h_n.
  constexpr double kDt = 3;
  double harmonic = ln2;
  for (double n = 0.5; n < 1000; ++n) {
    const double expected = kDt * kDt / (4 * pi) * (4 * n * n - 1) * harmonic;
    EXPECT_NEAR(phase_covariance(Flicker{1}, n, kDt), expected, 1e-14 * std::abs(expected)) << n;
    harmonic += 1 / (2 * n + 1);
  }
}

TEST(Process, RateRandomWalkAllanVarianceOfSampledWalk) {
  EXPECT_REL(allan_variance(RateRandomWalk{1}, 1, 1), 1. / 2, kRounding);
  EXPECT_REL(allan_variance(RateRandomWalk{1}, 2, 1), 3. / 4, kRounding);
  EXPECT_REL(allan_variance(RateRandomWalk{1}, 3, 1), 19. / 18, kRounding);
  EXPECT_REL(allan_variance(RateRandomWalk{2}, 3, 0.01), 4 * 0.01 * 19. / 18, kRounding);
}

TEST(Process, GaussMarkovAllanVarianceOfSampledAr1) {
  // Innovation variance 1 means sigma^2 = 1/(1 - phi^2); theory note section 10.
  const auto ar1 = [](double phi) { return GaussMarkov{1 / std::sqrt(1 - phi * phi), -1 / std::log(phi)}; };
  EXPECT_REL(allan_variance(ar1(0.5), 1, 1), 2. / 3, kRounding);
  EXPECT_REL(allan_variance(ar1(0.5), 5, 1), 0.49322916666666666, kRounding);
  // log and exp of phi near 1 lose 1/(1 - phi) = 100 roundings.
  constexpr double kNearOne = 100 * kEpsilon;
  EXPECT_REL(allan_variance(ar1(0.99), 50, 1), 11.74914733751716, kNearOne);
  EXPECT_REL(allan_variance(ar1(0.99), 300, 1), 17.821446015208743, kNearOne);
}

TEST(Process, GaussMarkovIsWhiteWhenFastAndAWalkWhenSlow) {
  for (const std::int64_t m : {1, 10, 1000}) {
    const double M = static_cast<double>(m);
    EXPECT_REL(allan_variance(GaussMarkov{1, 1e-3}, m, 1), 1 / M, kRounding);
    EXPECT_REL(phase_covariance(GaussMarkov{1, 1e-3}, M, 1), -M / 2, kRounding);
    // q = 2 sigma^2/Tc = K^2; the next term is of relative order tau/Tc.
    constexpr double kTc = 1e12;
    const double walk = allan_variance(RateRandomWalk{std::sqrt(2 / kTc)}, m, 1);
    EXPECT_REL(allan_variance(GaussMarkov{1, kTc}, m, 1), walk, 2 * M / kTc + kRounding) << m;
  }
  // Extremes of dt/Tc stay finite.
  for (const double tc : {1e-300, 1e-200, 1e200, 1e300}) {
    for (const double lag : {0., 1., 1e9}) {
      EXPECT_TRUE(std::isfinite(phase_covariance(GaussMarkov{1, tc}, lag, 1))) << tc << ' ' << lag;
    }
    EXPECT_TRUE(std::isfinite(allan_variance(GaussMarkov{1, tc}, 1'000'000'000, 1))) << tc;
    EXPECT_TRUE(std::isfinite(psd(GaussMarkov{1, tc}, 0.1, 1))) << tc;
  }
}

TEST(Process, TextbookAsymptotesOfTheAllanVariance) {
  // IEEE Std 952-1997 annex C: slopes -1, -1/2, 0, +1/2, +1 of the deviation, read where each term is clean.
  constexpr double kDt = 0.01;
  const std::int64_t m = 100'000;
  const double tau = kDt * static_cast<double>(m);
  constexpr double kDiscrete = 1e-9;  // of order 1/m^2
  EXPECT_REL(allan_variance(Quantization{2}, m, kDt), 3 * 4 / (tau * tau), kRounding);
  EXPECT_REL(allan_variance(White{2}, m, kDt), 4 / tau, kRounding);
  EXPECT_REL(allan_variance(Flicker{2}, m, kDt), 4 * 2 * ln2 / pi, kDiscrete);
  EXPECT_REL(allan_variance(RateRandomWalk{2}, m, kDt), 4 * tau / 3, kDiscrete);
  EXPECT_REL(allan_variance(RateRamp{2}, m, kDt), 4 * tau * tau / 2, kRounding);
}

TEST(Process, PsdTendsToTheContinuousDefinition) {
  constexpr double kDt = 1e-3, kF = 1e-3;
  constexpr double kSampled = 4e-12;  // (pi f dt)^2 / 3
  const double w = 2 * pi * kF;
  EXPECT_REL(psd(Quantization{3}, kF, kDt), w * w * 9 * kDt, kSampled);
  EXPECT_REL(psd(White{3}, kF, kDt), 9, kRounding);
  EXPECT_REL(psd(Flicker{3}, kF, kDt), 9 / w, kSampled);
  EXPECT_REL(psd(RateRandomWalk{3}, kF, kDt), 9 / (w * w), kSampled);
  constexpr double kTc = 100;  // sampled density differs by dt/Tc squared
  EXPECT_REL(psd(GaussMarkov{3, kTc}, kF, kDt), 2 * 9 * kTc / (1 + w * w * kTc * kTc), 1e-9);
  EXPECT_EQ(psd(RateRamp{3}, kF, kDt), 0);
  EXPECT_EQ(psd(Sinusoid{3, 7}, kF, kDt), 0);
  EXPECT_EQ(psd(Sinusoid{3, 7}, 7, kDt), std::numeric_limits<double>::infinity());
}

TEST(Process, SinusoidAllanVariance) {
  constexpr double kDt = 0.01, kF0 = 0.7, kA = 2;
  for (const std::int64_t m : {1, 13, 71}) {
    const double M = static_cast<double>(m);
    const double s = std::sin(pi * kF0 * M * kDt), d = std::sin(pi * kF0 * kDt);
    EXPECT_REL(allan_variance(Sinusoid{kA, kF0}, m, kDt), kA * kA * std::pow(s, 4) / (M * M * d * d), 1e-12);
  }
  // Sampled once a cycle it is a constant.
  EXPECT_EQ(allan_variance(Sinusoid{kA, 100}, 5, kDt), 0);
  EXPECT_TRUE(std::isfinite(phase_covariance(Sinusoid{kA, 100}, 5, kDt)));
}

TEST(Process, SumsOfProcesses) {
  const std::vector<Process> gyro = {White{1}, Flicker{0.5}, RateRandomWalk{0.1}};
  double sum = 0;
  for (const Process& p : gyro) sum += allan_variance(p, 10, 0.1);
  EXPECT_EQ(allan_variance(gyro, 10, 0.1), sum);
  EXPECT_EQ(allan_variance(std::span<const Process>{}, 10, 0.1), 0);
}

TEST(Process, RefusesMisuseByNameValueAndUnit) {
  EXPECT_THROW((void)allan_variance(White{1}, 0, 1), std::invalid_argument);
  EXPECT_THROW((void)allan_variance(White{1}, 1, 0), std::invalid_argument);
  EXPECT_THROW((void)allan_variance(White{1}, 1, -1), std::invalid_argument);
  EXPECT_THROW((void)allan_variance(White{1}, 1, NAN), std::invalid_argument);
  EXPECT_THROW((void)allan_variance(White{1}, 1, INFINITY), std::invalid_argument);
  EXPECT_THROW((void)psd(White{1}, 0, 1), std::invalid_argument);
  EXPECT_THROW((void)psd(White{1}, 0.6, 1), std::invalid_argument);
  EXPECT_NO_THROW((void)psd(White{1}, 1 / (2 * 0.3), 0.3));
  EXPECT_THROW((void)structure_function(White{1}, -1, 1), std::invalid_argument);
  EXPECT_THROW((void)phase_covariance(White{1}, NAN, 1), std::invalid_argument);
  EXPECT_THROW((void)allan_variance(GaussMarkov{1, 0}, 1, 1), std::invalid_argument);
  try {
    (void)allan_variance(White{1}, -3, 1);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "averaging factor m is -3; it must be at least 1 (samples)");
  }
}

}  // namespace
}  // namespace gyrobudget::noise
