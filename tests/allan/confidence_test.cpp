// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/confidence.h"

#include "gyrobudget/allan/covariance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::allan {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double edf_of(const noise::Process& process, std::int64_t samples, std::int64_t m, Form form = Form::full) {
  const noise::Process mix[] = {process};
  return equivalent_dof(samples, m, 1, mix, form);
}

// Direct sums over all lags in numpy (an implementation apart from this one), n = 3600, to the digits kept.
struct Row {
  std::int64_t m;
  double white, flicker, walk, half_digit;
};
constexpr Row kExactEdf[] = {{1, 2399.6, 2917.4, 3599.0, 0.05}, {4, 1250.4, 1085.5, 859.9, 0.05},
                             {16, 333.7, 262.5, 207.6, 0.05},   {64, 82.13, 63.97, 50.64, 0.005},
                             {256, 18.88, 14.65, 11.51, 0.005}, {900, 4.00, 3.00, 2.24, 0.005},
                             {1200, 2.67, 1.83, 1.40, 0.005},   {1600, 1.29, 1.08, 1.03, 0.005}};

TEST(EquivalentDof, AgreesWithDirectSums) {
  for (const Row& row : kExactEdf) {
    EXPECT_NEAR(edf_of(noise::White{1}, 3600, row.m), row.white, row.half_digit) << row.m;
    EXPECT_NEAR(edf_of(noise::Flicker{1}, 3600, row.m), row.flicker, row.half_digit) << row.m;
    EXPECT_NEAR(edf_of(noise::RateRandomWalk{1}, 3600, row.m), row.walk, row.half_digit) << row.m;
  }
}

TEST(EquivalentDof, ClosedForms) {
  // One term is chi-square with one degree of freedom, whatever the noise.
  for (const noise::Process& process :
       {noise::Process(noise::White{1}), noise::Process(noise::Flicker{1}), noise::Process(noise::Quantization{1})}) {
    EXPECT_NEAR(edf_of(process, 1000, 500), 1, 1e-12);
  }
  // Random walk at m = 1: n - 1 independent steps.
  EXPECT_NEAR(edf_of(noise::RateRandomWalk{1}, 3600, 1), 3599, 1e-6);
  // White noise at m = 1: differences with neighbours correlated by -1/2, so 1/edf = (M + (M-1)/2) / M^2, M = n - 1.
  constexpr double kTerms = 3599;
  EXPECT_NEAR(edf_of(noise::White{1}, 3600, 1), kTerms * kTerms / (kTerms + (kTerms - 1) / 2), 1e-6);
}

TEST(EquivalentDof, IsThatOfTheCovarianceMatrix) {
  const std::vector<noise::Process> mix{noise::White{2e-5}, noise::Flicker{1e-6}, noise::RateRandomWalk{3e-8},
                                        noise::RateRamp{1e-9}};
  const CurveCovariance covariance(20'000, {1, 30, 700}, 0.1, mix);
  const Eigen::Vector4d theta(4e-10, 1e-12, 9e-16, 1e-18);
  const Eigen::VectorXd expected = covariance.expectation() * theta;
  const Eigen::MatrixXd S = covariance(theta);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::int64_t m = covariance.factors()[static_cast<std::size_t>(i)];
    EXPECT_NEAR(equivalent_dof(20'000, m, 0.1, mix) / (2 * expected[i] * expected[i] / S(i, i)), 1, 1e-12);
  }
}

TEST(EquivalentDof, KnowsNoScale) {
  for (const double scale : {1e-200, 1., 1e200}) {
    const noise::Process mix[] = {noise::White{scale}, noise::Flicker{scale / 3}};
    EXPECT_NEAR(equivalent_dof(1000, 10, 1, mix), edf_of(noise::White{1}, 1000, 10), 10);
    EXPECT_TRUE(std::isfinite(equivalent_dof(1000, 10, 1, mix)));
  }
}

TEST(EquivalentDof, OfMeansAloneIsInfiniteAndOfNothingThrows) {
  EXPECT_EQ(edf_of(noise::RateRamp{1}, 1000, 10), kInfinity);
  EXPECT_THROW((void)edf_of(noise::White{0}, 1000, 10), std::invalid_argument);
  EXPECT_THROW((void)equivalent_dof(1000, 10, 1, {}), std::invalid_argument);
  EXPECT_THROW((void)edf_of(noise::White{1}, 1000, 501), std::invalid_argument);
  EXPECT_TRUE(std::isnan(edf_of(noise::White{1}, 1000, 500, Form::ieee)));
  EXPECT_EQ(edf_of(noise::White{1}, 1000, 499, Form::ieee), edf_of(noise::White{1}, 999, 499));
}

// ---- intervals -------------------------------------------------------------------------------------------------

TEST(ChiSquareInterval, TabulatedQuantiles) {
  // Chi-square quantiles at 2.5 % and 97.5 %: any table, e.g. NIST/SEMATECH e-Handbook of Statistical Methods
  // 1.3.6.7.4.
  const struct { double edf, low, high; } rows[] = {{1, 0.001, 5.024}, {10, 3.247, 20.483}, {100, 74.222, 129.561}};
  for (const auto& row : rows) {
    const Interval interval = chi_square_interval(1, row.edf);
    EXPECT_NEAR(row.edf / interval.lower, row.high, 5e-4);
    EXPECT_NEAR(row.edf / interval.upper, row.low, 5e-4);
  }
}

TEST(ChiSquareInterval, ClosedFormAtTwoDegrees) {
  // With two degrees of freedom chi-square is exponential: quantile -2 ln(1 - p).
  const Interval interval = chi_square_interval(3, 2, 0.9);
  EXPECT_NEAR(interval.lower, 3 * 2 / (-2 * std::log(0.05)), 1e-12);
  EXPECT_NEAR(interval.upper, 3 * 2 / (-2 * std::log(0.95)), 1e-11);
}

TEST(ChiSquareInterval, HoldsAtExtremes) {
  const Interval large = chi_square_interval(1, 1e9);
  EXPECT_NEAR(large.lower, 1 - 1.959964 * std::sqrt(2e-9), 1e-8);
  EXPECT_NEAR(large.upper, 1 + 1.959964 * std::sqrt(2e-9), 1e-8);
  EXPECT_EQ(chi_square_interval(5, kInfinity).lower, 5);
  EXPECT_EQ(chi_square_interval(5, kInfinity).upper, 5);
  EXPECT_EQ(chi_square_interval(1, 1e-3).upper, kInfinity);
  EXPECT_EQ(chi_square_interval(0, 4).upper, 0);
  EXPECT_TRUE(std::isnan(chi_square_interval(kNaN, 4).lower));
  EXPECT_TRUE(std::isnan(chi_square_interval(1, kNaN).upper));
  double narrower = kInfinity;
  for (const double edf : {0.5, 1., 1.03, 2.24, 18.88, 2399.6}) {
    const Interval interval = chi_square_interval(1, edf);
    EXPECT_LT(interval.lower, 1);
    EXPECT_GT(interval.upper, 1);
    EXPECT_LT(interval.upper, narrower);
    narrower = interval.upper;
  }
}

TEST(ChiSquareInterval, MisuseThrows) {
  for (const double edf : {0., -1.}) EXPECT_THROW((void)chi_square_interval(1, edf), std::invalid_argument);
  for (const double p : {0., 1., -0.1, 1.1, kNaN}) {
    EXPECT_THROW((void)chi_square_interval(1, 1, p), std::invalid_argument);
  }
}

}  // namespace
}  // namespace gyrobudget::allan
