// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/covariance.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <Eigen/Cholesky>

namespace gyrobudget::allan {
namespace {

using Factors = std::vector<std::int64_t>;
using Processes = std::vector<noise::Process>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Largest |A - B| relative to sqrt(A_ii A_jj).
double scaled_difference(const MatrixXd& A, const MatrixXd& B) {
  double worst = 0;
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    for (Eigen::Index j = 0; j < A.cols(); ++j) {
      worst = std::max(worst, std::abs(A(i, j) - B(i, j)) / std::sqrt(A(i, i) * A(j, j)));
    }
  }
  return worst;
}

MatrixXd correlation(const MatrixXd& S) {
  const VectorXd scale = S.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * S * scale.asDiagonal();
}

// ---- against the covariance of the samples themselves ----------------------------------------------------------

/// Covariances of the terms of two estimates from nothing but the structure function of the rate, and means of the
/// terms; all pairs of terms, all pairs of samples.
class BruteForce {
 public:
  BruteForce(std::int64_t samples, double dt, const noise::Process& process, Form form)
      : samples_(samples), dt_(dt), process_(process), form_(form) {}

  /// sum over all pairs of terms of cov(d1, d2)^power, power 1 weighted with the product of means.
  [[nodiscard]] MatrixXd covariances(std::int64_t m1, std::int64_t m2) const {
    MatrixXd C(terms(m1), terms(m2));
    for (Eigen::Index j = 0; j < C.rows(); ++j) {
      for (Eigen::Index k = 0; k < C.cols(); ++k) C(j, k) = covariance(m1, j, m2, k);
    }
    return C;
  }
  /// Products of the means of the terms, averaged over the phase of a sinusoid.
  [[nodiscard]] MatrixXd means(std::int64_t m1, std::int64_t m2) const {
    MatrixXd products = MatrixXd::Zero(terms(m1), terms(m2));
    constexpr int kPhases = 2;
    for (int phase = 0; phase < kPhases; ++phase) {
      VectorXd one(terms(m1)), two(terms(m2));
      for (Eigen::Index j = 0; j < one.size(); ++j) one[j] = mean(m1, j, phase);
      for (Eigen::Index k = 0; k < two.size(); ++k) two[k] = mean(m2, k, phase);
      products += one * two.transpose() / kPhases;
    }
    return products;
  }

 private:
  [[nodiscard]] Eigen::Index terms(std::int64_t m) const { return complete_terms(samples_, m, form_); }

  static double weight(std::int64_t m, std::int64_t i) {  // of sample i of a triple in d
    return (i < m ? -1 : 1) / (static_cast<double>(m) * std::sqrt(2.));
  }
  [[nodiscard]] double covariance(std::int64_t m1, std::int64_t j, std::int64_t m2, std::int64_t k) const {
    double sum = 0;
    for (std::int64_t a = 0; a < 2 * m1; ++a) {
      for (std::int64_t b = 0; b < 2 * m2; ++b) {
        const double D = noise::structure_function(process_, std::abs(j + a - k - b), dt_);
        sum -= weight(m1, a) * weight(m2, b) * D / 2;
      }
    }
    return sum;
  }
  [[nodiscard]] double mean(std::int64_t m, std::int64_t k, int phase) const {
    double sum = 0;
    for (std::int64_t i = 0; i < 2 * m; ++i) {
      const double t = static_cast<double>(k + i) * dt_;
      if (std::holds_alternative<noise::RateRamp>(process_)) sum += weight(m, i) * t;
      if (const auto* line = std::get_if<noise::Sinusoid>(&process_)) {
        sum += weight(m, i) * std::sin(2 * std::numbers::pi * line->frequency * t + phase * std::numbers::pi / 2);
      }
    }
    return sum;
  }

