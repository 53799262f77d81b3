// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/whittle.h"

#include "gyrobudget/estimation/fit/detail/dst.h"
#include "gyrobudget/estimation/fit/detail/likelihood.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sensors.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace gyrobudget::fit {
namespace {

using noise::Term;

// --- The likelihood against an independent, slow one --------------------------------------------------------------

Eigen::MatrixXd dense_covariance(const noise::Process& process, Eigen::Index differences) {
  const auto D = [&](Eigen::Index h) { return noise::structure_function(process, std::abs(h), 1); };
  Eigen::MatrixXd covariance(differences, differences);
  for (Eigen::Index i = 0; i < differences; ++i) {
    for (Eigen::Index j = 0; j < differences; ++j)
      covariance(i, j) = 0.5 * (D(i - j + 1) + D(i - j - 1) - 2 * D(i - j));
  }
  return covariance;
}

// -2 ln L of the differences, with no transform and no approximation.
double dense_cost(const std::vector<double>& rate, const std::vector<noise::Process>& processes,
                  const Eigen::VectorXd& theta) {
  const auto size = static_cast<Eigen::Index>(rate.size()) - 1;
  Eigen::VectorXd z(size);
  for (Eigen::Index j = 0; j < size; ++j)
    z(j) = rate[static_cast<std::size_t>(j) + 1] - rate[static_cast<std::size_t>(j)];
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t a = 0; a < processes.size(); ++a)
    C += theta(static_cast<Eigen::Index>(a)) * dense_covariance(processes[a], size);
  const Eigen::LLT<Eigen::MatrixXd> factor(C);
  return 2 * factor.matrixLLT().diagonal().array().log().sum() + factor.matrixL().solve(z).squaredNorm();
}

double sine_cost_difference(const std::vector<double>& rate, const std::vector<noise::Process>& processes,
                            const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const auto n = static_cast<std::int64_t>(rate.size());
  const SineLikelihood likelihood(SineBins(sine_transform_of_differences(rate), n, 1, n - 1), processes, false);
  const auto cost = [&](const Eigen::VectorXd& theta) {
    const Eigen::ArrayXd lambda = likelihood.variance(theta);
    return (likelihood.bins().count * (lambda.log() + likelihood.power(0) / lambda)).sum();
  };
  return cost(a) - cost(b);
}

// White noise and walk: the only error is that of the bins (4 % wide above k = 32). Flicker: correlations are ignored.
TEST(SineLikelihood, DifferencesAreThoseOfTheDenseLikelihood) {
  constexpr std::int64_t n = 120;
  const Eigen::Vector2d a(1, 0.02), b(1.4, 0.005);
  const std::vector<noise::Process> walk{noise::White{1}, noise::RateRandomWalk{1}},
      flicker{noise::White{1}, noise::Flicker{1}};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto rate = noise::generate_record(std::vector<noise::Process>{noise::White{1}, noise::RateRandomWalk{0.1}},
                                             n, 1, {seed, 0});
    const double exact = dense_cost(rate, walk, a) - dense_cost(rate, walk, b);
    EXPECT_NEAR(sine_cost_difference(rate, walk, a, b), exact, 0.02 * (1 + std::abs(exact)));
    const Eigen::Vector2d c(1, 0.1), d(1.2, 0.02);
    const double of_flicker = dense_cost(rate, flicker, c) - dense_cost(rate, flicker, d);
    EXPECT_NEAR(sine_cost_difference(rate, flicker, c, d), of_flicker, 0.4);
  }
}

// The maximum by Newton's method has no better neighbour, free or on a bound.
TEST(SineLikelihood, MaximumHasNoBetterNeighbour) {
  const std::vector<noise::Process> terms{noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto rate = noise::generate_record(std::vector<noise::Process>{noise::White{1}, noise::RateRandomWalk{0.01}},
                                             3000, 1, {seed, 0});
    const SineLikelihood likelihood(SineBins(sine_transform_of_differences(rate), 3000, 1, 2999), terms, false);
    const auto best = likelihood.maximise();
    ASSERT_TRUE(best.converged);
    for (Eigen::Index j = 0; j < 3; ++j) {
      for (const double step : {-1e-3, 1e-3}) {
        const double size = std::max(best.theta(j), 1e-4 * best.theta(0));
        const double v = std::max(0.0, best.theta(j) + step * size);
        EXPECT_GE(likelihood.maximise(Held{j, v}).cost, best.cost - 1e-9) << seed << ' ' << j;
      }
    }
  }
}

