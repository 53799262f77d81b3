// SPDX-License-Identifier: MIT
// Where a fit could break: every answer is right to its own stated scatter or says that there is none; no NaN, no
// abort.
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/estimation/fit/whittle.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "sensors.h"
#include <Eigen/Cholesky>

namespace gyrobudget::fit {
namespace {

using noise::Term;
constexpr std::array kTerms{Term::white, Term::flicker, Term::rate_random_walk};
constexpr std::array kBest{Method::gls, Method::whittle};
// Standard deviations that an identified coefficient may lie from the truth: false alarm 6e-7 of a normal estimate; a
// weak one is skewed.
constexpr double kDeviations = 5;

Result fitted(std::span<const double> rate, double dt, Method method) {
  Options options;
  options.method = method;
  return fit({.rate = rate, .dt = dt}, options);
}

// Numbers, whatever they say.
void expect_sound(const Result& r, const std::string& what) {
  for (const Coefficient& c : r.coefficients) {
    EXPECT_TRUE(std::isfinite(c.value)) << what;
    EXPECT_GE(c.value, 0) << what;
    EXPECT_LE(c.lower, c.value) << what;
    EXPECT_FALSE(std::isnan(c.upper) || std::isnan(c.upper_two_sided) || std::isnan(c.boundary_test)) << what;
    EXPECT_GE(c.upper, c.value) << what;
  }
  EXPECT_FALSE(std::isnan(r.p_value)) << what;
}

void expect_right(const Coefficient& c, double truth, const std::string& what) {
  if (truth == 0) {
    EXPECT_FALSE(c.status == Status::identified && c.boundary_test > 25) << what;
  } else if (c.status == Status::identified) {
    EXPECT_LT(std::abs(c.value - truth), kDeviations * c.relative_std * c.value) << what;
  } else {
    EXPECT_GT(c.upper * 2, truth) << what;  // a limit far below the truth would be wrong
  }
}

TEST(Extreme, CoefficientsOver20DecadesAlone) {
  for (double scale = 1e-15; scale < 1e6; scale *= 1e5) {
    const std::vector<noise::Process> alone[] = {
        {noise::White{scale}}, {noise::Flicker{scale}}, {noise::RateRandomWalk{scale}}};
    for (std::size_t j = 0; j < 3; ++j) {
      const auto rate = noise::generate_record(alone[j], 5000, 0.1, {1, j});
      for (const Method method : kBest) {
        const std::string what =
            std::string(name(method)) + " " + static_cast<char>(kTerms[j]) + " " + std::to_string(std::log10(scale));
        const Result r = fitted(rate, 0.1, method);
        expect_sound(r, what);
        EXPECT_TRUE(r.converged) << what;
        EXPECT_EQ(r[kTerms[j]].status, Status::identified) << what;
        for (std::size_t i = 0; i < 3; ++i) expect_right(r[kTerms[i]], i == j ? scale : 0, what);
      }
    }
  }
}

// beta = B^2/(N K) from 1e-3 to 1e3, and walks so strong or weak that one end of the curve is missing.
TEST(Extreme, MixesFromOneEndToTheOther) {
  for (const double k : {1e-10, 1e-3, 1e-1, 1e3, 1e10}) {
    for (const double beta : {1e-3, 1.0, 1e3}) {
      const double b = std::sqrt(beta * k);
      const auto rate = noise::generate_record(
          std::vector<noise::Process>{noise::White{1}, noise::Flicker{b}, noise::RateRandomWalk{k}}, 8000, 1, {2, 0});
      for (const Method method : kBest) {
        const std::string what =
            std::string(name(method)) + " K " + std::to_string(k) + " beta " + std::to_string(beta);
        const Result r = fitted(rate, 1, method);
        expect_sound(r, what);
        EXPECT_TRUE(r.converged) << what;
        expect_right(r[Term::white], 1, what);
        expect_right(r[Term::flicker], b, what);
        expect_right(r[Term::rate_random_walk], k, what);
      }
    }
  }
}

TEST(Extreme, LengthsFromSixteenAndPrime) {
  for (const std::int64_t n : {16, 17, 31, 97, 1009, 99991}) {
    const auto rate = noise::generate_record(tests::mems().processes(), n, 1, {3, 0});
    for (const Method method : kMethods) {
      Options options;
      options.method = method;
      if (n < 97 && method != Method::whittle) options.terms = {Term::white};
      if (method == Method::slope || method == Method::visual) continue;
      const Result r = fit({.rate = rate, .dt = 1}, options);
      const std::string what = std::string(name(method)) + " " + std::to_string(n);
      expect_sound(r, what);
      if (method == Method::whittle) {
        EXPECT_LE(r.samples, n);
        EXPECT_GT(r.samples, (n < 64 ? 0.75 : 0.94) * static_cast<double>(n)) << what;
      }
    }
  }
}

TEST(Extreme, RatesFromOneSampleIn17MinutesToAMegahertz) {
  const auto gyro = tests::mems();
  for (const double rate_hz : {1e-3, 1.0, 1e3, 1e6}) {
    // The same record seen faster: N sqrt(dt), B and K/sqrt(dt) scale along.
    const double n = gyro.n / std::sqrt(rate_hz), k = gyro.k * std::sqrt(rate_hz);
    const auto rate = noise::generate_record(
        std::vector<noise::Process>{noise::White{n}, noise::Flicker{gyro.b}, noise::RateRandomWalk{k}}, 20000,
        1 / rate_hz, {4, 0});
    for (const Method method : kBest) {
      const Result r = fitted(rate, 1 / rate_hz, method);
      expect_sound(r, std::to_string(rate_hz));
      expect_right(r[Term::white], n, std::to_string(rate_hz));
      expect_right(r[Term::flicker], gyro.b, std::to_string(rate_hz));
      expect_right(r[Term::rate_random_walk], k, std::to_string(rate_hz));
    }
  }
}

// The doubles themselves round to 1e-7 of the noise there; nothing else may be lost.
TEST(Extreme, AConstantOf1e9TimesTheNoise) {
  auto rate = noise::generate_record(tests::mems().processes(), 20000, 1, {5, 0});
  std::vector<double> raised = rate;
  for (double& y : raised) y += 1e9 * tests::mems().n;
  for (const Method method : kBest) {
    const Result plain = fitted(rate, 1, method), high = fitted(raised, 1, method);
    for (const Term t : kTerms) {
      EXPECT_EQ(plain[t].status, high[t].status);
      EXPECT_NEAR(high[t].value / plain[t].value, 1, 1e-4);
    }
  }
}

TEST(Extreme, ARecordOfFiveLevels) {
  auto rate = noise::generate_record(std::vector<noise::Process>{noise::White{1}, noise::RateRandomWalk{1e-3}}, 20000,
                                     1, {6, 0});
  for (double& y : rate) y = std::clamp(std::round(y), -2.0, 2.0);
  for (const Method method : kBest) {
    const Result r = fitted(rate, 1, method);
    expect_sound(r, "five levels");
    EXPECT_EQ(r[Term::white].status, Status::identified);
    EXPECT_NEAR(r[Term::white].value, 1, 0.1);  // rounding adds 1/12 of variance, clipping takes some
  }
}

TEST(Extreme, AlmostSilentRecords) {
  std::vector<double> rate(4096, 1.0);
  rate[1234] = 2;  // one sample differs
  for (const Method method : kBest) expect_sound(fitted(rate, 1, method), "one sample");
  for (std::size_t i = 0; i < rate.size(); ++i)
    rate[i] = static_cast<double>(i % 2);  // a line at the highest frequency
  for (const Method method : kBest) expect_sound(fitted(rate, 1, method), "alternating");
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = static_cast<double>(i);  // a ramp and nothing else
  for (const Method method : kBest) expect_sound(fitted(rate, 1, method), "ramp");
}

// Values whose squares leave double, and denormals, which have 1 % of rounding themselves.
TEST(Extreme, ScalesThatSquaresCannotReach) {
  const auto base = noise::generate_record(std::vector<noise::Process>{noise::White{1}, noise::RateRandomWalk{0.01}},
                                           4096, 1, {7, 0});
  for (const Method method : kBest) {
    const Result reference = fitted(base, 1, method);
    for (const double scale : {1e-200, 1e-160, 1e160, 1e200}) {
      std::vector<double> rate = base;
      for (double& y : rate) y *= scale;
      const Result r = fitted(rate, 1, method);
      EXPECT_NEAR(r[Term::white].value / scale / reference[Term::white].value, 1, 1e-9) << scale;
      EXPECT_EQ(r[Term::rate_random_walk].status, reference[Term::rate_random_walk].status) << scale;
    }
    std::vector<double> denormal = base;
    for (double& y : denormal) y *= 1e-320;
    const Result r = fitted(denormal, 1, method);
    expect_sound(r, "denormal");
    EXPECT_NEAR(r[Term::white].value / 1e-320, 1, 0.05);
  }
}

TEST(Extreme, UnitsDoNotMatter) {
  const auto base = noise::generate_record(tests::mems().processes(), 20000, 1, {8, 0});
  for (const Method method : kMethods) {
    const Result reference = fitted(base, 1, method);
    for (const double scale : {1e-12, 1e12}) {  // no powers of two: every sample is rounded again
      std::vector<double> rate = base;
      for (double& y : rate) y *= scale;
      const Result r = fitted(rate, 1, method);
      EXPECT_EQ(r.verdict, reference.verdict);
      for (const Term t : kTerms) {
        EXPECT_EQ(r[t].status, reference[t].status) << name(method);
        constexpr double kUnits = 1e-10;
        EXPECT_NEAR(r[t].value / scale / reference[t].value, 1, kUnits) << name(method);
        EXPECT_NEAR(r[t].upper / scale / reference[t].upper, 1, kUnits) << name(method);
        if (reference[t].lower > 0) {
          EXPECT_NEAR(r[t].lower / scale / reference[t].lower, 1, kUnits) << name(method);
        }
      }
    }
  }
}

// The correlation time and the frequency too, which are searched.
TEST(Extreme, UnitsDoNotMatterToSearchedShapes) {
  const auto base = noise::generate_record(
      std::vector<noise::Process>{noise::White{1}, noise::GaussMarkov{0.5, 30}, noise::Sinusoid{0.3, 0.0713, 1}}, 4099,
      1, {9, 0});
  for (const Method method : kBest) {
    Options options;
    options.method = method;
    options.terms = {Term::white, Term::gauss_markov, Term::sinusoid};
    const Result reference = fit({.rate = base, .dt = 1}, options);
    for (const double scale : {1e-12, 1e12}) {
      std::vector<double> rate = base;
      for (double& y : rate) y *= scale;
      const Result r = fit({.rate = rate, .dt = 1}, options);
      for (const Term t : options.terms) {
        constexpr double kUnits = 1e-10;
        EXPECT_EQ(r[t].status, reference[t].status);
        EXPECT_NEAR(r[t].value / scale / reference[t].value, 1, kUnits) << name(method);
        EXPECT_NEAR(r[t].upper / scale / reference[t].upper, 1, kUnits) << name(method);
        EXPECT_NEAR(r[t].shape, reference[t].shape, kUnits * reference[t].shape) << name(method);
      }
    }
  }
}

// A curve of theory needs no record: lengths to 10^9 samples at rates from 10^-3 Hz to 1 MHz.
struct CurveCase {
  std::int64_t n = 0;
  double dt = 1;
  Eigen::VectorXd theta;  // of N, B, K
  allan::CurveCovariance covariance;