  std::int64_t samples_;
  double dt_;
  noise::Process process_;
  Form form_;
};

bool is_mean(const noise::Process& process) {
  return std::holds_alternative<noise::RateRamp>(process) || std::holds_alternative<noise::Sinusoid>(process);
}

/// S of the mix by Isserlis' theorem over all pairs of terms.
MatrixXd brute_force(std::int64_t samples, const Factors& factors, double dt, const Processes& processes,
                     const VectorXd& theta, Form form) {
  MatrixXd S(factors.size(), factors.size());
  for (std::size_t i = 0; i < factors.size(); ++i) {
    for (std::size_t j = 0; j < factors.size(); ++j) {
      MatrixXd C, mu;
      for (std::size_t a = 0; a < processes.size(); ++a) {
        const BruteForce part(samples, dt, processes[a], form);
        const double square = theta[static_cast<Eigen::Index>(a)];
        MatrixXd& sum = is_mean(processes[a]) ? mu : C;
        const MatrixXd term = square * (is_mean(processes[a]) ? part.means(factors[i], factors[j])
                                                              : part.covariances(factors[i], factors[j]));
        if (sum.size() == 0) {
          sum = term;
        } else {
          sum += term;
        }
      }
      double sum = 2 * C.squaredNorm();
      if (mu.size() > 0) sum += 4 * C.cwiseProduct(mu).sum();
      S(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = sum / static_cast<double>(C.size());
    }
  }
  return S;
}

constexpr double kExact = 1e-9;

const Processes kRandom{noise::Quantization{1}, noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1},
                        noise::GaussMarkov{1, 0.6}};
const VectorXd kRandomTheta = (VectorXd(5) << 0.02, 1, 0.7, 0.3, 2).finished();

TEST(BruteForceCovariance, EveryRandomProcessAndTheirMix) {
  const Factors factors{1, 2, 3, 4, 7, 10, 15};
  for (const Form form : {Form::full, Form::ieee}) {
    const std::int64_t samples = form == Form::full ? 30 : 31;
    const CurveCovariance covariance(samples, factors, 0.2, kRandom, form);
    for (int only = -1; only < 5; ++only) {
      VectorXd theta = kRandomTheta;
      if (only >= 0) theta = VectorXd::Unit(5, only);
      const MatrixXd truth = brute_force(samples, factors, 0.2, kRandom, theta, form);
      EXPECT_LT(scaled_difference(truth, covariance(theta)), kExact) << "process " << only;
    }
  }
}

TEST(BruteForceCovariance, RampWithNoise) {
  Processes processes = kRandom;
  processes.push_back(noise::RateRamp{1});
  const VectorXd theta = (VectorXd(6) << kRandomTheta, 0.4).finished();
  const Factors factors{1, 2, 5, 12, 15};
  const MatrixXd truth = brute_force(30, factors, 0.2, processes, theta, Form::full);
  EXPECT_LT(scaled_difference(truth, CurveCovariance(30, factors, 0.2, processes)(theta)), kExact);
  EXPECT_EQ(CurveCovariance(30, factors, 0.2, {noise::RateRamp{1}})(VectorXd::Ones(1)).norm(), 0);
}

TEST(BruteForceCovariance, SinusoidWithNoise) {
  // A fixed phase differs from the average over phases by end effects; the brute force averages two quadratures,
  // which is the same as all.
  Processes processes = kRandom;
  processes.push_back(noise::Sinusoid{1, 0.9, 0});
  const VectorXd theta = (VectorXd(6) << kRandomTheta, 3).finished();
  const Factors factors{1, 2, 5, 12};
  const MatrixXd truth = brute_force(40, factors, 0.2, processes, theta, Form::full);
  EXPECT_LT(scaled_difference(truth, CurveCovariance(40, factors, 0.2, processes)(theta)), kExact);
}

TEST(LongSinusoid, SpectralFormContinuesTheLagSum) {
  // 500 cycles in the record are where one form takes over from the other; S n hardly depends on n itself.
  constexpr double kSpectralError = 0.01;
  const Processes mix{noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}, noise::Sinusoid{1, 0.0503, 0}};
  const Eigen::Vector4d theta(1, 0.1, 0.01, 9);
  const auto scaled = [&](double samples) {
    const auto n = static_cast<std::int64_t>(samples);
    return MatrixXd(CurveCovariance(n, {1, 2, 4, 8, 16, 32, 64}, 1, mix)(theta) * samples);
  };
  const double border = 500 / 0.0503;
  EXPECT_LT(scaled_difference(scaled(border - 30), scaled(border + 130)), kSpectralError);
}

// ---- published and derived numbers -----------------------------------------------------------------------------

TEST(Form, IeeeIsTheFullFormOfARecordOneSampleShorter) {
  const Factors factors{1, 2, 8, 100, 499};
  const CurveCovariance ieee(1000, factors, 0.1, kRandom, Form::ieee), full(999, factors, 0.1, kRandom);
  EXPECT_EQ(ieee(kRandomTheta), full(kRandomTheta));
}

TEST(Form, HalfTheRecordHasNoTermInIeee) {
  const CurveCovariance covariance(8, {1, 4}, 1, {noise::White{1}}, Form::ieee);
  const MatrixXd S = covariance(VectorXd::Ones(1));
  EXPECT_TRUE(std::isnan(S(0, 1)) && std::isnan(S(1, 1)) && std::isnan(covariance.expectation()(1, 0)));
  EXPECT_GT(S(0, 0), 0);
}

