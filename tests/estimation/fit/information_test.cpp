// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/information.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sensors.h"
#include <Eigen/LU>

namespace gyrobudget::fit {
namespace {

constexpr double kHour = 3600;

TEST(FisherInformation, OfWhiteNoiseIsHalfTheNumberOfDifferences) {
  const std::array<noise::Process, 1> white{noise::White{3}};
  for (const std::int64_t n : {3L, 100L, 5000L, 1000000L, 1000000000L}) {
    const double expected = 0.5 * static_cast<double>(n - 1);
    EXPECT_NEAR(fisher_information(white, n, 0.01)(0, 0) / expected, 1, 1e-9) << n;
  }
}

// The quadrature against the plain sum over every k.
TEST(FisherInformation, QuadratureEqualsTheSum) {
  const auto processes = tests::mems().processes();
  constexpr std::int64_t kSamples = 200000;
  constexpr double kDt = 0.01, kQuadrature = 1e-7;  // the stated bound
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::int64_t k = 1; k < kSamples; ++k) {
    Eigen::Vector3d g;
    for (int a = 0; a < 3; ++a) {
      g(a) = noise::psd(processes[static_cast<std::size_t>(a)], static_cast<double>(k) / (2 * kSamples * kDt), kDt);
    }
    g /= g.sum();
    sum += 0.5 * g * g.transpose();
  }
  const Eigen::MatrixXd found = fisher_information(processes, kSamples, kDt);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) EXPECT_NEAR(found(a, b) / sum(a, b), 1, kQuadrature) << a << b;
  }
}

// The exact Gaussian information 1/2 tr(C^-1 C_a C^-1 C_b) of the differenced record of white noise plus random walk,
// which the DST-I diagonalises exactly.
TEST(FisherInformation, IsExactForWhitePlusWalk) {
  constexpr int kDifferences = 60;
  const double N2 = 2, K2 = 0.3;
  Eigen::MatrixXd white = Eigen::MatrixXd::Zero(kDifferences, kDifferences);
  for (int i = 0; i < kDifferences; ++i) {
    white(i, i) = 2 * N2;
    if (i > 0) white(i, i - 1) = white(i - 1, i) = -N2;
  }
  const Eigen::MatrixXd walk = Eigen::MatrixXd::Identity(kDifferences, kDifferences) * K2;
  const Eigen::MatrixXd inverse = (white + walk).inverse();
  const std::array<noise::Process, 2> processes{noise::White{std::sqrt(N2)}, noise::RateRandomWalk{std::sqrt(K2)}};
  const Eigen::MatrixXd found = fisher_information(processes, kDifferences + 1, 1);
  EXPECT_NEAR(found(0, 0), 0.5 * (inverse * white * inverse * white).trace(), 1e-9);
  EXPECT_NEAR(found(0, 1), 0.5 * (inverse * white * inverse * walk).trace(), 1e-9);
  EXPECT_NEAR(found(1, 1), 0.5 * (inverse * walk * inverse * walk).trace(), 1e-9);
}

// Theory section 6: Cramer-Rao bounds of 10 h, printed there to three digits.
TEST(RelativeBound, OfThePapersGyros) {
  constexpr double kPrinted = 6e-3;
  const auto ifog = relative_bound(tests::ifog().processes(), 3600000, 0.01);
  EXPECT_NEAR(ifog(0) / 3.75e-4, 1, kPrinted);
  EXPECT_NEAR(ifog(1) / 0.541, 1, kPrinted);
  EXPECT_NEAR(ifog(2) / 0.0668, 1, kPrinted);
  const auto mems = relative_bound(tests::mems().processes(), 3600000, 0.01);
  EXPECT_NEAR(mems(0) / 3.74e-4, 1, kPrinted);
  EXPECT_NEAR(mems(1) / 0.166, 1, kPrinted);
  EXPECT_NEAR(mems(2) / 0.126, 1, kPrinted);
  const auto slow = relative_bound(tests::ifog().processes(), 36000, 1);
  EXPECT_NEAR(slow(0) / 4.45e-3, 1, kPrinted);
  EXPECT_NEAR(slow(1) / 0.633, 1, kPrinted);
  EXPECT_NEAR(slow(2) / 0.070, 1, kPrinted);
}