  CurveCase(std::int64_t samples, double rate_hz)
      : n(samples),
        dt(1 / rate_hz),
        theta(3),
        covariance(samples, allan::octave_factors(samples), 1 / rate_hz,
                   {noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}}) {
    const double k = 1000 / (static_cast<double>(samples) * dt);  // crosses N at 1/600 of the record
    theta << 1, k, k * k;                                         // beta = 1
  }
  [[nodiscard]] allan::Curve curve(const Eigen::VectorXd& variances) const {
    allan::Curve c{.dt = dt, .samples = n};
    for (std::size_t i = 0; i < covariance.factors().size(); ++i) {
      const auto m = covariance.factors()[i];
      c.points.push_back({m, variances(static_cast<Eigen::Index>(i)), n - 2 * m + 1});
    }
    return c;
  }
  [[nodiscard]] Eigen::VectorXd expected() const { return covariance.expectation() * theta; }
  [[nodiscard]] double truth(std::size_t term) const { return std::sqrt(theta(static_cast<Eigen::Index>(term))); }
};

TEST(Extreme, CurvesOfTheoryUpToABillionSamplesGiveTheTruthBack) {
  for (const std::int64_t n : {std::int64_t{100'000}, std::int64_t{99'999'989}, std::int64_t{1'000'000'000}}) {
    for (const double rate_hz : {1e-3, 1.0, 1e6}) {
      const CurveCase a(n, rate_hz);
      const Result r = fit(a.curve(a.expected()), a.covariance);
      const std::string what = std::to_string(n) + " at " + std::to_string(rate_hz);
      EXPECT_TRUE(r.converged) << what;
      EXPECT_EQ(r.verdict, Verdict::described) << what;
      EXPECT_GT(r.p_value, 0.999) << what;  // nothing is left
      for (std::size_t t = 0; t < kTerms.size(); ++t) {
        EXPECT_EQ(r[kTerms[t]].status, Status::identified) << what;
        constexpr double kRounding = 1e-7;  // of A and S, times their condition
        EXPECT_NEAR(r[kTerms[t]].value / a.truth(t), 1, kRounding) << what;
        EXPECT_LT(r[kTerms[t]].lower, a.truth(t)) << what;
        EXPECT_GT(r[kTerms[t]].upper, a.truth(t)) << what;
      }
    }
  }
}

// Curves with the scatter of 10^9 samples, drawn from their exact covariance.
TEST(Extreme, CurvesDrawnFromTheCovarianceOfABillionSamples) {
  for (const double rate_hz : {1e-3, 1e6}) {
    const CurveCase a(1'000'000'000, rate_hz);
    const Eigen::LLT<Eigen::MatrixXd> factor(a.covariance(a.theta));
    ASSERT_EQ(factor.info(), Eigen::Success);
    for (std::uint64_t draw = 0; draw < 20; ++draw) {
      Eigen::VectorXd z(a.expected().size());
      noise::fill_normal({11, draw}, 0, {z.data(), static_cast<std::size_t>(z.size())});
      const Result r = fit(a.curve((a.expected() + factor.matrixL() * z).cwiseMax(0)), a.covariance);
      const std::string what = std::to_string(rate_hz) + " draw " + std::to_string(draw);
      expect_sound(r, what);
      EXPECT_TRUE(r.converged) << what;
      for (std::size_t t = 0; t < kTerms.size(); ++t) expect_right(r[kTerms[t]], a.truth(t), what);
    }
  }
}

// Records of N, B and K on which the reweighting once went to and fro between two sets of terms above zero, or crept.
TEST(Extreme, ShortRecordsConverge) {
  for (const std::int64_t n : {1000, 10000}) {
    const noise::RecordGenerator generator(tests::mems().processes(), n, 1);
    const auto factors = allan::octave_factors(n);
    const allan::CurveCovariance covariance(n, factors, 1, tests::mems().processes());
    for (std::uint64_t i = 0; i < 300; ++i) {
      const auto curve = allan::overlapped_variance(generator({1, i}), 1, factors);
      EXPECT_TRUE(fit(curve, covariance, {.intervals = false}).converged) << n << " " << i;
    }
  }
}

}  // namespace
}  // namespace gyrobudget::fit
