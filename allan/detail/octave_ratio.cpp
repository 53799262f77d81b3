// SPDX-License-Identifier: MIT
#include "octave_ratio.h"

#include "gyrobudget/allan/covariance.h"

#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "means.h"

namespace gyrobudget::inline v0::allan::detail {
namespace {

constexpr std::int64_t kMostClusters = 30, kTermsPerCluster = 1024;
constexpr double kPlausible = 0.05;  // of the largest likelihood
constexpr double kScatter95 = 1.96;
// White angle noise: second differences a cluster apart have correlations -4/6 and 1/6, so T of them have T/1.94
// degrees of freedom, and those at m and m/2 next to no correlation.
constexpr double kAngleTerms = 1 + 2 * (16.0 / 36 + 1.0 / 36);

struct Sum {
  double squares = 0, terms = 0;
};

Sum sum_of(const Phase& phase, std::int64_t samples, std::int64_t m, std::int64_t stride) {
  Sum sum;
  for (std::int64_t k = 0; k + 2 * m <= samples; k += stride) {
    const double difference = mean_of(phase, k + m, m) - mean_of(phase, k, m);
    if (!std::isfinite(difference)) continue;
    sum.squares += difference * difference;
    ++sum.terms;
  }
  return sum;
}

// The logarithm of the ratio as one noise has it.
struct Law {
  double mean = 0, variance = 0;
};

// ln of a chi-square over its degrees of freedom, less the logarithm of its mean.
double log_bias(double dof) { return boost::math::digamma(0.5 * dof) - std::log(0.5 * dof); }

Law angle_law(const OctaveRatio& r) {
  const double dof = std::max(1.0, r.terms / kAngleTerms), half_dof = std::max(1.0, r.half_terms / kAngleTerms);
  const double step = std::log(static_cast<double>(r.half) / static_cast<double>(r.m));
  return {2 * step + log_bias(dof) - log_bias(half_dof),
          boost::math::trigamma(0.5 * dof) + boost::math::trigamma(0.5 * half_dof)};
}

// Power laws know no scale: a record with 32 samples a cluster and as many clusters stands in.
Law law_of(noise::Term term, const OctaveRatio& r) {
  constexpr std::int64_t kSamples = 32;
  const auto samples = std::max<std::int64_t>(2 * kSamples, std::llround(r.clusters * kSamples));
  const CurveCovariance both(samples, {kSamples / 2, kSamples}, 1, {noise::unit_process(term)});
  const Eigen::MatrixXd S = both(Eigen::VectorXd::Ones(1));
  const double half_mean = both.expectation()(0, 0), mean = both.expectation()(1, 0);
  const double half_dof = 2 * half_mean * half_mean / S(0, 0), dof = 2 * mean * mean / S(1, 1);
  const double correlation = S(0, 1) / std::sqrt(S(0, 0) * S(1, 1));
  const double variance = boost::math::trigamma(0.5 * dof), half_variance = boost::math::trigamma(0.5 * half_dof);
  return {std::log(mean / half_mean) + log_bias(dof) - log_bias(half_dof),
          variance + half_variance - 2 * correlation * std::sqrt(variance * half_variance)};
}

double log_likelihood(const Law& law, double x) {
  return -0.5 * ((x - law.mean) * (x - law.mean) / law.variance + std::log(law.variance));
}

int alpha_of(noise::Term term) {
  switch (term) {
    case noise::Term::quantization:
      return 2;
    case noise::Term::white:
      return 0;
    case noise::Term::flicker:
      return -1;
    default:
      return -2;
  }
}

}  // namespace

OctaveRatio octave_ratio(const Phase& phase, std::int64_t samples, std::int64_t m) {
  OctaveRatio r{.log_ratio = std::numeric_limits<double>::quiet_NaN(),
                .m = m,
                .half = std::max<std::int64_t>(1, m / 2),
                .clusters = static_cast<double>(samples) / static_cast<double>(m)};
  const auto stride = [&](std::int64_t factor) {
    return std::max<std::int64_t>({1, factor / kTermsPerCluster, samples / (kMostClusters * kTermsPerCluster)});
  };
  const Sum here = sum_of(phase, samples, r.m, stride(r.m)), half = sum_of(phase, samples, r.half, stride(r.half));
  r.terms = here.terms, r.half_terms = half.terms;
  r.log_ratio = std::log(here.squares / here.terms / (half.squares / half.terms));
  return r;
}

void tell_by_ratio(Identified& noise, const OctaveRatio& r) {
  noise.widest = noise::Term::rate_random_walk, noise.share = 1;
  if (!std::isfinite(r.log_ratio)) return;
  using enum noise::Term;
  constexpr std::array kTerms{quantization, white, flicker, rate_random_walk};  // fewer and fewer degrees of freedom
  std::array<double, kTerms.size()> likelihood{};
  const Law angle = angle_law(r);
  for (std::size_t i = 0; i < kTerms.size(); ++i)
    likelihood[i] = log_likelihood(i == 0 ? angle : law_of(kTerms[i], r), r.log_ratio);
  const auto best = std::ranges::max_element(likelihood);
  const auto plausible = [&](std::size_t i) { return likelihood[i] >= *best + std::log(kPlausible); };
  std::size_t held = 0, last = 0;
  for (std::size_t i = 0; i < kTerms.size(); ++i) {
    if (kTerms[i] == noise.term) held = i;
    if (plausible(i)) last = i;
  }
  if (!plausible(held)) {
    noise.term = kTerms[static_cast<std::size_t>(best - likelihood.begin())];
    noise.alpha = alpha_of(noise.term);
  }
  if (last > 0) {
    noise.widest = kTerms[last];
    noise.share = noise.widest == noise.term ? 0 : 1;
    return;
  }
  // A part e of white noise at m is e/2 at m/2: the ratio rises by 1 + e/2.
  const double rise = std::max(0.0, r.log_ratio - angle.mean) + kScatter95 * std::sqrt(angle.variance);
  noise.share = std::min(1.0, 2 * rise);
}

}  // namespace gyrobudget::inline v0::allan::detail