TEST(SineLikelihood, InformationIsTheCurvature) {
  const auto gyro = tests::mems();
  const std::vector<noise::Process> terms{noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}};
  std::vector<double> nothing(9999, 0.0);
  const SineLikelihood shape(SineBins(nothing, 10000, 1, 9999), terms, false);
  const Eigen::Vector3d theta(gyro.n * gyro.n, gyro.b * gyro.b, gyro.k * gyro.k);
  // Data with exactly the expected power: the estimate is the truth, the cost's second difference twice the
  // information.
  const SineLikelihood likelihood = shape.with_power(shape.variance(theta));
  const auto best = likelihood.maximise();
  ASSERT_TRUE(best.converged);
  for (Eigen::Index j = 0; j < 3; ++j) EXPECT_NEAR(best.theta(j) / theta(j), 1, 1e-8);
  const Eigen::MatrixXd inverse = likelihood.information(theta).inverse();
  for (Eigen::Index j = 0; j < 3; ++j) {
    const double step = 0.01 * std::sqrt(inverse(j, j));
    const double rise =
        likelihood.maximise(Held{j, theta(j) + step}).cost + likelihood.maximise(Held{j, theta(j) - step}).cost;
    EXPECT_NEAR(rise / 2e-4, 1, 0.01);  // profile: (step/std)^2 on either side
  }
}

// --- The fit ----------------------------------------------------------------------------------------------------

std::vector<double> simulate(const std::vector<noise::Process>& processes, std::int64_t n, double dt,
                             std::uint64_t seed) {
  return noise::generate_record(processes, n, dt, {seed, 0});
}

Options with_terms(std::vector<Term> terms) {
  Options options;
  options.terms = std::move(terms);
  return options;
}

// |estimate/truth - 1| below five standard deviations as the fit states them: a false alarm of 6e-7 each.
void expect_close(const Coefficient& c, double truth) {
  EXPECT_EQ(c.status, Status::identified);
  EXPECT_LT(c.lower, c.value);
  EXPECT_GT(c.upper, c.value);
  EXPECT_LT(std::abs(c.value - truth), 5 * c.relative_std * c.value) << c.value << " for " << truth;
}

TEST(FitLikelihood, FindsEveryRandomTerm) {
  const auto rate = simulate(
      {noise::Quantization{3}, noise::White{1}, noise::Flicker{0.5}, noise::RateRandomWalk{0.02}}, 200000, 1, 4);
  const Result r =
      fit_likelihood(rate, 1, with_terms({Term::rate_random_walk, Term::flicker, Term::white, Term::quantization}));
  EXPECT_TRUE(r.converged);
  EXPECT_EQ(r.method, Method::whittle);
  EXPECT_EQ(r.verdict, Verdict::described);
  expect_close(r[Term::quantization], 3);
  expect_close(r[Term::white], 1);
  expect_close(r[Term::flicker], 0.5);
  expect_close(r[Term::rate_random_walk], 0.02);
  EXPECT_FALSE(r[Term::rate_ramp].fitted);
  for (Eigen::Index j = 0; j < 4; ++j) {
    const Coefficient& c = r[r.fitted_terms[static_cast<std::size_t>(j)]];
    EXPECT_NEAR(std::sqrt(r.covariance(j, j)) / (c.value * c.relative_std), 1, 1e-6);
  }
}

TEST(FitLikelihood, FindsARampOfEitherSign) {
  for (const double ramp : {3e-5, -3e-5}) {
    const auto rate = simulate({noise::White{1}, noise::RateRandomWalk{1e-3}, noise::RateRamp{ramp}}, 36000, 1, 5);
    const Result r = fit_likelihood(rate, 1, with_terms({Term::white, Term::rate_random_walk, Term::rate_ramp}));
    expect_close(r[Term::rate_ramp], std::abs(ramp));
    expect_close(r[Term::white], 1);
  }
  const auto flat = simulate({noise::White{1}, noise::RateRandomWalk{1e-3}}, 36000, 1, 6);
  const Result r = fit_likelihood(flat, 1, with_terms({Term::white, Term::rate_random_walk, Term::rate_ramp}));
  EXPECT_EQ(r[Term::rate_ramp].status, Status::upper_bound);
  EXPECT_GT(r[Term::rate_ramp].upper, r[Term::rate_ramp].value);
}

