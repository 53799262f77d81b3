// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/requirement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace gyrobudget::fit {
namespace {

using noise::Term;

Accuracy measured() {
  Accuracy a;
  MethodAccuracy gls;
  gls.p_below_5_percent = 0.06;
  gls.coefficients = {
      {.term = Term::white,
       .truth = 1,
       .bias = -0.02,
       .rmse = 0.11,
       .bound = 0.1,
       .over_likelihood = 1.01,
       .coverage = 0.95},
      {.term = Term::flicker, .truth = 0, .coverage = 0.99},
      {.term = Term::rate_random_walk, .truth = 1, .rmse = 0.3, .bound = 0.25, .over_likelihood = 1, .coverage = 0.92}};
  MethodAccuracy edf = gls;
  edf.method = Method::edf;
  edf.coefficients[0].rmse = 0.2;
  a.methods = {gls, edf};
  return a;
}

std::vector<Check> checked(const char* text) { return check(parse_requirements(text), measured()); }

TEST(Requirements, ReadsTheExampleOfTheHelp) {
  const auto list = parse_requirements("arw.rmse<1.1*crlb, coverage in 0.93..0.97");
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].term, Term::white);
  EXPECT_EQ(list[0].quantity, Quantity::rmse);
  EXPECT_EQ(list[0].relative, Requirement::Relative::bound);
  EXPECT_EQ(list[0].high, 1.1);
  EXPECT_TRUE(list[0].strict);
  EXPECT_EQ(list[0].text, "arw.rmse<1.1*crlb");
  EXPECT_FALSE(list[1].term);
  EXPECT_EQ(list[1].low, 0.93);
  EXPECT_EQ(list[1].high, 0.97);
  EXPECT_FALSE(list[1].strict);
}

TEST(Requirements, ReadsMethodsLettersAndBothSigns) {
  const auto list =
      parse_requirements("edf.K.bias <= 5e-2,whittle.p05>0.03 , accel_rw.identified>=.5,vrw.rmse<1.02 * likelihood");
  ASSERT_EQ(list.size(), 4U);
  EXPECT_EQ(list[0].method, Method::edf);
  EXPECT_EQ(list[0].term, Term::rate_random_walk);
  EXPECT_FALSE(list[0].strict);
  EXPECT_EQ(list[1].method, Method::whittle);
  EXPECT_EQ(list[1].quantity, Quantity::p05);
  EXPECT_EQ(list[1].low, 0.03);
  EXPECT_EQ(list[2].term, Term::rate_random_walk);
  EXPECT_EQ(list[3].term, Term::white);
  EXPECT_EQ(list[3].relative, Requirement::Relative::likelihood);
}

TEST(Requirements, HoldEveryCoefficientThatIsThere) {
  const auto coverage = checked("coverage in 0.93..0.97");
  ASSERT_EQ(coverage.size(), 2U);  // not of the flicker that the sensor has not
  EXPECT_TRUE(coverage[0].met);
  EXPECT_EQ(coverage[1].term, Term::rate_random_walk);
  EXPECT_FALSE(coverage[1].met);
  EXPECT_FALSE(checked("arw.rmse<1.09*crlb").front().met);
  EXPECT_TRUE(checked("arw.rmse<=1.11*crlb").front().met);
  EXPECT_TRUE(checked("arw.bias<0.03").front().met);
  EXPECT_FALSE(checked("edf.arw.rmse<0.15").front().met);
  EXPECT_TRUE(checked("p05<0.065").front().met);
  EXPECT_TRUE(checked("arw.rmse<1.02*likelihood").front().met);
}

TEST(Requirements, ThatAreAboutNothingAreNotMet) {
  for (const char* text : {"whittle.p05<1", "rate_ramp.coverage>0"}) {
    const auto checks = checked(text);
    ASSERT_EQ(checks.size(), 1U);
    EXPECT_FALSE(checks.front().met);
    EXPECT_TRUE(std::isnan(checks.front().value));
  }
}

// Where it went wrong, what stood there and what may.
TEST(Requirements, SayWhatIsWrongAndWhere) {
  const std::pair<const char*, const char*> kCases[] = {
      {"", "column 1: found the end"},
      {"arw.rmsee<1", "column 5: found 'rmsee<1'; expected a quantity (rmse, bias"},
      {"arw<1", "column 4: found '<1'; expected '.'"},
      {"arw.rmse", "column 9: found the end; expected <"},
      {"arw.rmse<fast", "column 10: found 'fast'; expected a number"},
      {"arw.rmse<1*cramer", "column 12: found 'cramer'; expected crlb or likelihood"},
      {"arw.bias<1*crlb", "only rmse"},
      {"coverage in 0.97..0.93", "the upper limit is below the lower"},
      {"coverage in 0.93", "expected '..'"},
      {"coverage in 0.93..0.97 arw.rmse<1", "column 24: found 'arw.rmse<1'; expected a comma"},
      {"arw.p05<1", "of a method"},
      {"gls.edf.rmse<1", "column 5"},
      {"rmse<nan", "expected a number"},
      {"rmse<1,", "column 8: found the end"},
  };
  for (const auto& [text, expected] : kCases) {
    try {
      (void)parse_requirements(text);
      ADD_FAILURE() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << text << " -> " << error.what();
    }
  }
}

}  // namespace
}  // namespace gyrobudget::fit
