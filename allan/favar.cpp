// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/favar.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::allan {
namespace {

/// Sums over the clusters that begin at each sample, and how many of their samples exist.
struct Clusters {
  std::vector<double> sum;
  std::vector<double> count;
};

Clusters single_samples(std::span<const double> rate) {
  Clusters clusters;
  for (const double sample : rate) {
    const bool exists = std::isfinite(sample);
    clusters.sum.push_back(exists ? sample : 0);
    clusters.count.push_back(exists ? 1 : 0);
  }
  return clusters;
}

void double_length(Clusters& clusters, std::size_t m) {
  const std::size_t left = clusters.sum.size() - m;
  for (std::size_t k = 0; k < left; ++k) {
    clusters.sum[k] += clusters.sum[k + m];
    clusters.count[k] += clusters.count[k + m];
  }
  clusters.sum.resize(left);
  clusters.count.resize(left);
}

Point point(const Clusters& clusters, std::size_t m, double least) {
  detail::CompensatedSum squares;
  std::int64_t terms = 0;
  for (std::size_t k = 0; k + m < clusters.sum.size(); ++k) {
    const double one = clusters.count[k], two = clusters.count[k + m];
    if (std::min(one, two) < least) continue;
    const double d = clusters.sum[k + m] / two - clusters.sum[k] / one;
    squares.add(d * d);
    ++terms;
  }
  const double variance = terms > 0 ? squares.value() / (2 * static_cast<double>(terms)) : std::nan("");
  return {static_cast<std::int64_t>(m), variance, terms};
}

}  // namespace

Curve recursive_variance(std::span<const double> rate, double dt, double minimum_fill) {
  const RateRecord facts(rate, dt, minimum_fill);
  Curve curve{dt, facts.samples(), facts.mean(), Form::full, {}, facts.mask()};
  Clusters clusters = single_samples(rate);
  for (std::size_t m = 1; 2 * m <= rate.size(); m *= 2) {
    const auto least = facts.mask() ? facts.mask()->minimum_count(static_cast<std::int64_t>(m)) : 1;
    curve.points.push_back(point(clusters, m, static_cast<double>(least)));
    double_length(clusters, m);
  }
  return curve;
}

}  // namespace gyrobudget::inline v0::allan