TEST(Covariance, ScalesWithTheInterval) {
  // y in units of its own white noise: N^2/dt, B^2, K^2 dt are what the matrix can depend on.
  const Factors factors = octave_factors(5000);
  const Processes processes{noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}};
  const MatrixXd one = CurveCovariance(5000, factors, 1, processes)(Eigen::Vector3d(1, 0.5, 0.25));
  const MatrixXd fine = CurveCovariance(5000, factors, 0.01, processes)(Eigen::Vector3d(0.01, 0.5, 25));
  EXPECT_LT(scaled_difference(one, fine), 1e-12);
}

TEST(Covariance, ExpectationIsTheAllanVariance) {
  const Factors factors = octave_factors(5000);
  const CurveCovariance covariance(5000, factors, 0.1, kRandom);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    for (std::size_t a = 0; a < kRandom.size(); ++a) {
      EXPECT_EQ(covariance.expectation()(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a)),
                noise::allan_variance(kRandom[a], factors[i], 0.1));
    }
  }
}

TEST(Covariance, IgnoresCoefficientsAndOrder) {
  const CurveCovariance unit(1000, {1, 10, 100}, 1, {noise::White{1}, noise::Flicker{1}});
  const CurveCovariance scaled(1000, {100, 1, 10}, 1, {noise::White{7}, noise::Flicker{0}});
  const MatrixXd S = unit(Eigen::Vector2d(1, 2)), T = scaled(Eigen::Vector2d(1, 2));
  EXPECT_EQ(S(0, 2), T(1, 0));
  EXPECT_EQ(S(1, 1), T(2, 2));
  EXPECT_EQ(noise::coefficient(scaled.processes()[0]), 1);
}

TEST(Covariance, SubsetIsTheSameNumbers) {
  const Factors factors = octave_factors(3000);
  const CurveCovariance whole(3000, factors, 0.2, kRandom);
  const std::size_t rows[] = {2, 0, 7}, columns[] = {3, 1};
  const CurveCovariance part = whole.subset(rows, columns);
  const CurveCovariance anew(3000, {factors[2], factors[0], factors[7]}, 0.2, {kRandom[3], kRandom[1]});
  const Eigen::Vector2d theta(0.3, 1);
  EXPECT_EQ(part(theta), anew(theta));
  EXPECT_EQ(part.expectation(), anew.expectation());
  EXPECT_EQ(part.factors(), anew.factors());
  const std::size_t none[] = {99};
  EXPECT_THROW((void)whole.subset(none, columns), std::out_of_range);
}

TEST(Covariance, SameBytesForAnyNumberOfThreads) {
  const auto make = [](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return CurveCovariance(100'000, octave_factors(100'000), 0.01, kRandom)(kRandomTheta);
  };
  const MatrixXd one = make(1);
  EXPECT_EQ(one, make(2));
  EXPECT_EQ(one, make(7));
}

TEST(Covariance, MisuseThrows) {
  const Processes white{noise::White{1}};
  EXPECT_THROW(CurveCovariance(100, {51}, 1, white), std::invalid_argument);
  EXPECT_THROW(CurveCovariance(100, {0}, 1, white), std::invalid_argument);
  EXPECT_THROW(CurveCovariance(100, {1}, 0, white), std::invalid_argument);
  EXPECT_THROW(CurveCovariance(100, {1}, 1, {noise::GaussMarkov{1, -1}}), std::invalid_argument);
  const Mask mask(99, {{3, 1}}, 0.95);
  EXPECT_THROW(CurveCovariance(100, {1}, 1, white, Form::full, &mask), std::invalid_argument);
  EXPECT_THROW((void)CurveCovariance(100, {1}, 1, white)(VectorXd::Ones(2)), std::invalid_argument);
}

// ---- a Cholesky factor from n = 16 to 1e9 ----------------------------------------------------------------------

struct Mix {
  const char* name;
  double dt;
  Processes processes;
};

// The paper's gyros (theory section 1), SI.
const double kIfog[] = {1.570796e-7, 8.241833e-9, 3.490659e-9}, kMems[] = {4.363323e-5, 3.393696e-6, 3.490659e-7};

