// SPDX-License-Identifier: MIT
// The likelihood of records with gaps: all of a record counts, and what it says covers.
#include "gyrobudget/estimation/fit/detail/fill.h"
#include "gyrobudget/estimation/fit/selection.h"
#include "gyrobudget/estimation/fit/whittle.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sensors.h"

namespace gyrobudget::fit {
namespace {

using noise::Term;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A share of the samples, picked one by one.
void scatter_gaps(std::vector<double>& rate, double share, std::uint64_t stream) {
  std::vector<double> uniform(rate.size());
  noise::fill_uniform({.seed = 9, .stream = stream}, 0, uniform);
  for (std::size_t i = 0; i < rate.size(); ++i) {
    if (uniform[i] < share) rate[i] = kNaN;
  }
}

// Stretches of one sensor with `gap` missing samples between them, each with a bias of its own.
std::vector<double> power_ups(const noise::RecordGenerator& generate, std::uint64_t first_stream, int stretches,
                              double bias, std::size_t gap) {
  std::vector<double> rate;
  for (int i = 0; i < stretches; ++i) {
    if (i > 0) rate.insert(rate.end(), gap, kNaN);
    for (const double y : generate({.seed = 7, .stream = first_stream + static_cast<std::uint64_t>(i)}))
      rate.push_back(y + bias * i * i);
  }
  return rate;
}

// Shares of records whose intervals hold the truth: N, B, K.
template <class Make>
std::array<double, 3> coverage(int records, double dt, const tests::Gyro& truth, const Make& make) {
  const std::array<double, 3> values{truth.n, truth.b, truth.k};
  std::array<std::atomic<int>, 3> covered{};
  tbb::parallel_for(0, records, [&](int r) {
    const Result fit = fit_likelihood(make(static_cast<std::uint64_t>(r)), dt);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Coefficient& c = fit[kDefaultTerms[i]];
      covered[i] += c.lower <= values[i] && values[i] <= c.upper_two_sided;
    }
  });
  std::array<double, 3> share{};
  for (std::size_t i = 0; i < share.size(); ++i) share[i] = static_cast<double>(covered[i]) / records;
  return share;
}

constexpr int kRecords = 400;
constexpr double kSigmas = 3.3;  // three two-sided checks in each of four tests: false alarm 1.2 %
const double kScatter = kSigmas * std::sqrt(0.05 * 0.95 / kRecords);

void expect_coverage(std::int64_t samples, double missing) {
  const auto gyro = tests::mems();
  const noise::RecordGenerator generate(gyro.processes(), samples, 1);
  const auto share = coverage(kRecords, 1, gyro, [&](std::uint64_t r) {
    auto rate = generate({.seed = 7, .stream = r});
    scatter_gaps(rate, missing, r);
    return rate;
  });
  for (const double s : share) EXPECT_NEAR(s, 0.95, kScatter);
}

TEST(Gaps, IntervalsCoverWhereTwoPercentAreMissing) { expect_coverage(12000, 0.02); }

TEST(Gaps, IntervalsCoverWhereNearlyATenthIsMissing) { expect_coverage(6000, 0.09); }  // as many as are filled

TEST(Gaps, IntervalsCoverOverFivePowerUps) {
  const auto gyro = tests::mems();
  const noise::RecordGenerator generate(gyro.processes(), 6000, 1);
  const auto share =
      coverage(kRecords, 1, gyro, [&](std::uint64_t r) { return power_ups(generate, 5 * r, 5, 3 * gyro.n, 500); });
  for (const double s : share) EXPECT_NEAR(s, 0.95, kScatter);
}

// Curve and likelihood lose differently by gaps: the cross-check allows for that, and no more than a few disagree.
TEST(Gaps, DoNotMakeCurveAndLikelihoodDisagree) {
  const auto gyro = tests::mems();
  const noise::RecordGenerator generate(gyro.processes(), 12000, 1);
  constexpr int kChecked = 100;
  std::atomic<int> disagree{0};
  tbb::parallel_for(0, kChecked, [&](int r) {
    auto rate = generate({.seed = 17, .stream = static_cast<std::uint64_t>(r)});
    scatter_gaps(rate, 0.02, static_cast<std::uint64_t>(r));
    if (r % 2 == 1) std::fill(rate.begin() + 4000, rate.begin() + 4300, kNaN);
    Options likelihood;
    const Result curve = fit(Data{.rate = rate, .dt = 1});
    likelihood.tau_min_s = curve.tau_min_s;
    disagree += !cross_check(curve, fit_likelihood(rate, 1, likelihood)).agrees;
  });
  EXPECT_LE(disagree, 4);  // 0.6 expected of three coefficients at 0.2 % each: false alarm 4e-4
}

// Two stretches that are the same say what one says, twice.
TEST(Gaps, LikelihoodsOfStretchesAdd) {
  const auto gyro = tests::mems();
  const noise::RecordGenerator generate(gyro.processes(), 10000, 1);
  const auto one = generate({.seed = 3, .stream = 0});
  std::vector<double> twice = one;
  twice.insert(twice.end(), 300, kNaN);
  for (const double y : one) twice.push_back(y + 0.01);
  const Result a = fit_likelihood(one, 1), b = fit_likelihood(twice, 1);
  EXPECT_EQ(b.first_sample, 0);
  EXPECT_EQ(b.samples, 2 * a.samples);
  const double rounding = 1e-6;  // of the search, over the bins' rounding
  for (const Term t : kDefaultTerms) {
    EXPECT_NEAR(b[t].value / a[t].value, 1, rounding);
    EXPECT_NEAR(b[t].relative_std / a[t].relative_std * std::numbers::sqrt2, 1, rounding);
  }
}

// Where so many are missing that what is drawn would show, none are drawn: the longest stretches are left.
TEST(Gaps, AreNotFilledWhereTheyAreTooMany) {
  auto rate = noise::generate_record(tests::mems().processes(), 20000, 1, {.seed = 9, .stream = 0});
  for (std::size_t i = 12000; i < rate.size(); i += 3) rate[i] = kNaN;
  const Result r = fit_likelihood(rate, 1);
  EXPECT_EQ(r.samples, 12000);
}

// A run too long to be filled ends a stretch, a short one does not; a stretch of few samples is none.
TEST(Gaps, LongOnesEndAStretch) {
  auto rate = noise::generate_record(tests::mems().processes(), 40000, 1, {.seed = 9, .stream = 0});
  for (std::size_t i = 3000; i < 3300; ++i) rate[i] = kNaN;
  for (std::size_t i = 3310; i < 3600; ++i) rate[i] = kNaN;
  for (std::size_t i = 20000; i < 20040; ++i) rate[i] = kNaN;
  const Result r = fit_likelihood(rate, 1);
  EXPECT_EQ(r.first_sample, 0);
  EXPECT_EQ(r.samples, 3000 + 36000);  // 10 samples between gaps are left out; 36 400 are trimmed
  EXPECT_EQ(r.verdict, Verdict::described);
}

// What is filled in has the spectrum of what is not: power of the differences of white noise, a walk and angle noise.
TEST(FillGaps, KeepsThePowerOfEveryNoise) {
  constexpr std::int64_t kSamples = 65536;
  const auto power = [](const std::vector<double>& y) {
    double sum = 0;
    for (std::size_t i = 1; i < y.size(); ++i) sum += (y[i] - y[i - 1]) * (y[i] - y[i - 1]);
    return sum;
  };
  for (const noise::Process& process : std::initializer_list<noise::Process>{
           noise::White{1}, noise::RateRandomWalk{1}, noise::Quantization{1}, noise::GaussMarkov{1, 5}}) {
    auto rate = noise::generate_record(std::span(&process, 1), kSamples, 1, {.seed = 2, .stream = 0});
    const double whole = power(rate);
    scatter_gaps(rate, 0.1, 1);
    std::vector<std::int64_t> missing;
    for (std::size_t i = 0; i < rate.size(); ++i) {
      if (std::isnan(rate[i])) missing.push_back(static_cast<std::int64_t>(i));
    }
    auto again = rate;
    fill_gaps(rate, missing, 3);
    fill_gaps(again, missing, 3);
    EXPECT_EQ(rate, again);
    // A tenth is drawn anew: its power scatters by sqrt(2 * 2 * 0.1 / n), some five of these.
    EXPECT_NEAR(power(rate) / whole, 1, 5 * std::sqrt(0.4 / kSamples)) << char(noise::term(process));
  }
}

// White noise and a Gauss-Markov process of 3 s at 100 Hz, 2 % missing: the longest stretch without a gap is shorter
// than the process remembers.
TEST(Gaps, AGaussMarkovProcessIsSeenThroughThem) {
  constexpr double kTime = 3.08, kSigma = 4e-5, kDt = 0.01;
  const noise::Process processes[] = {noise::White{4e-5}, noise::GaussMarkov{kSigma, kTime}};
  auto rate = noise::generate_record(processes, 200000, kDt, {.seed = 4, .stream = 0});
  scatter_gaps(rate, 0.022, 2);
  Options options;
  options.terms = {Term::white, Term::gauss_markov};
  const Result r = fit_likelihood(rate, kDt, options);
  EXPECT_EQ(r.verdict, Verdict::described);
  const Coefficient& g = r[Term::gauss_markov];
  EXPECT_EQ(g.status, Status::identified);
  EXPECT_LT(g.shape_lower, kTime);
  EXPECT_GT(g.shape_upper, kTime);
  EXPECT_LT(g.shape_upper / g.shape_lower, 3);
  EXPECT_LT(g.lower, kSigma);
  EXPECT_GT(g.upper, kSigma);
  EXPECT_EQ(choose_terms(rate, kDt).terms, options.terms);
}

}  // namespace
}  // namespace gyrobudget::fit
