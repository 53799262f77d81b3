// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/selection.h"

#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sensors.h"

namespace gyrobudget::fit {
namespace {

using noise::Term;
using Terms = std::vector<Term>;

Selection select(const std::vector<noise::Process>& truth, std::int64_t n, double dt, std::uint64_t seed,
                 int replicas = 60) {
  SelectionOptions options;
  options.replicas = replicas;
  return choose_terms(noise::generate_record(truth, n, dt, {seed, 0}), dt, options);
}

// 60 records of white noise, 5 % of which may get a term: more than 12 has a probability below 1e-4 (cuts of few
// replicas are uncertain: 8 % instead).
TEST(ChooseTerms, KeepsFalseTermsOfTheWholeFamilyRare) {
  int false_terms = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    false_terms += select({noise::White{1}}, 1000, 1, seed).terms.size() > 1;
  EXPECT_LE(false_terms, 13);
}

// The same beside white noise and a walk that every record shows: the family is then weighed a second time.
TEST(ChooseTerms, KeepsFalseTermsRareBesideTrueOnes) {
  int false_terms = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto terms = select({noise::White{1}, noise::RateRandomWalk{0.3}}, 1000, 1, seed).terms;
    false_terms += terms != Terms{Term::white, Term::rate_random_walk};
  }
  EXPECT_LE(false_terms, 13);
}

TEST(ChooseTerms, FindsWhatIsThereAndListsWhatItWeighed) {
  const auto gyro = tests::mems();
  const Selection s = select({noise::White{gyro.n}, noise::RateRandomWalk{gyro.k}}, 36000, 1, 3);
  EXPECT_EQ(s.terms, (Terms{Term::white, Term::rate_random_walk}));
  ASSERT_EQ(s.weighed.size(), 11U);  // six beside N, five beside N and K
  int kept = 0;
  for (const Weighed& w : s.weighed) {
    kept += w.kept;
    EXPECT_GT(w.cut, 0.5);
    EXPECT_LT(w.cut, 20);
    if (w.kept) {
      EXPECT_EQ(w.candidate, Term::rate_random_walk);
      EXPECT_GT(w.gain, w.cut);
    }
  }
  EXPECT_EQ(kept, 1);
}

TEST(ChooseTerms, TellsFlickerFromWalkAndRampFromBoth) {
  const std::vector<noise::Process> flicker{noise::White{1}, noise::Flicker{0.3}};
  EXPECT_EQ(select(flicker, 36000, 1, 1).terms, (Terms{Term::white, Term::flicker}));
  const std::vector<noise::Process> ramp{noise::White{1}, noise::RateRamp{1e-5}};
  EXPECT_EQ(select(ramp, 36000, 1, 1).terms, (Terms{Term::white, Term::rate_ramp}));
  const std::vector<noise::Process> quantized{noise::Quantization{2}, noise::White{1}};
  EXPECT_EQ(select(quantized, 36000, 1, 1).terms, (Terms{Term::quantization, Term::white}));
}

TEST(ChooseTerms, TakesAGaussMarkovProcessOnlyWhereNothingElseWouldDo) {
  const Selection s = select({noise::White{1}, noise::GaussMarkov{0.5, 30}}, 36000, 1, 2);
  EXPECT_EQ(s.terms, (Terms{Term::white, Term::gauss_markov}));
  ASSERT_TRUE(s.correlation_time_s);
  EXPECT_NEAR(*s.correlation_time_s, 30, 10);
}

TEST(ChooseTerms, FindsALine) {
  const Selection s = select({noise::White{1}, noise::Sinusoid{0.08, 0.0713, 1}}, 36000, 1, 1);
  EXPECT_EQ(s.terms, (Terms{Term::white, Term::sinusoid}));
  ASSERT_TRUE(s.frequency_hz);
  EXPECT_NEAR(*s.frequency_hz, 0.0713, 1 / 36000.0);
  EXPECT_FALSE(s.correlation_time_s);
}

// A fit begins from what was weighed: of two lines the fainter one, where that was it.
TEST(ChooseTerms, HandsOnTheShapesThatItWeighed) {
  const auto rate = noise::generate_record(
      std::vector<noise::Process>{noise::White{1}, noise::Sinusoid{0.3, 0.3, 1}, noise::Sinusoid{0.2, 0.01, 0}}, 20000,
      1, {3, 0});
  const Selection s = choose_terms(rate, 1, {.replicas = 60, .tau_min_s = 10});
  ASSERT_EQ(s.terms, (Terms{Term::white, Term::sinusoid}));
  EXPECT_EQ(s.tau_min_s, 10);
  ASSERT_TRUE(s.frequency_hz);
  EXPECT_NEAR(*s.frequency_hz, 0.01, 1e-5);
  for (const Method method : {Method::gls, Method::whittle}) {
    Options options{.terms = s.terms, .method = method, .tau_min_s = method == Method::gls ? s.tau_min_s : 1.0};
    options.near_frequency_hz = s.frequency_hz;
    const Result r = fit({.rate = rate, .dt = 1}, options);
    EXPECT_NEAR(r[Term::sinusoid].shape, *s.frequency_hz, 1e-5);
    EXPECT_LT(r[Term::sinusoid].shape_lower, r[Term::sinusoid].shape);
  }
}

TEST(ChooseTerms, SaysWhatItCannotTellApart) {
  const Selection s = select(tests::mems().processes(), 36000, 1, 1);
  ASSERT_EQ(s.terms, (Terms{Term::white, Term::flicker, Term::rate_random_walk}));
  ASSERT_TRUE(s.alternative);
  EXPECT_EQ(s.alternative->terms, (Terms{Term::white, Term::rate_random_walk, Term::gauss_markov}));
  EXPECT_LT(std::abs(s.alternative->log_likelihood_difference), 10);
}

TEST(ChooseTerms, IsTheSameForAnyNumberOfThreads) {
  const auto run = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return select(tests::mems().processes(), 4000, 1, 5);
  };
  const Selection one = run(1), two = run(2);
  ASSERT_EQ(one.weighed.size(), two.weighed.size());
  for (std::size_t i = 0; i < one.weighed.size(); ++i) EXPECT_EQ(one.weighed[i].cut, two.weighed[i].cut);
}

TEST(ChooseTerms, HasNoAnswerForASilentRecordAndRefusesMisuse) {
  const std::vector<double> silent(100, 1.0);
  EXPECT_TRUE(choose_terms(silent, 1).terms.empty());
  SelectionOptions options;
  EXPECT_THROW((void)choose_terms(silent, 0, options), std::invalid_argument);
  options.candidates = {Term::white};
  EXPECT_THROW((void)choose_terms(silent, 1, options), std::invalid_argument);
  options.candidates = {Term::flicker};
  options.false_rate = 0;
  EXPECT_THROW((void)choose_terms(silent, 1, options), std::invalid_argument);
  options.false_rate = 0.05;
  options.replicas = 10;
  EXPECT_THROW((void)choose_terms(silent, 1, options), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::fit
