// SPDX-License-Identifier: MIT
#include "identify.h"

#include "gyrobudget/allan/detail/lag_kernel.h"
#include "gyrobudget/allan/detail/means.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

constexpr std::int64_t kStretches = 16, kStretchClusters = 1 << 11;  // looked at, of more clusters than that

void add_means(std::vector<double>& means, const detail::Phase& phase, std::int64_t m, std::int64_t first,
               std::int64_t last) {
  for (std::int64_t k = first * m; k < last * m; k += m) means.push_back(detail::mean_of(phase, k, m));
}

/// Means of adjacent clusters; of very many, some stretches with a missing one between them.
std::vector<double> cluster_means(const detail::Phase& phase, std::int64_t samples, std::int64_t m) {
  const std::int64_t clusters = samples / m;
  std::vector<double> means;
  if (clusters <= kStretches * kStretchClusters) {
    means.reserve(static_cast<std::size_t>(clusters));
    add_means(means, phase, m, 0, clusters);
    return means;
  }
  means.reserve(kStretches * (kStretchClusters + 1));
  for (std::int64_t i = 0; i < kStretches; ++i) {
    const std::int64_t first = i * (clusters - kStretchClusters) / (kStretches - 1);
    if (i > 0) means.push_back(kMissing);
    add_means(means, phase, m, first, first + kStretchClusters);
  }
  return means;
}

double lag1_autocorrelation(const std::vector<double>& z) {
  double sum = 0, count = 0;
  for (const double value : z) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  const double mean = sum / count;
  double squares = 0, products = 0, pairs = 0;
  double before = kMissing;
  for (const double value : z) {
    const double deviation = value - mean, product = deviation * before;
    before = deviation;
    if (!std::isnan(deviation)) squares += deviation * deviation;
    if (std::isnan(product)) continue;
    products += product;
    ++pairs;
  }
  // Without gaps there are count - 1 products; fewer stand for as many.
  return squares > 0 && pairs > 0 ? products / squares * (count - 1) / pairs : 0;
}

void difference(std::vector<double>& z) {
  for (std::size_t i = 0; i + 1 < z.size(); ++i) z[i] = z[i + 1] - z[i];
  z.pop_back();
}

noise::Term term_of(int alpha) {
  if (alpha >= 1) return noise::Term::quantization;
  if (alpha == 0) return noise::Term::white;
  return alpha == -1 ? noise::Term::flicker : noise::Term::rate_random_walk;
}

/// Lag-1 autocorrelation of the differences of adjacent cluster means, exact.
double lag1_of_differences(const noise::Process& process, std::int64_t m) {
  const double lags[] = {0, static_cast<double>(m)};
  double covariance[2];
  detail::lag_kernel(process, {m, m, 1}, lags, covariance);
  return covariance[1] / covariance[0];
}

/// alpha from r1 after one difference: the nearest of white (-1/2), flicker and random walk. Rounding delta would put
/// half of the flicker records at m > 10 with random walk, as means over clusters are smoother than samples.
int alpha_after_difference(double lag1, std::int64_t m) {
  const double flicker = lag1_of_differences(noise::Flicker{1}, m);
  const double walk = lag1_of_differences(noise::RateRandomWalk{1}, m);
  if (lag1 > (flicker + walk) / 2) return -2;
  return lag1 > (flicker - 0.5) / 2 ? -1 : 0;
}

Identified identify(std::vector<double> z, std::int64_t m) {
  constexpr double kStationary = 0.25;
  Identified result;
  result.m = m;
  const auto measure = [&] {
    result.lag1 = lag1_autocorrelation(z);
    return result.lag1 / (1 + result.lag1);
  };
  const double delta = measure();
  if (delta < kStationary || z.size() <= 2) {
    result.alpha = static_cast<int>(std::lround(std::clamp(-2 * delta, -2., 2.)));
  } else {
    difference(z);
    result.differences = 1;
    measure();
    result.alpha = alpha_after_difference(result.lag1, m);
  }
  result.term = term_of(result.alpha);
  return result;
}

/// Whether a noise that held so far still may where `seen` was measured from so many clusters.
bool may_hold(const Identified& seen, noise::Term term, double clusters) {
  const double scatter = 2 / std::sqrt(clusters);
  constexpr double kAngle = -0.25;                      // halfway from white (0) to angle noise (-1/2)
  if (term == noise::Term::quantization) return false;  // it must show itself at each factor
  if (seen.term == noise::Term::quantization) return seen.lag1 > kAngle - scatter;
  if (seen.differences == 1)
    return std::abs(seen.lag1 - lag1_of_differences(noise::unit_process(term), seen.m)) <= scatter;
  if (term == noise::Term::white) return std::abs(seen.lag1) <= scatter;
  constexpr double kStationary = 1. / 3;  // from here on means are differenced
  return kStationary - seen.lag1 <= scatter;
}

}  // namespace

std::vector<Identified> held_noise(std::vector<Identified> found, std::int64_t samples) {
  std::vector<std::size_t> order(found.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return found[i].m; });
  Identified white;
  const Identified* held = &white;
  for (const std::size_t i : order) {
    Identified& seen = found[i];
    const std::int64_t whole = samples / seen.m;
    const double clusters = std::min(static_cast<double>(whole), static_cast<double>(kStretches * kStretchClusters));
    const bool first = held == &white;  // takes what it sees, but angle noise from few clusters
    if ((!first || seen.term == noise::Term::quantization) && may_hold(seen, held->term, clusters)) {
      seen.alpha = held->alpha;
      seen.term = held->term;
    }
    held = &seen;
  }
  return found;
}

std::vector<Identified> identify_noise(const Series& record, std::span<const std::int64_t> factors) {
  record.require_factors(factors);
  constexpr std::int64_t kFewestClusters = 30;
  const std::int64_t longest = std::max<std::int64_t>(1, record.samples() / kFewestClusters);
  const detail::Phase& phase = record.phase();
  std::vector<Identified> result(factors.size());
  tbb::parallel_for(std::size_t{0}, factors.size(), [&](std::size_t i) {
    const std::int64_t m = std::min(factors[i], longest);
    result[i] = identify(cluster_means(phase, record.samples(), m), m);
  });
  return result;
}

std::vector<Identified> identify_noise(std::span<const double> rate, std::span<const std::int64_t> factors) {
  return identify_noise(Series(rate), factors);
}

Identified identify_noise(std::span<const double> rate, std::int64_t m) {
  return identify_noise(rate, std::span(&m, 1)).front();
}

}  // namespace gyrobudget::inline v0::allan
