// SPDX-License-Identifier: MIT
#include "dynamic.h"

#include "gyrobudget/allan/detail/second_difference.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

using detail::TripleSum;

Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

void check(const DynamicOptions& options, std::int64_t samples, std::span<const std::int64_t> factors) {
  if (options.window < 2 || options.window > samples) {
    throw std::invalid_argument(fmt::format("window is {} samples; for a record of {} it must be from 2 to {}",
                                            options.window, samples, samples));
  }
  if (options.hop < 1)
    throw std::invalid_argument(fmt::format("hop is {} samples; it must be at least 1", options.hop));
  for (const std::int64_t m : factors) {
    if (m < 1 || m > options.window / 2) {
      throw std::invalid_argument(
          fmt::format("averaging factor is {}; for a window of {} samples it must be from 1 to {}", m, options.window,
                      options.window / 2));
    }
  }
}

TripleSum sum_between(const Series& record, std::int64_t m, std::int64_t first, std::int64_t end) {
  const detail::Phase& phase = record.phase();
  const detail::SecondDifference& kernel = detail::second_difference();
  const double* x = phase.x.get() + first;
  if (const Mask* mask = record.mask().get())
    return kernel.masked(x, phase.missing.get() + first, end - first, m, mask->minimum_count(m));
  const double scale = static_cast<double>(m) * static_cast<double>(m);
  return {kernel.complete(x, end - first, m) / scale, end - first};
}

/// One column of the surface: the terms between neighbouring ends of windows, then each window from its
/// stretches.
void fill_column(const Series& record, DynamicSurface& surface, std::size_t column) {
  const std::int64_t m = surface.factors[column], count = surface.window - 2 * m + 1;
  std::vector<std::int64_t> cuts;
  for (std::size_t w = 0; w < surface.time.size(); ++w) {
    const std::int64_t begin = static_cast<std::int64_t>(w) * surface.hop;
    cuts.push_back(begin);
    cuts.push_back(begin + count);
  }
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());

  std::vector<TripleSum> stretches;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) stretches.push_back(sum_between(record, m, cuts[i], cuts[i + 1]));

  std::size_t first = 0;
  for (std::size_t w = 0; w < surface.time.size(); ++w) {
    const std::int64_t begin = static_cast<std::int64_t>(w) * surface.hop;
    while (cuts[first] < begin) ++first;
    TripleSum sum;
    for (std::size_t i = first; cuts[i] < begin + count; ++i) {
      sum.squares += stretches[i].squares;
      sum.terms += stretches[i].terms;
    }
    surface.terms(index(w), index(column)) = sum.terms;
    surface.variance(index(w), index(column)) =
        sum.terms > 0 ? sum.squares / (2 * static_cast<double>(sum.terms)) : std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

DynamicOptions resolved(const DynamicOptions& options, std::int64_t samples) {
  constexpr std::int64_t kWindows = 16, kShortest = 32;
  DynamicOptions result = options;
  if (result.window == 0) result.window = std::min(samples, std::max(kShortest, samples / kWindows));
  if (result.hop == 0) result.hop = std::max<std::int64_t>(1, result.window / 4);
  return result;
}

DynamicSurface dynamic_variance(const Series& record, std::span<const std::int64_t> factors,
                                const DynamicOptions& wanted) {
  const DynamicOptions options = resolved(wanted, record.samples());
  check(options, record.samples(), factors);
  DynamicSurface surface;
  surface.dt = record.dt();
  surface.window = options.window;
  surface.hop = options.hop;
  surface.factors.assign(factors.begin(), factors.end());
  for (std::int64_t begin = 0; begin + options.window <= record.samples(); begin += options.hop)
    surface.time.push_back((static_cast<double>(begin) + static_cast<double>(options.window) / 2) * record.dt());

  surface.variance.resize(index(surface.time.size()), index(factors.size()));
  surface.terms.resize(surface.variance.rows(), surface.variance.cols());
  tbb::parallel_for(std::size_t{0}, factors.size(), [&](std::size_t column) { fill_column(record, surface, column); });
  return surface;
}

Curve DynamicSurface::curve(std::size_t window_index) const {
  Curve curve{dt, window, std::numeric_limits<double>::quiet_NaN()};
  for (std::size_t i = 0; i < factors.size(); ++i) {
    curve.points.push_back({factors[i], variance(index(window_index), index(i)), terms(index(window_index), index(i))});
  }
  return curve;
}

}  // namespace gyrobudget::inline v0::allan
