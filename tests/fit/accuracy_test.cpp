// SPDX-License-Identifier: MIT
// The 200-record version of fit_study, with limits from the binomial and chi-square laws.
#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>

#include <cmath>

#include "study.h"

namespace gyrobudget::tests {
namespace {

constexpr int kRecords = 200;
constexpr double kFalseAlarm = 1e-4;  // of each comparison

// Coverage whose truth lies anywhere in [low, high]: the record counts that this leaves possible.
void expect_coverage(const CoefficientStudy& c, double low, double high) {
  using Binomial = boost::math::binomial_distribution<>;
  const double least = boost::math::quantile(Binomial(kRecords, low), kFalseAlarm / 2);
  const double most = boost::math::quantile(complement(Binomial(kRecords, high), kFalseAlarm / 2));
  const double count = c.coverage * kRecords;
  EXPECT_GE(count, least - 0.5);
  EXPECT_LE(count, most + 0.5);
}

// RMSE of about normal estimates: records * (rmse/truth)^2 is chi-square. Theory's own value has 3.5 % standard error.
void expect_rmse(const CoefficientStudy& c, double theory) {
  using ChiSquare = boost::math::chi_squared_distribution<>;
  constexpr double kTheoryError = 3.89 * 0.035;  // 1e-4 two-sided
  const double high =
      std::sqrt(boost::math::quantile(complement(ChiSquare(kRecords), kFalseAlarm / 2)) / kRecords);
  const double low = std::sqrt(boost::math::quantile(ChiSquare(kRecords), kFalseAlarm / 2) / kRecords);
  EXPECT_GT(c.rmse, theory * (low - kTheoryError));
  EXPECT_LT(c.rmse, theory * (high + kTheoryError));
}

TEST(Study, FibreOpticGyro) {
  const Study study = run_study(ifog(), kRecords, 36000, 1, 20261122);
  EXPECT_EQ(study.unconverged, 0);
  expect_coverage(study.coefficients[0], 0.935, 0.965);
  expect_coverage(study.coefficients[1], 0.935, 0.985);  // relative std above 30 %
  expect_coverage(study.coefficients[2], 0.935, 0.965);
  expect_rmse(study.coefficients[0], 0.00429);
  expect_rmse(study.coefficients[1], 0.609);
  expect_rmse(study.coefficients[2], 0.068);
}

TEST(Study, MemsGyro) {
  const Study study = run_study(mems(), kRecords, 36000, 1, 20261122);
  EXPECT_EQ(study.unconverged, 0);
  for (const auto& c : study.coefficients) expect_coverage(c, 0.935, 0.965);
  expect_rmse(study.coefficients[0], 0.00415);
  expect_rmse(study.coefficients[1], 0.205);
  expect_rmse(study.coefficients[2], 0.132);
}

}  // namespace
}  // namespace gyrobudget::tests