// Of white noise behind a first-order filter alone: I of ln N^2 and ln w by a plain sum, d ln S/d ln w in closed form.
TEST(RelativeBound, OfFilteredNoiseWhoseBandwidthIsUnknown) {
  constexpr std::int64_t kSamples = 131'072;
  constexpr double kDt = 0.01, kCorner = 0.03, kQuadrature = 1e-6, kPi = 3.14159265358979324;
  const std::array<noise::Process, 1> white{
      noise::FilteredWhite{2, {noise::FrontEnd::Kind::first_order, kCorner / kDt}}};
  const double w = 2 * kPi * kCorner, a = std::exp(-w);
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (std::int64_t k = 1; k < kSamples; ++k) {
    const double c = std::cos(kPi * static_cast<double>(k) / static_cast<double>(kSamples));
    const double slope = w * a * (2 / (1 - a) + (2 * a - 2 * c) / (1 - 2 * a * c + a * a));
    const Eigen::Vector2d g(1, slope);
    information += 0.5 * g * g.transpose();
  }
  const double expected = 0.5 * std::sqrt(information.inverse()(0, 0));
  const double known = relative_bound(white, kSamples, kDt)(0);
  EXPECT_NEAR(known * std::sqrt(2. * (kSamples - 1)), 1, kQuadrature);
  EXPECT_NEAR(relative_bound_unknown_bandwidth(white, kSamples, kDt)(0) / expected, 1, kQuadrature);
  EXPECT_NEAR(expected / known, 4.7, 0.05);  // the price of not knowing it, for this corner
  // Without a filter there is nothing to know.
  EXPECT_EQ(relative_bound_unknown_bandwidth(tests::mems().processes(), kSamples, kDt),
            relative_bound(tests::mems().processes(), kSamples, kDt));
}

// Theory section 6: 27.4 h and 293 h for bias instability to 10 %; 4.5 h and 15.8 h for rate random walk.
TEST(DurationFor, OfThePapersGyros) {
  constexpr double kPrinted = 1e-2;
  EXPECT_NEAR(duration_for(tests::mems().processes(), 1, 0.1, 0.01) / (27.4 * kHour), 1, kPrinted);
  EXPECT_NEAR(duration_for(tests::ifog().processes(), 1, 0.1, 0.01) / (293 * kHour), 1, kPrinted);
  EXPECT_NEAR(duration_for(tests::ifog().processes(), 2, 0.1, 0.01) / (4.5 * kHour), 1, 2e-2);
  EXPECT_NEAR(duration_for(tests::mems().processes(), 2, 0.1, 0.01) / (15.8 * kHour), 1, kPrinted);
}

TEST(DurationFor, IsInfiniteWhereNoRecordWouldDo) {
  const std::array<noise::Process, 2> hopeless{noise::White{1}, noise::Flicker{1e-12}};
  EXPECT_TRUE(std::isinf(duration_for(hopeless, 1, 0.1, 0.01)));
}

TEST(RelativeBound, RefusesWhatHasNoInformation) {
  const std::array<noise::Process, 1> ramp{noise::RateRamp{1}}, zero{noise::White{0}};
  EXPECT_THROW((void)relative_bound(ramp, 100, 1), std::invalid_argument);
  EXPECT_THROW((void)relative_bound(zero, 100, 1), std::invalid_argument);
  EXPECT_THROW((void)relative_bound({}, 100, 1), std::invalid_argument);
  const std::array<noise::Process, 1> white{noise::White{1}};
  EXPECT_THROW((void)relative_bound(white, 2, 1), std::invalid_argument);
  EXPECT_THROW((void)relative_bound(white, 100, 0), std::invalid_argument);
  EXPECT_THROW((void)duration_for(white, 1, 0.1, 1), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::fit