TEST(FitLikelihood, FindsAGaussMarkovProcessAndItsTime) {
  const auto rate = simulate({noise::White{1}, noise::GaussMarkov{0.5, 30}, noise::RateRandomWalk{1e-3}}, 100000, 1, 7);
  const Result r = fit_likelihood(rate, 1, with_terms({Term::white, Term::rate_random_walk, Term::gauss_markov}));
  EXPECT_EQ(r.verdict, Verdict::described);
  expect_close(r[Term::gauss_markov], 0.5);
  const Coefficient& g = r[Term::gauss_markov];
  EXPECT_LT(g.shape_lower, 30);
  EXPECT_GT(g.shape_upper, 30);
  EXPECT_LT(g.shape_upper / g.shape_lower, 1.6);
  // The curve's fit takes the time from the likelihood.
  const Result curve =
      fit({.rate = rate, .dt = 1}, with_terms({Term::white, Term::rate_random_walk, Term::gauss_markov}));
  EXPECT_EQ(curve.method, Method::gls);
  EXPECT_EQ(curve[Term::gauss_markov].shape, g.shape);
  EXPECT_NEAR(curve[Term::gauss_markov].value / g.value, 1, 0.05);
}

TEST(FitLikelihood, FindsALineAndWhatIsUnderIt) {
  constexpr double kDt = 0.01, kFrequency = 7.1234;
  const auto gyro = tests::mems();
  const double amplitude = 0.1 * gyro.n / std::sqrt(kDt);  // a tenth of the noise of one sample
  auto truth = gyro.processes();
  truth.push_back(noise::Sinusoid{amplitude, kFrequency, 0.7});
  const auto rate = simulate(truth, 360000, kDt, 8);
  Options options = with_terms({Term::white, Term::flicker, Term::rate_random_walk, Term::sinusoid});
  const Result r = fit_likelihood(rate, kDt, options);
  expect_close(r[Term::sinusoid], amplitude);
  EXPECT_LT(std::abs(r[Term::sinusoid].shape - kFrequency),
            r[Term::sinusoid].shape_upper - r[Term::sinusoid].shape_lower);
  expect_close(r[Term::white], gyro.n);
  EXPECT_EQ(r.verdict, Verdict::described);
  options.frequency_hz = kFrequency;
  EXPECT_NEAR(fit_likelihood(rate, kDt, options)[Term::sinusoid].value / r[Term::sinusoid].value, 1, 0.02);
  // What the line explains: half of A^2 n/(2 variance) in ln L, less what the fit without it makes of it.
  Options bare;
  bare.tau_min_s = kDt;  // the whole band, described or not
  const double gain = r.log_likelihood - fit_likelihood(rate, kDt, bare).log_likelihood;
  EXPECT_NEAR(2 * gain / r[Term::sinusoid].boundary_test, 1, 0.01);
  EXPECT_GT(gain, 500);
}

// 100 records of noise without a line; 5 % false ones are allowed, more than 16 have a probability below 1e-5.
TEST(FitLikelihood, SeesNoLineInNoise) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto rate = simulate({noise::White{1}, noise::RateRandomWalk{0.02}}, 3000, 1, seed);
    const Result r = fit_likelihood(rate, 1, with_terms({Term::white, Term::rate_random_walk, Term::sinusoid}));
    found += r[Term::sinusoid].status == Status::identified;
  }
  EXPECT_LE(found, 16);
}

TEST(FitLikelihood, LeavesOutStretchesOfAFewSamples) {
  auto rate = simulate(tests::mems().processes(), 36200, 1, 9);
  const std::vector<double> part(rate.begin() + 110, rate.begin() + 110 + 36000);
  for (std::size_t i = 10; i < 110; ++i) rate[i] = std::numeric_limits<double>::quiet_NaN();
  rate[36199] = std::numeric_limits<double>::infinity();
  const Result gappy = fit_likelihood(rate, 1), whole = fit_likelihood(part, 1);
  EXPECT_EQ(gappy.first_sample, 110);
  EXPECT_EQ(gappy.samples, 36000);  // 36 089 trimmed
  for (const Term t : {Term::white, Term::flicker, Term::rate_random_walk}) {
    EXPECT_EQ(gappy[t].value, whole[t].value);
    EXPECT_EQ(gappy[t].upper, whole[t].upper);
  }
}

