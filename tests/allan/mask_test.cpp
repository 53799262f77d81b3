// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/mask.h"

#include "gyrobudget/allan/confidence.h"
#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/detail/triples.h"
#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

namespace gyrobudget::allan {
namespace {

using Factors = std::vector<std::int64_t>;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// ---- masks to try ----------------------------------------------------------------------------------------------

std::vector<bool> all_exist(std::int64_t samples) { return std::vector<bool>(static_cast<std::size_t>(samples), true); }

std::vector<bool> random_losses(std::int64_t samples, double part, unsigned seed) {
  std::vector<bool> exists = all_exist(samples);
  std::mt19937_64 bits(seed);
  for (std::size_t k = 0; k < exists.size(); ++k) {
    exists[k] = static_cast<double>(bits() >> 11) * 0x1p-53 >= part;
  }
  return exists;
}

std::vector<bool> blocks(std::int64_t samples, std::initializer_list<Mask::Gap> runs) {
  std::vector<bool> exists = all_exist(samples);
  for (const Mask::Gap& run : runs) {
    for (std::int64_t k = 0; k < run.count; ++k) exists[static_cast<std::size_t>(run.first + k)] = false;
  }
  return exists;
}

Mask mask_of(const std::vector<bool>& exists, double fill) {
  std::vector<Mask::Gap> runs;
  for (std::size_t k = 0; k < exists.size(); ++k) {
    if (exists[k]) continue;
    if (k == 0 || exists[k - 1]) runs.push_back({static_cast<std::int64_t>(k), 0});
    ++runs.back().count;
  }
  return Mask(static_cast<std::int64_t>(exists.size()), runs, fill);
}

struct Case {
  const char* name;
  std::vector<bool> exists;
};

std::vector<Case> cases(std::int64_t n) {
  return {{"1 % lost", random_losses(n, 0.01, 1)},
          {"5 % lost", random_losses(n, 0.05, 2)},
          {"gaps", blocks(n, {{n / 7, 2}, {n / 3, 9}, {n / 2, 1}, {n / 2 + 3, 1}, {3 * n / 4, n / 50}})},
          {"ends", blocks(n, {{0, 3}, {n - 5, 5}})},
          {"both", [&] {
             std::vector<bool> exists = random_losses(n, 0.01, 3);
             for (std::int64_t k = n / 2; k < n / 2 + n / 60; ++k) exists[static_cast<std::size_t>(k)] = false;
             return exists;
           }()}};
}

/// The weights with which the samples of a triple enter d = mean 2 - mean 1; empty where it does not count.
std::vector<double> weights(const std::vector<bool>& exists, std::int64_t k, std::int64_t m, std::int64_t least) {
  std::vector<double> w(static_cast<std::size_t>(2 * m), 0.);
  for (std::int64_t cluster = 0; cluster < 2; ++cluster) {
    std::int64_t count = 0;
    for (std::int64_t i = 0; i < m; ++i) count += exists[static_cast<std::size_t>(k + cluster * m + i)] ? 1 : 0;
    if (count < least) return {};
    for (std::int64_t i = 0; i < m; ++i) {
      const std::int64_t at = cluster * m + i;
      if (exists[static_cast<std::size_t>(k + at)]) {
        w[static_cast<std::size_t>(at)] = (cluster == 0 ? -1. : 1.) / static_cast<double>(count);
      }
    }
  }
  return w;
}

std::vector<std::int64_t> members(const detail::Ranges& ranges) {
  std::vector<std::int64_t> all;
  for (const auto& range : ranges.ranges()) {
    for (std::int64_t k = range.first; k < range.end; ++k) all.push_back(k);
  }
  return all;
}

// ---- which clusters count --------------------------------------------------------------------------------------

TEST(Mask, RoundsTheFewestSamplesUp) {
  const Mask mask(100, {}, 0.95);
  EXPECT_EQ(mask.minimum_count(1), 1);
  EXPECT_EQ(mask.minimum_count(19), 19);
  EXPECT_EQ(mask.minimum_count(20), 19);
  EXPECT_EQ(mask.minimum_count(21), 20);
  for (std::int64_t m = 20; m <= 2'000'000'000; m *= 10) EXPECT_EQ(mask.minimum_count(m), m / 20 * 19);
  EXPECT_EQ(Mask(100, {}, 1).minimum_count(1'000'003), 1'000'003);
  EXPECT_EQ(Mask(100, {}, 1e-9).minimum_count(7), 1);
}

TEST(Mask, MisuseThrows) {
  using Runs = std::vector<Mask::Gap>;
  for (const Runs& runs : {Runs{{-1, 2}}, Runs{{9, 2}}, Runs{{3, 0}}, Runs{{3, 2}, {5, 1}}, Runs{{5, 1}, {2, 1}}}) {
    EXPECT_THROW(Mask(10, runs, 0.95), std::invalid_argument);
  }
  for (const double fill : {0., -1., 1.5, kNaN}) EXPECT_THROW(Mask(10, {}, fill), std::invalid_argument);
  EXPECT_THROW(Mask(std::int64_t{1} << 32, {}, 0.95), std::invalid_argument);
  const Mask mask(10, {{2, 1}}, 0.95);
  EXPECT_EQ(mask.missing(), 1);
  EXPECT_THROW((void)mask.expectation_ratio(noise::White{1}, 6, 1), std::invalid_argument);
  EXPECT_THROW((void)mask.expectation_ratio(noise::White{1}, 1, -1), std::invalid_argument);
}

TEST(Triples, AreThoseOfTheDefinition) {
  constexpr std::int64_t kSamples = 700;
  for (const Case& c : cases(kSamples)) {
    for (const double fill : {0.5, 0.95, 1.}) {
      const Mask mask = mask_of(c.exists, fill);
      for (const Form form : {Form::full, Form::ieee}) {
        for (const std::int64_t m : {1, 2, 3, 19, 20, 40, 99, 200, 350}) {
          const detail::Triples triples = detail::find_triples(mask, m, form);
          std::vector<std::int64_t> valid, touched;
          double white = 0;
          for (std::int64_t k = first_triple(form); k < first_triple(form) + complete_terms(kSamples, m, form); ++k) {
            const std::vector<double> w = weights(c.exists, k, m, mask.minimum_count(m));
            if (w.empty()) continue;
            valid.push_back(k);
            bool complete = true;
            for (const double weight : w) {
              complete = complete && weight != 0;
              white += weight * weight * static_cast<double>(m) / 2;
            }
            if (!complete) touched.push_back(k);
          }
          ASSERT_EQ(members(triples.valid), valid) << c.name << " m " << m << " fill " << fill;
          ASSERT_EQ(members(triples.touched), touched) << c.name << " m " << m << " fill " << fill;
          if (!valid.empty()) {
            ASSERT_NEAR(triples.white_ratio, white / static_cast<double>(valid.size()), 1e-11);
          }
        }
      }
    }
  }
}

TEST(Ranges, CountPairsAtEveryOffset) {
  const auto some = [](unsigned seed, double part, std::int64_t size) {
    detail::Ranges ranges;
    const std::vector<bool> in = random_losses(size, part, seed);
    for (std::int64_t k = 0; k < size; ++k) {
      if (in[static_cast<std::size_t>(k)]) ranges.append(k, k + 1);
    }
    return ranges;
  };
  detail::Ranges two;
  two.append(10, 60);
  two.append(80, 81);
  const detail::Ranges many = some(1, 0.4, 300), others = some(2, 0.1, 250);
  const auto brute = [](const detail::Ranges& a, const detail::Ranges& b, std::int64_t h) {
    const auto second = members(b);
    const std::set<std::int64_t> set(second.begin(), second.end());
    std::int64_t count = 0;
    for (const std::int64_t k : members(a)) count += set.count(k + h) != 0 ? 1 : 0;
    return count;
  };
  for (std::int64_t h = -320; h <= 320; h += 7) {
    ASSERT_EQ(count_pairs(many, others, h), brute(many, others, h));
    ASSERT_EQ(count_pairs(two, many, h), brute(two, many, h));  // few ranges against many: by search
    ASSERT_EQ(count_pairs(many, two, h), brute(many, two, h));
  }
  EXPECT_EQ(count_pairs({}, many, 0), 0);
  const std::vector<std::int64_t> all = members(many);
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    ASSERT_EQ(many.at(static_cast<std::int64_t>(rank)), all[rank]);
  }
}

// ---- expectation: all triples, all samples ---------------------------------------------------------------------

double brute_ratio(const std::vector<bool>& exists, const Mask& mask, std::int64_t m, const noise::Process& process,
                   double dt) {
  std::vector<double> D(static_cast<std::size_t>(2 * m));
  for (std::size_t h = 0; h < D.size(); ++h) {
    D[h] = noise::structure_function(process, static_cast<std::int64_t>(h), dt);
  }
  double sum = 0;
  std::int64_t terms = 0;
  for (std::int64_t k = 0; k + 2 * m <= mask.samples(); ++k) {
    const std::vector<double> w = weights(exists, k, m, mask.minimum_count(m));
    if (w.empty()) continue;
    double square = 0;
    for (std::size_t i = 0; i < w.size(); ++i) {
      double row = 0;
      for (std::size_t j = 0; j < i; ++j) row += w[j] * D[i - j];
      square -= w[i] * row;
    }
    sum += square;
    ++terms;
  }
  return sum / static_cast<double>(terms) / 2 / noise::allan_variance(process, m, dt);
}

// The bound that mask.h states.
constexpr double kRatioError = 1e-3, kRatioShare = 0.05;

class ExpectationRatio : public testing::TestWithParam<noise::Process> {};

TEST_P(ExpectationRatio, AgreesWithAllTriplesAndAllSamples) {
  constexpr std::int64_t kSamples = 1000;
  constexpr double kInterval = 0.1;
  for (const Case& c : cases(kSamples)) {
    const Mask mask = mask_of(c.exists, 0.95);
    for (const std::int64_t m : {1, 10, 20, 33, 64, 150}) {
      const double ratio = mask.expectation_ratio(GetParam(), m, kInterval);
      if (detail::find_triples(mask, m, Form::full).valid.size() == 0) {
        EXPECT_TRUE(std::isnan(ratio));
        continue;
      }
      const double truth = brute_ratio(c.exists, mask, m, GetParam(), kInterval);
      EXPECT_NEAR(ratio, truth, kRatioError + kRatioShare * std::abs(truth - 1)) << c.name << " m " << m;
      if (mask.minimum_count(m) == m) {
        EXPECT_EQ(ratio, 1);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Processes, ExpectationRatio,
                         testing::Values(noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1},
                                         noise::Quantization{1}, noise::RateRamp{1}, noise::GaussMarkov{1, 0.05},
                                         noise::GaussMarkov{1, 2}, noise::GaussMarkov{1, 500},
                                         noise::Sinusoid{1, 0.31, 0}),
                         [](const testing::TestParamInfo<noise::Process>& process) {
                           std::string name = std::to_string(process.index);
                           name.push_back(static_cast<char>(noise::term(process.param)));
                           return name;
                         });

TEST(ExpectationRatio, OfWhiteNoiseIsExact) {
  constexpr double kRounding = 1e-11;
  const std::vector<bool> exists = random_losses(1000, 0.03, 9);
  const Mask mask = mask_of(exists, 0.9);
  for (const std::int64_t m : {20, 50, 200, 500}) {
    const double ratio = mask.expectation_ratio(noise::White{3}, m, 0.1);
    EXPECT_NEAR(ratio, brute_ratio(exists, mask, m, noise::White{1}, 0.1), kRounding);
  }
}

// ---- covariance: all pairs of terms, all samples ---------------------------------------------------------------

/// Exact covariance matrix of the masked estimates, upper triangle.
Eigen::MatrixXd brute_covariance(const std::vector<bool>& exists, double fill, const Factors& factors, double dt,
                                 std::span<const noise::Process> mix) {
  const Mask mask = mask_of(exists, fill);
  std::vector<double> D(exists.size());
  for (std::size_t h = 0; h < D.size(); ++h) {
    for (const auto& process : mix) {
      D[h] += noise::structure_function(process, static_cast<std::int64_t>(h), dt);
    }
  }
  // -1/2 W D W' over all triples: as a matrix of samples x triples per factor.
  const auto n = static_cast<Eigen::Index>(exists.size());
  Eigen::MatrixXd structure(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) structure(i, j) = -D[static_cast<std::size_t>(std::abs(i - j))] / 4;
  }
  std::vector<Eigen::MatrixXd> W;
  for (const std::int64_t m : factors) {
    std::vector<std::pair<std::int64_t, std::vector<double>>> rows;
    for (std::int64_t k = 0; k + 2 * m <= mask.samples(); ++k) {
      auto w = weights(exists, k, m, mask.minimum_count(m));
      if (!w.empty()) rows.emplace_back(k, std::move(w));
    }
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(rows.size()));
    for (std::size_t r = 0; r < rows.size(); ++r) {
      for (std::size_t i = 0; i < rows[r].second.size(); ++i) {
        all(rows[r].first + static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(r)) = rows[r].second[i];
      }
    }
    W.push_back(std::move(all));
  }
  Eigen::MatrixXd S(factors.size(), factors.size());
  for (std::size_t i = 0; i < W.size(); ++i) {
    const Eigen::MatrixXd left = W[i].transpose() * structure;
    for (std::size_t j = i; j < W.size(); ++j) {
      const Eigen::MatrixXd C = left * W[j];
      S(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          2 * C.squaredNorm() / static_cast<double>(C.size());
    }
  }
  return S;
}

// The bounds that covariance.h states: where at least half of the triples count, and where fewer do.
constexpr double kCovarianceError = 0.01, kSparseCovarianceError = 0.08;

TEST(MaskedCovariance, AgreesWithAllPairsOfTerms) {
  constexpr std::int64_t kSamples = 500;
  constexpr double kInterval = 0.5, kFill = 0.95;
  const Factors factors{1, 16, 32, 64, 128};
  const std::vector<std::vector<noise::Process>> mixes{
      {noise::White{1}}, {noise::RateRandomWalk{1}}, {noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{0.1}}};
  for (const Case& c : cases(kSamples)) {
    const Mask mask = mask_of(c.exists, kFill);
    const auto sparse = [&](Eigen::Index i) {
      const std::int64_t m = factors[static_cast<std::size_t>(i)];
      return 2 * detail::find_triples(mask, m, Form::full).valid.size() < complete_terms(kSamples, m, Form::full);
    };
    for (const auto& mix : mixes) {
      Eigen::VectorXd theta(mix.size());
      for (std::size_t a = 0; a < mix.size(); ++a) {
        theta[static_cast<Eigen::Index>(a)] = std::pow(noise::coefficient(mix[a]), 2);
      }
      const Eigen::MatrixXd truth = brute_covariance(c.exists, kFill, factors, kInterval, mix);
      const Eigen::MatrixXd S = CurveCovariance(kSamples, factors, kInterval, mix, Form::full, &mask)(theta);
      for (Eigen::Index i = 0; i < S.rows(); ++i) {
        for (Eigen::Index j = i; j < S.cols(); ++j) {
          if (std::isnan(truth(i, j))) {
            EXPECT_TRUE(std::isnan(S(i, j)));
            continue;
          }
          const double error = (S(i, j) - truth(i, j)) / std::sqrt(truth(i, i) * truth(j, j));
          EXPECT_NEAR(error, 0, sparse(i) || sparse(j) ? kSparseCovarianceError : kCovarianceError)
              << c.name << ", processes " << mix.size() << ", factors " << i << " " << j;
        }
      }
    }
  }
}

TEST(MaskedCovariance, CountsPartOfTheTriplesWhereGapsAreMany) {
  // At m = 1 white noise has C(0) = 1, C(1) = -1/2: edf = M^2 / (M + pairs of neighbours / 2), counted in full here.
  constexpr std::int64_t kSamples = 600'000;
  constexpr double kSampling = 0.005;
  const std::vector<bool> exists = random_losses(kSamples, 0.01, 4);
  const Mask mask = mask_of(exists, 0.95);
  const noise::Process white[] = {noise::White{1}};
  double terms = 0, neighbours = 0;
  for (std::size_t k = 0; k + 2 < exists.size(); ++k) {
    terms += exists[k] && exists[k + 1] ? 1 : 0;
    neighbours += exists[k] && exists[k + 1] && exists[k + 2] ? 1 : 0;
  }
  const double truth = terms * terms / (terms + neighbours / 2);
  EXPECT_NEAR(equivalent_dof(kSamples, 1, 1, white, Form::full, &mask) / truth, 1, kSampling);

  const detail::Ranges all = detail::find_triples(mask, 1, Form::full).valid;
  const detail::Ranges part = all.sample(1000);
  EXPECT_LE(part.ranges().size(), 1000U);
  EXPECT_NEAR(static_cast<double>(part.size()) / static_cast<double>(all.size()) * 6000 / 1000, 1, 0.1);
  EXPECT_LT(part.ranges().front().first, kSamples / 64);
  EXPECT_GT(part.ranges().back().end, kSamples - kSamples / 64);
  EXPECT_EQ(all.sample(1'000'000).size(), all.size());
}

TEST(MaskedCovariance, WithoutLossesIsTheCompleteOne) {
  const Mask mask(1000, {}, 0.95);
  const std::vector<noise::Process> mix{noise::White{1}, noise::Flicker{1}};
  const CurveCovariance masked(1000, octave_factors(1000), 1, mix, Form::full, &mask);
  const CurveCovariance complete(1000, octave_factors(1000), 1, mix);
  EXPECT_EQ(masked(Eigen::Vector2d(1, 1)), complete(Eigen::Vector2d(1, 1)));
}

// ---- end to end: simulated records with losses -----------------------------------------------------------------

TEST(MaskedMonteCarlo, CorrectedVarianceIsUnbiasedAndDegreesOfFreedomHold) {
  // Two-sided normal limits for mean and variance at 10 factors under 5 masks: 100 comparisons at 2 Q(5.3) = 1.2e-7,
  // false alarm 1.2e-5. The covariance has its stated error beside the sampling error.
  constexpr int kRecords = 1500;
  constexpr std::int64_t kSamples = 1024;
  constexpr double kInterval = 1, kLimit = 5.3;
  const std::vector<noise::Process> mix{noise::White{1}, noise::Flicker{0.2}, noise::RateRandomWalk{0.01}};
  const Factors factors = octave_factors(kSamples);
  const noise::RecordGenerator generate(mix, kSamples, kInterval);

  for (const Case& c : cases(kSamples)) {
    const Mask mask = mask_of(c.exists, 0.95);
    std::vector<double> expected(factors.size()), mean(factors.size()), square(factors.size()), fourth(factors.size());
    for (std::size_t i = 0; i < factors.size(); ++i) {
      for (const auto& process : mix) {
        expected[i] += noise::allan_variance(process, factors[i], kInterval) *
                       mask.expectation_ratio(process, factors[i], kInterval);
      }
    }
    for (int record = 0; record < kRecords; ++record) {
      std::vector<double> rate = generate({3, static_cast<std::uint64_t>(record)});
      for (std::size_t k = 0; k < rate.size(); ++k) {
        if (!c.exists[k]) rate[k] = kNaN;
      }
      const Curve curve = overlapped_variance(rate, kInterval, factors);
      for (std::size_t i = 0; i < factors.size(); ++i) {
        const double error = curve.points[i].variance - expected[i];
        mean[i] += error / kRecords;
        square[i] += error * error / kRecords;
        fourth[i] += std::pow(error, 4) / kRecords;
      }
    }
    for (std::size_t i = 0; i < factors.size(); ++i) {
      if (std::isnan(expected[i])) continue;
      const double edf = equivalent_dof(kSamples, factors[i], kInterval, mix, Form::full, &mask);
      const double variance = 2 * expected[i] * expected[i] / edf;
      EXPECT_LT(std::abs(mean[i]) / std::sqrt(variance / kRecords), kLimit) << c.name << " m " << factors[i];
      const double error = std::sqrt((fourth[i] - square[i] * square[i]) / kRecords);
      EXPECT_LT(std::abs(square[i] - variance), kLimit * error + kCovarianceError * variance)
          << c.name << " m " << factors[i];
    }
  }
}

}  // namespace
}  // namespace gyrobudget::allan
