// SPDX-License-Identifier: MIT
#include "favar.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

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

IrregularPoint irregular_point(const Clusters& clusters, std::size_t m, double samples_per_cell) {
  detail::CompensatedSum squares, weights;
  IrregularPoint result;
  for (std::size_t k = 0; k + m < clusters.sum.size(); ++k) {
    const double one = clusters.count[k], two = clusters.count[k + m];
    if (one == 0 || two == 0) continue;
    const double d = clusters.sum[k + m] / two - clusters.sum[k] / one, weight = one * two / (one + two);
    squares.add(weight * d * d);
    weights.add(weight);
    ++result.terms;
  }
  result.m = static_cast<std::int64_t>(m);
  const double terms = static_cast<double>(result.terms), sum = weights.value();
  result.variance = result.terms > 0 ? squares.value() / (2 * sum) : std::nan("");
  if (result.terms > 0) result.white_ratio = terms / (2 * sum) * static_cast<double>(m) * samples_per_cell;
  return result;
}

/// Samples in cells from the first on, less their mean.
Clusters counted_into_cells(std::span<const double> time, std::span<const double> rate, double cell) {
  double start = HUGE_VAL, end = -HUGE_VAL, count = 0;
  detail::CompensatedSum sum;
  const auto exists = [&](std::size_t i) { return std::isfinite(time[i]) && std::isfinite(rate[i]); };
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!exists(i)) continue;
    start = std::min(start, time[i]);
    end = std::max(end, time[i]);
    sum.add(rate[i]);
    ++count;
  }
  if (count == 0) return {};
  constexpr double kMostCells = 0x1p31;
  const double cells = std::floor((end - start) / cell) + 1;
  if (!(cells <= kMostCells))
    throw std::invalid_argument(
        fmt::format("{:.6g} s in cells of {} s are {:.3g} cells; there may be 2^31", end - start, cell, cells));
  Clusters clusters{std::vector<double>(static_cast<std::size_t>(cells)), {}};
  clusters.count = clusters.sum;
  const double mean = sum.value() / count;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!exists(i)) continue;
    const auto k = static_cast<std::size_t>((time[i] - start) / cell);
    clusters.sum[k] += rate[i] - mean;
    ++clusters.count[k];
  }
  return clusters;
}

}  // namespace

std::vector<IrregularPoint> irregular_variance(std::span<const double> time, std::span<const double> rate,
                                               double cell) {
  if (time.size() != rate.size()) {
    throw std::invalid_argument(
        fmt::format("there are {} times of {} samples; each must have one", time.size(), rate.size()));
  }
  if (!(cell > 0) || !std::isfinite(cell))
    throw std::invalid_argument(fmt::format("cell is {} s; it must be positive and finite", cell));
  Clusters clusters = counted_into_cells(time, rate, cell);
  const std::size_t cells = clusters.sum.size();
  const double samples = std::accumulate(clusters.count.begin(), clusters.count.end(), 0.);
  std::vector<IrregularPoint> points;
  for (std::size_t m = 1; 2 * m <= cells; m *= 2) {
    points.push_back(irregular_point(clusters, m, samples / static_cast<double>(cells)));
    points.back().tau = static_cast<double>(m) * cell;
    double_length(clusters, m);
  }
  return points;
}

Curve recursive_variance(std::span<const double> rate, double dt, double minimum_fill) {
  const Series facts(rate, dt, minimum_fill);
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