TEST(FitLikelihood, SaysWhenThereIsNoAnswer) {
  std::vector<double> rate(1000, 3.0);
  for (int kind = 0; kind < 2; ++kind) {
    const Result r = fit_likelihood(rate, 1);
    EXPECT_FALSE(r.converged);
    EXPECT_EQ(r.verdict, Verdict::not_described);
    for (const auto& c : r.coefficients) EXPECT_FALSE(c.fitted);
    for (std::size_t i = 0; i < rate.size(); i += 10) rate[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

TEST(FitLikelihood, CutsTheBandThatTheModelMisses) {
  const auto gyro = tests::mems();
  auto rate = simulate(gyro.processes(), 200000, 0.01, 17);
  // A low pass of none of the kinds that are known: the upper octaves lie below white noise.
  for (int pole = 0; pole < 3; ++pole) {
    double state = rate.front();
    for (auto& y : rate) y = state += (y - state) / 8;
  }
  const Result r = fit_likelihood(rate, 0.01);
  EXPECT_EQ(r.verdict, Verdict::described);
  EXPECT_GT(r.tau_min_s, 0.07);
  EXPECT_LT(r.tau_min_s, 5);
  EXPECT_EQ(r.moved.size(), 3U);
  EXPECT_NEAR(r[Term::white].value / gyro.n, 1, 0.08);
  Options options;
  options.tau_min_s = 1;
  EXPECT_NEAR(fit_likelihood(rate, 0.01, options).tau_min_s, 1, 1e-3);
}

TEST(FitLikelihood, RefusesMisuse) {
  const auto rate = simulate({noise::White{1}}, 100, 1, 1);
  EXPECT_THROW((void)fit_likelihood(rate, 0), std::invalid_argument);
  EXPECT_THROW((void)fit_likelihood(rate, 1, with_terms({})), std::invalid_argument);
  EXPECT_THROW((void)fit_likelihood(rate, 1, with_terms({Term::white, Term::white})), std::invalid_argument);
  EXPECT_THROW((void)fit_likelihood(rate, 1, with_terms({Term::rate_ramp})), std::invalid_argument);
  Options options = with_terms({Term::white, Term::sinusoid});
  options.frequency_hz = 0.5;
  EXPECT_THROW((void)fit_likelihood(rate, 1, options), std::invalid_argument);
  options = with_terms({Term::white, Term::gauss_markov});
  options.correlation_time_s = 0;
  EXPECT_THROW((void)fit_likelihood(rate, 1, options), std::invalid_argument);
}

// --- The cross-check --------------------------------------------------------------------------------------------

TEST(CrossCheck, AgreesWhereTheModelHolds) {
  constexpr int kRecords = 100,
                kMostAlarms = 3;  // one in 500 is allowed: more than 3 has a probability below 1e-4
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    const auto rate = simulate(tests::mems().processes(), 12000, 3, seed);
    const CrossCheck check = cross_check(fit({.rate = rate, .dt = 3}), fit_likelihood(rate, 3));
    ASSERT_EQ(check.coefficients.size(), 3U);
    EXPECT_TRUE(check.same_range);
    alarms += !check.agrees;
  }
  EXPECT_LE(alarms, kMostAlarms);
}

TEST(CrossCheck, SeesABiasOfTwoStandardDeviations) {
  const auto rate = simulate(tests::mems().processes(), 36000, 1, 3);
  const Result gls = fit({.rate = rate, .dt = 1});
  Result whittle = fit_likelihood(rate, 1);
  EXPECT_TRUE(cross_check(gls, whittle).agrees);
  for (auto& c : whittle.coefficients) {
    if (c.term == Term::rate_random_walk) c.value *= 1 + 2 * c.relative_std;
  }
  const CrossCheck check = cross_check(gls, whittle);
  EXPECT_FALSE(check.agrees);
  EXPECT_TRUE(check.coefficients[0].agrees);
  EXPECT_FALSE(check.coefficients[2].agrees);
}

}  // namespace
}  // namespace gyrobudget::fit
