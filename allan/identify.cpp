// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/identify.h"

#include "gyrobudget/allan/detail/lag_kernel.h"
#include "gyrobudget/allan/detail/phase.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Means of adjacent clusters; NaN where too few samples exist.
std::vector<double> cluster_means(const detail::Phase& phase, std::int64_t samples, std::int64_t m) {
  constexpr double kLeastPart = 0.5;
  std::vector<double> means;
  means.reserve(static_cast<std::size_t>(samples / m));
  for (std::int64_t k = 0; k + m <= samples; k += m) {
    const std::uint32_t missing = phase.missing ? phase.missing[k + m] - phase.missing[k] : 0;
    const double existing = static_cast<double>(m) - missing, least = kLeastPart * static_cast<double>(m);
    means.push_back(existing >= least ? (phase.x[k + m] - phase.x[k]) / existing : kMissing);
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

}  // namespace

std::vector<Identified> identify_noise(std::span<const double> rate, std::span<const std::int64_t> factors) {
  const auto samples = static_cast<std::int64_t>(rate.size());
  for (const std::int64_t m : factors) {
    if (m < 1 || m > samples / 2) {
      throw std::invalid_argument(
          fmt::format("averaging factor is {}; for a record of {} samples it must be from 1 to {}", m,
                      samples, samples / 2));
    }
  }
  constexpr std::int64_t kFewestClusters = 30;
  const std::int64_t longest = std::max<std::int64_t>(1, samples / kFewestClusters);
  const detail::Phase phase = detail::integrate(rate, detail::census(rate, 1));
  std::vector<Identified> result(factors.size());
  tbb::parallel_for(std::size_t{0}, factors.size(), [&](std::size_t i) {
    const std::int64_t m = std::min(factors[i], longest);
    result[i] = identify(cluster_means(phase, samples, m), m);
  });
  return result;
}

Identified identify_noise(std::span<const double> rate, std::int64_t m) {
  return identify_noise(rate, std::span(&m, 1)).front();
}

}  // namespace gyrobudget::inline v0::allan
