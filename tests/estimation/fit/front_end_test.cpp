// SPDX-License-Identifier: MIT
// Fits of sensors behind a low pass: the kind and its bandwidth are found, N is that of the noise in front of it, and
// the intervals allow for what is not known of the filter.
#include "gyrobudget/noise/front_end.h"

#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/estimation/fit/whittle.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/recorder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

namespace gyrobudget::fit {
namespace {

using noise::FrontEnd;
using noise::Term;
using Kind = FrontEnd::Kind;
using Sampling = FrontEnd::Sampling;
constexpr double kDt = 0.01;
constexpr double kN = 4.4e-5, kB = 3.4e-6, kK = 3.5e-7;

std::vector<double> record(const std::optional<FrontEnd>& front_end, std::int64_t samples, std::uint64_t run) {
  const noise::Process white =
      front_end ? noise::Process(noise::FilteredWhite{kN, *front_end}) : noise::Process(noise::White{kN});
  return noise::generate_record(std::vector<noise::Process>{white, noise::Flicker{kB}, noise::RateRandomWalk{kK}},
                                samples, kDt, {1503, run});
}

const FrontEnd kFirst{Kind::first_order, 3, Sampling::analogue};
const FrontEnd kSecond{Kind::second_order, 3, Sampling::bilinear};
const FrontEnd kAverage{Kind::moving_average, noise::kMovingAverageWidth / 16 / kDt, Sampling::analogue};

bool covers(const Coefficient& c, double truth) { return c.lower <= truth && truth <= c.upper_two_sided; }

// Every number of one record each is a draw: bandwidth and N lie within four standard deviations but for 1 in 16 000.
constexpr double kFarSigmas = 4;
bool is_near(const Coefficient& c, double truth) { return std::abs(c.value / truth - 1) < kFarSigmas * c.relative_std; }
bool is_near(const FittedFrontEnd& f, double truth) {
  const double deviation = std::log(f.upper / f.lower) / (2 * 1.96);
  return std::abs(std::log(f.bandwidth / truth)) < kFarSigmas * deviation;
}

TEST(FrontEndFit, FindsKindAndBandwidthByCurveAndLikelihood) {
  for (const FrontEnd& truth : {kFirst, kSecond, kAverage}) {
    const auto rate = record(truth, 100'000, 1);
    for (const Method method : {Method::gls, Method::whittle}) {
      SCOPED_TRACE(std::string(noise::name(truth.kind)) + " by " + std::string(name(method)));
      const Result result = fit({.rate = rate, .dt = kDt}, {.method = method});
      ASSERT_TRUE(result.front_end && result.front_end->kind);
      EXPECT_EQ(*result.front_end->kind, truth.kind);
      EXPECT_TRUE(result.front_end->fitted);
      EXPECT_TRUE(is_near(*result.front_end, truth.bandwidth)) << result.front_end->bandwidth;
      EXPECT_TRUE(is_near(result[Term::white], kN)) << result[Term::white].value;
      EXPECT_NE(result.verdict, Verdict::not_described);
    }
  }
}

TEST(FrontEndFit, AllowsForTheMemoryOfAFilterOfAnotherKind) {
  // Two second-order filters one behind the other: none of the kinds.
  auto rate = record(std::nullopt, 100'000, 2);
  for (int i = 0; i < 2; ++i) noise::FrontEndFilter(noise::SampledFrontEnd(kSecond, kDt))(rate);
  const Result result = fit({.rate = rate, .dt = kDt});
  ASSERT_TRUE(result.front_end);
  EXPECT_FALSE(result.front_end->kind);
  EXPECT_THROW((void)result.front_end->value(), std::logic_error);
  EXPECT_GT(result.tau_min_s, kDt);
  EXPECT_TRUE(is_near(result[Term::white], kN)) << result[Term::white].value;
  // -3 dB of both together: |H|^2 = 1/(1 + x^4) to 1/sqrt 2 each.
  const double bandwidth = kSecond.bandwidth * std::pow(std::sqrt(2.) - 1, 0.25);
  EXPECT_LT(result.front_end->lower, bandwidth);
  EXPECT_GT(result.front_end->upper, bandwidth);
}

TEST(FrontEndFit, FindsNoneInIdealNoise) {
  // A front end is looked for in one record of 10^4 for each of two tests: 30 records have none but for 1 in 160.
  for (std::uint64_t run = 0; run < 30; ++run)
    EXPECT_FALSE(fit({.rate = record(std::nullopt, 10'000, run), .dt = kDt}, {.intervals = false}).front_end) << run;
}

TEST(FrontEndFit, IntervalsOfNCover) {
  // Binomial with 0.95 in 24: fewer than 18 in one run of 7800.
  constexpr int kRecords = 24, kFewest = 18;
  for (const FrontEnd& truth : {FrontEnd{Kind::first_order, 10, Sampling::analogue}, kAverage}) {
    int covered = 0;
    for (std::uint64_t run = 0; run < kRecords; ++run)
      covered += covers(fit({.rate = record(truth, 20'000, run), .dt = kDt})[Term::white], kN);
    EXPECT_GE(covered, kFewest) << noise::name(truth.kind);
  }
}

TEST(FrontEndFit, AKnownFilterLeavesNMoreCertain) {
  const auto rate = record(kFirst, 50'000, 3);
  for (const Method method : {Method::gls, Method::whittle}) {
    Options options{.method = method};
    const Result searched = fit({.rate = rate, .dt = kDt}, options);
    options.front_end_kind = Kind::first_order;
    const Result of_kind = fit({.rate = rate, .dt = kDt}, options);
    options.front_end = kFirst;
    const Result given = fit({.rate = rate, .dt = kDt}, options);
    ASSERT_TRUE(given.front_end && of_kind.front_end && searched.front_end);
    EXPECT_FALSE(given.front_end->fitted);
    EXPECT_EQ(given.front_end->bandwidth, kFirst.bandwidth);
    EXPECT_TRUE(is_near(given[Term::white], kN));
    EXPECT_EQ(of_kind.front_end->kind, Kind::first_order);
    // The Cramer-Rao bounds are 4.7 apart at this corner.
    EXPECT_GT(of_kind[Term::white].relative_std, 3 * given[Term::white].relative_std);
  }
}

TEST(FrontEndFit, TheModelOfAResultIsBehindItsFilter) {
  const Result result = fit({.rate = record(kFirst, 50'000, 4), .dt = kDt});
  ASSERT_TRUE(result.front_end && result.front_end->kind);
  const auto processes = result.processes();
  ASSERT_FALSE(result.residuals.empty());
  const Residual& first = result.residuals.front();
  constexpr double kSlowPart = 0.01;  // what the filter takes off flicker and walk is in the fit's model only
  EXPECT_NEAR(std::sqrt(noise::allan_variance(processes, first.m, kDt)) / first.model, 1, kSlowPart);
}

TEST(FrontEndFit, AShiftMovesNAndAddsToItsIntervalInQuadrature) {
  Result result;
  result.coefficients = {{.term = Term::white,
                          .value = 2,
                          .lower = 1.9,
                          .upper = 2.2,
                          .upper_two_sided = 2.2,
                          .relative_std = 0.03,
                          .status = Status::identified,
                          .fitted = true},
                         {.term = Term::flicker, .value = 3, .lower = 2, .upper = 4, .fitted = true}};
  result.fitted_terms = {Term::white, Term::flicker};
  result.covariance = Eigen::MatrixXd::Constant(2, 2, 0.01);
  const double shift = std::log(1.1), sigma = 0.04;
  shift_white(result, {shift, sigma});
  const Coefficient& white = result.coefficients[0];
  EXPECT_DOUBLE_EQ(white.value, 2.2);
  EXPECT_NEAR(std::log(white.lower / 2.2), -std::hypot(std::log(2 / 1.9), 1.96 * sigma), 1e-14);
  EXPECT_NEAR(std::log(white.upper / 2.2), std::hypot(std::log(1.1), 1.96 * sigma), 1e-14);
  EXPECT_DOUBLE_EQ(white.relative_std, 0.05);
  EXPECT_NEAR(result.covariance(0, 0), 0.0121 + 2.2 * 2.2 * sigma * sigma, 1e-15);
  EXPECT_NEAR(result.covariance(0, 1), 0.011, 1e-15);
  EXPECT_EQ(result.covariance(1, 1), 0.01);
  EXPECT_EQ(result.coefficients[1].value, 3);
}

// Of a filter at three times the log's rate neither the analogue nor the bilinear form at the log's rate holds.
TEST(FrontEndFit, TellsTheRateAtWhichALowPassWasApplied) {
  constexpr double kBandwidth = 20, kStep = 0.01;
  const noise::Recorder recorder{.front_end = FrontEnd{Kind::first_order, kBandwidth}, .decimation = 3};
  const std::vector<noise::Process> white{noise::White{1}};
  const noise::RecorderGenerator generator(white, recorder, 200'000, kStep);
  const auto found = find_front_end(generator({5, 0}), kStep);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->front_end.kind, Kind::first_order);
  EXPECT_EQ(found->front_end.sampling, Sampling::bilinear);
  EXPECT_NEAR(1 / found->front_end.oversampling, 1. / 3, 0.1);  // a record of this length tells it to 0.03
  EXPECT_NEAR(found->front_end.bandwidth, kBandwidth, 1);
  EXPECT_GT(found->choice.sigma, 0);
}

}  // namespace
}  // namespace gyrobudget::fit
