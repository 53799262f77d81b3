// SPDX-License-Identifier: MIT
// A small sweep, its numbers compared with those that measure_accuracy has of the same records.
#include "gyrobudget/estimation/fit/sweep.h"

#include "gyrobudget/estimation/fit/accuracy.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "sensors.h"

namespace gyrobudget::fit {
namespace {

constexpr std::int64_t kSamples = 600;
constexpr int kRecords = 6;

SweepOptions small() { return {.samples = kSamples, .longest = 0, .records = kRecords, .seed = 7}; }

std::vector<SweepRow> rows_of(const Sweep& sweep, Comparison comparison) {
  std::vector<SweepRow> rows;
  std::ranges::copy_if(sweep.rows, std::back_inserter(rows),
                       [&](const SweepRow& row) { return row.comparison == comparison; });
  return rows;
}

TEST(Sweep, MethodsHaveTheErrorsThatAStudyOfTheSameRecordsFinds) {
  const auto truth = tests::mems().processes();
  const Sweep swept = sweep(truth, small());
  EXPECT_TRUE(swept.complete);
  AccuracyOptions options{.samples = kSamples, .records = kRecords, .seed = 7};
  options.methods = {kMethods.begin(), kMethods.end()};
  options.fit.tau_min_s = options.dt;
  const Accuracy accuracy = measure_accuracy(truth, options);
  const auto rows = rows_of(swept, Comparison::method);
  ASSERT_EQ(rows.size(), kMethods.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].way, (Way{.method = kMethods[i]}));
    EXPECT_EQ(rows[i].records, kRecords);
    ASSERT_EQ(rows[i].coefficients.size(), 3U);
    for (std::size_t t = 0; t < 3; ++t) {
      const SweptCoefficient& c = rows[i].coefficients[t];
      const CoefficientAccuracy& expected = accuracy.methods[i].coefficients[t];
      EXPECT_EQ(c.term, expected.term);
      EXPECT_DOUBLE_EQ(c.rmse, expected.rmse) << name(kMethods[i]);
      EXPECT_DOUBLE_EQ(c.over_bound, expected.rmse / expected.bound) << name(kMethods[i]);
      EXPECT_DOUBLE_EQ(c.coverage, expected.coverage) << name(kMethods[i]);
    }
  }
}

TEST(Sweep, EveryGroupHoldsTheDefaultWhoseRatioIsOne) {
  const Sweep swept = sweep(tests::mems().processes(), small());
  for (const auto& [comparison, size] : {std::pair{Comparison::method, 6},
                                         {Comparison::covariance, 3},
                                         {Comparison::taus_an_octave, 3},
                                         {Comparison::stride, 8},
                                         {Comparison::record_length, 0}}) {
    const auto rows = rows_of(swept, comparison);
    EXPECT_EQ(rows.size(), static_cast<std::size_t>(size));
    if (rows.empty()) continue;
    const auto standard = std::ranges::find(rows, Way{}, &SweepRow::way);
    ASSERT_NE(standard, rows.end());
    for (const auto& c : standard->coefficients) EXPECT_EQ(c.over_default, 1);
    const bool others_differ = std::ranges::any_of(
        rows, [](const SweepRow& row) { return row.way != Way{} && row.coefficients.front().over_default != 1; });
    EXPECT_TRUE(others_differ);
  }
}

TEST(Sweep, LengthsGoByDecades) {
  SweepOptions options = small();
  options.longest = 99'999;
  options.records = 2;
  const auto rows = rows_of(sweep(tests::mems().processes(), options), Comparison::record_length);
  ASSERT_EQ(rows.size(), 3U);  // of 10^4 samples alone
  for (const auto& row : rows) EXPECT_EQ(row.samples, 10'000);
  EXPECT_EQ(rows[1].way, (Way{.overlap = 16}));
  EXPECT_EQ(rows[2].way, (Way{.method = Method::whittle}));
}

TEST(Sweep, ErrorsAreTheSameForAnyNumberOfThreads) {
  const auto truth = tests::mems().processes();
  const Sweep many = sweep(truth, small());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Sweep single = sweep(truth, small());
  ASSERT_EQ(many.rows.size(), single.rows.size());
  for (std::size_t i = 0; i < many.rows.size(); ++i) {
    for (std::size_t t = 0; t < many.rows[i].coefficients.size(); ++t) {
      const double a = many.rows[i].coefficients[t].rmse, b = single.rows[i].coefficients[t].rmse;
      EXPECT_TRUE(a == b || (a != a && b != b));
    }
  }
}

TEST(Sweep, ACancelledOneSaysSo) {
  const std::atomic<bool> cancel = true;
  SweepOptions options = small();
  options.cancel = &cancel;
  const Sweep swept = sweep(tests::mems().processes(), options);
  EXPECT_FALSE(swept.complete);
  EXPECT_TRUE(swept.rows.empty());
}

TEST(Sweep, ProgressEndsAtAllTheWork) {
  SweepOptions options = small();
  double last = 0, all = 0;
  options.progress = [&](double done, double of) {
    EXPECT_GT(done, last);
    last = done, all = of;
  };
  (void)sweep(tests::mems().processes(), options);
  EXPECT_GT(all, 0);
  EXPECT_DOUBLE_EQ(last, all);
}

TEST(Sweep, RefusesWhatItCannotMeasure) {
  const auto truth = tests::mems().processes();
  EXPECT_THROW((void)sweep({}, small()), std::invalid_argument);
  EXPECT_THROW((void)sweep({noise::White{0}}, small()), std::invalid_argument);
  EXPECT_THROW((void)sweep(truth, {.samples = 15}), std::invalid_argument);
  EXPECT_THROW((void)sweep(truth, {.records = 0}), std::invalid_argument);
}

TEST(TermsToMeasure, AreTheDefaultsAndWhatElseTheTruthHas) {
  using noise::Term;
  using Terms = std::vector<Term>;
  EXPECT_EQ(terms_to_measure({noise::White{1}}), (Terms{Term::white, Term::flicker, Term::rate_random_walk}));
  EXPECT_EQ(terms_to_measure({noise::RateRamp{1}, noise::Quantization{1}}),
            (Terms{Term::white, Term::flicker, Term::rate_random_walk, Term::quantization, Term::rate_ramp}));
}

}  // namespace
}  // namespace gyrobudget::fit