std::vector<Mix> mixes() {
  std::vector<Mix> all{{"white", 1, {noise::White{1}}},
                       {"flicker", 1, {noise::Flicker{1}}},
                       {"random walk", 1, {noise::RateRandomWalk{1}}},
                       {"quantization", 1, {noise::Quantization{1}}},
                       {"Gauss-Markov", 1, {noise::GaussMarkov{1, 100}}},
                       {"steep", 1, {noise::Quantization{1}, noise::RateRandomWalk{1e-3}}},
                       {"ramp", 1, {noise::White{1}, noise::RateRamp{1e-3}}},
                       {"line", 1, {noise::White{1}, noise::RateRandomWalk{1e-3}, noise::Sinusoid{3, 0.0503, 0}}}};
  for (const double dt : {0.01, 1.}) {
    for (const auto& gyro : {kIfog, kMems}) {
      const Processes three{noise::White{gyro[0]}, noise::Flicker{gyro[1]}, noise::RateRandomWalk{gyro[2]}};
      all.push_back({"gyro", dt, three});
      all.push_back({"gyro and quantization", dt, three});
      all.back().processes.push_back(noise::Quantization{gyro[0] * 10});
    }
  }
  return all;
}

TEST(Cholesky, ExistsOnOctavesFromSixteenToABillion) {
  // The worst, pure random walk, has a correlation matrix of condition 1e3; 1e-3 leaves no doubt about rounding.
  constexpr double kSmallestPivot = 1e-3;
  for (const Mix& mix : mixes()) {
    for (const std::int64_t samples : {16, 17, 100, 1000, 3600, 36'000, 3'600'000, 100'000'000, 1'000'000'000}) {
      VectorXd theta(mix.processes.size());
      for (Eigen::Index a = 0; a < theta.size(); ++a) {
        theta[a] = std::pow(noise::coefficient(mix.processes[static_cast<std::size_t>(a)]), 2);
      }
      const CurveCovariance covariance(samples, octave_factors(samples), mix.dt, mix.processes);
      const Eigen::LLT<MatrixXd> factor(correlation(covariance(theta)));
      ASSERT_EQ(factor.info(), Eigen::Success) << mix.name << " n " << samples;
      const double pivot = factor.matrixLLT().diagonal().cwiseAbs2().minCoeff();
      ASSERT_GT(pivot, kSmallestPivot) << mix.name << " n " << samples;
    }
  }
}

// ---- against simulation ----------------------------------------------------------------------------------------

TEST(MonteCarlo, CovarianceOfSimulatedCurves) {
  // Each product (s_i - E s_i)(s_j - E s_j) has expectation S_ij; its mean over the records is compared in units of
  // its own standard error. Two-sided normal limit, Bonferroni over all pairs: false alarm 1e-5.
  constexpr int kRecords = 3000;
  constexpr std::int64_t kSamples = 512;
  constexpr double kInterval = 0.5, kLimit = 5.3;  // 2 Q(5.3) = 1.2e-7, times 72 comparisons
  const Processes mix{noise::Quantization{0.1},   noise::White{1},
                      noise::Flicker{0.4},        noise::RateRandomWalk{0.02},
                      noise::GaussMarkov{0.3, 8}, noise::RateRamp{0.003}};
  const Factors factors = octave_factors(kSamples);
  VectorXd theta(mix.size());
  for (Eigen::Index a = 0; a < theta.size(); ++a) {
    theta[a] = std::pow(noise::coefficient(mix[static_cast<std::size_t>(a)]), 2);
  }
  const CurveCovariance covariance(kSamples, factors, kInterval, mix);
  const VectorXd expected = covariance.expectation() * theta;
  const MatrixXd S = covariance(theta);
  const auto count = static_cast<Eigen::Index>(factors.size());

  const noise::RecordGenerator generate(mix, kSamples, kInterval);
  VectorXd mean = VectorXd::Zero(count);
  MatrixXd product = MatrixXd::Zero(count, count), square = product;
  for (int record = 0; record < kRecords; ++record) {
    const Curve curve = overlapped_variance(generate({2, static_cast<std::uint64_t>(record)}), kInterval, factors);
    VectorXd error(count);
    for (Eigen::Index i = 0; i < count; ++i)
      error[i] = curve.points[static_cast<std::size_t>(i)].variance - expected[i];
    mean += error / kRecords;
    const MatrixXd outer = error * error.transpose();
    product += outer / kRecords;
    square += outer.cwiseAbs2() / kRecords;
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    EXPECT_LT(std::abs(mean[i]) / std::sqrt(S(i, i) / kRecords), kLimit)
        << "E at m " << factors[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double error = std::sqrt((square(i, j) - product(i, j) * product(i, j)) / kRecords);
      EXPECT_LT(std::abs(product(i, j) - S(i, j)) / error, kLimit) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace gyrobudget::allan
