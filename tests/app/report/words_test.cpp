// SPDX-License-Identifier: MIT
#include "gyrobudget/app/report/words.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "fixtures.h"

namespace gyrobudget::report {
namespace {

using noise::Signal;
using noise::Term;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Words, NumberKeepsSignificantDigits) {
  EXPECT_EQ(number(0), "0");
  EXPECT_EQ(number(0.0017), "0.001700");
  EXPECT_EQ(number(0.0017, 2), "0.0017");
  EXPECT_EQ(number(12.345), "12.35");  // 12.345 is above its decimal value in binary
  EXPECT_EQ(number(-9), "-9.000");
  EXPECT_EQ(number(41234.5), "41234");
  EXPECT_EQ(number(3.3937e-6), "3.394e-06");
  EXPECT_EQ(number(2.5e6), "2.500e+06");
  EXPECT_EQ(number(kNan), "-");
  EXPECT_EQ(number(kInfinity), "infinite");
}

TEST(Words, PercentHasTwoDigits) {
  EXPECT_EQ(percent(0.0431), "4.3 %");
  EXPECT_EQ(percent(0.4341), "43 %");
  EXPECT_EQ(percent(2.6), "260 %");
  EXPECT_EQ(percent(kNan), "-");
}

TEST(Words, TimesAreReadable) {
  EXPECT_EQ(tau_text(0.01), "0.01 s");
  EXPECT_EQ(tau_text(5242.88), "5243 s");
  EXPECT_EQ(tau_text(10485.76), "10486 s");
}

TEST(Words, SiUnitIsParsedBackToItsDimension) {
  for (const Signal signal : {Signal::angular_rate, Signal::specific_force, Signal::dimensionless}) {
    for (const Term term : reading_order()) {
      const auto dimension = noise::dimension_of(signal, term);
      const std::string unit = si_unit(dimension);
      EXPECT_EQ(noise::parse_unit(unit).dimension, dimension) << unit;
      EXPECT_EQ(noise::parse_unit(unit).to_si, 1) << unit;
    }
  }
  EXPECT_EQ(si_unit(noise::dimension_of(Signal::angular_rate, Term::white)), "rad/sqrt(s)");
  EXPECT_EQ(si_unit(noise::dimension_of(Signal::angular_rate, Term::rate_random_walk)), "rad/s/sqrt(s)");
  EXPECT_EQ(si_unit(noise::dimension_of(Signal::specific_force, Term::rate_random_walk)), "m/s^2/sqrt(s)");
}

fit::Coefficient coefficient(double value, double lower, double upper, double relative_std) {
  fit::Coefficient c;
  c.value = value;
  c.lower = lower;
  c.upper = upper;
  c.relative_std = relative_std;
  c.fitted = true;
  c.status = fit::Status::identified;
  return c;
}

TEST(Words, DigitsFollowTheStandardDeviation) {
  const auto text = coefficient_text(coefficient(1.7e-3, 2.2e-4, 3.4e-3, 0.54), 1, "deg/h");
  EXPECT_EQ(text.value, "0.00170 ± 0.00092");
  EXPECT_EQ(text.interval, "0.00022 to 0.00340");
  const auto fine = coefficient_text(coefficient(0.15, 0.149887, 0.150115, 3.75e-4), 1, "deg/sqrt(h)");
  EXPECT_EQ(fine.value, "0.150000 ± 0.000056");
}

TEST(Words, SmallValuesShareOnePowerOfTen) {
  const auto text = coefficient_text(coefficient(3.3937e-6, 2.27e-6, 4.55e-6, 0.166), 1, "rad/s");
  EXPECT_EQ(text.value, "(3.39 ± 0.56)e-06");
  EXPECT_EQ(text.interval, "(2.27 to 4.55)e-06");
}

TEST(Words, ZeroHasNoStandardDeviation) {
  const auto text = coefficient_text(coefficient(0, 0, 1.42, kInfinity), 1, "deg/h");
  EXPECT_EQ(text.value, "0");
  EXPECT_EQ(text.interval, "0 to 1.42");
  const auto all_zero = coefficient_text(coefficient(0, 0, 0, kInfinity), 1, "deg/h");
  EXPECT_EQ(all_zero.value, "0");
}

TEST(Words, AnUpperLimitThatWasNotFoundIsSaid) {
  EXPECT_EQ(coefficient_text(coefficient(0.7, 0, kInfinity, kInfinity), 1, "deg/h").interval, "no limit");
  EXPECT_EQ(coefficient_text(coefficient(0.7, 0.25, kInfinity, 0.3), 1, "deg/h").interval, "above 0.25, no limit");
  LogResult result = fixtures::bounded();
  fit::Result& fit = *result.axes.front().fit;
  for (fit::Coefficient& c : fit.coefficients) c.upper = kInfinity;
  const fit::Coefficient& flicker = *find(fit, Term::flicker);
  EXPECT_EQ(status_text(Signal::angular_rate, flicker, fit), "upper bound: no limit found");
  EXPECT_NE(minimum_text(result.axes.front(), 100).find("sets no limit to the flicker floor"), std::string::npos);
}

TEST(Words, SharesOfTheVarianceAddUpToOne) {
  // MEMS at the crossing sqrt(3) N/K: N and K contribute N K/sqrt(3) each, B 2 ln 2/pi B^2 (asymptotes).
  const LogResult result = fixtures::mems();
  const auto shares = variance_shares(*result.axes.front().fit, 216.5, result.rate_hz);
  ASSERT_EQ(shares.size(), 3U);
  const double crossing = 9 * 0.072 / std::sqrt(3.0), floor = 2 * std::log(2.0) / M_PI * 0.49;
  constexpr double kDiscrete = 1e-3;  // sampled forms differ from the asymptotes by less at m = 21650
  EXPECT_NEAR(shares[0].part, crossing / (2 * crossing + floor), kDiscrete);
  EXPECT_NEAR(shares[1].part, floor / (2 * crossing + floor), kDiscrete);
  EXPECT_NEAR(shares[0].part + shares[1].part + shares[2].part, 1, 1e-12);
}

TEST(Words, UntestedAndUnconvergedFitsSaySo) {
  fit::Result fit = *fixtures::mems().axes.front().fit;
  fit.dof = 0;
  EXPECT_EQ(verdict_headline(fit), "not tested");
  EXPECT_NE(consequence_text(fit).find("longer record"), std::string::npos);
  fit.converged = false;
  EXPECT_EQ(verdict_headline(fit), "the fit did not converge");
  EXPECT_NE(consequence_text(fit).find("Do not use"), std::string::npos);
}

TEST(Words, VisualReadingClaimsNoTest) {
  fit::Result fit = *fixtures::mems().axes.front().fit;
  fit.method = fit::Method::visual;
  fit.p_value = kNan;
  EXPECT_EQ(verdict_headline(fit), "read off the curve");
  EXPECT_EQ(verdict_text(fit).find("p ="), std::string::npos);
  EXPECT_EQ(status_text(Signal::angular_rate, fit.coefficients[1], fit), "read off the curve");
}

}  // namespace
}  // namespace gyrobudget::report
