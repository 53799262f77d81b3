// SPDX-License-Identifier: MIT
#include "outliers.h"

#include <boost/math/special_functions/erf.hpp>
#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::int64_t kReach = 20;       // neighbours on each side
constexpr std::int64_t kLooks = 10000;    // samples that set the scale
constexpr std::int64_t kChunk = 1 << 16;  // of the search, whatever the number of threads
constexpr double kMadToSigma = 1.4826;    // of a Gaussian
constexpr double kScaleMargin = 1.05;     // four standard errors of a scale from 10^4 looks
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Distance of sample k from the median of its surroundings, itself included or not.
double distance_at(std::span<const double> rate, std::int64_t k, bool with_itself = true) {
  std::array<double, 2 * kReach + 1> near{};
  const auto samples = static_cast<std::int64_t>(rate.size());
  auto end = near.begin();
  for (std::int64_t j = std::max<std::int64_t>(0, k - kReach); j <= std::min(samples - 1, k + kReach); ++j) {
    if (j == k && !with_itself) continue;
    if (const double y = rate[static_cast<std::size_t>(j)]; std::isfinite(y)) *end++ = y;
  }
  const auto middle = near.begin() + (end - near.begin()) / 2;
  std::nth_element(near.begin(), middle, end);
  return rate[static_cast<std::size_t>(k)] - *middle;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Second difference, at most a pass of plain arithmetic, that only a suspect has large; NaN beside a gap.
double curvature_at(std::span<const double> rate, std::int64_t k) {
  const auto i = static_cast<std::size_t>(k);
  if (i == 0 || i + 1 == rate.size()) return kNaN;
  return rate[i] - 0.5 * (rate[i - 1] + rate[i + 1]);
}

/// Whether any of a block's samples is one, gaps beside it included; a loop plain enough to become vectors.
bool any_suspect(std::span<const double> rate, std::int64_t first, std::int64_t count, double suspicion) {
  const double* y = rate.data() + first;
  int suspects = 0;
  for (std::int64_t k = 0; k < count; ++k)
    suspects += std::abs(y[k] - 0.5 * (y[k - 1] + y[k + 1])) <= suspicion ? 0 : 1;
  return suspects > 0;
}

struct Scale {
  double distance = 0;   // one sigma
  double curvature = 0;  // one sigma
};

Scale scale_of(std::span<const double> rate) {
  const auto samples = static_cast<std::int64_t>(rate.size());
  const std::int64_t looks = std::min(samples, kLooks);
  std::vector<double> distances, curvatures;
  for (std::int64_t i = 0; i < looks; ++i) {
    const std::int64_t k = i * (samples / looks);
    if (!std::isfinite(rate[static_cast<std::size_t>(k)])) continue;
    distances.push_back(std::abs(distance_at(rate, k)));
    if (const double c = curvature_at(rate, k); std::isfinite(c)) curvatures.push_back(std::abs(c));
  }
  if (distances.empty() || curvatures.empty()) return {};
  double least = std::numeric_limits<double>::infinity();
  for (const double d : distances) {
    if (d > 0) least = std::min(least, d);
  }
  if (std::isinf(least)) return {};
  return {std::max(least, kScaleMargin * kMadToSigma * median(distances)), kMadToSigma * median(curvatures)};
}

/// Suspects of [begin, end) that stand the test, and their neighbours while those do: inside a burst nothing is curved.
std::vector<std::int64_t> search(std::span<const double> rate, std::int64_t begin, std::int64_t end, double limit,
                                 double suspicion) {
  const auto samples = static_cast<std::int64_t>(rate.size());
  std::vector<std::int64_t> found;
  const auto is_outlier = [&](std::int64_t k) {
    return std::isfinite(rate[static_cast<std::size_t>(k)]) && std::abs(distance_at(rate, k)) > limit;
  };
  constexpr std::int64_t kBlock = 64;
  for (std::int64_t k = begin; k < end; ++k) {
    while (k + kBlock < end && k > 0 && !any_suspect(rate, k, kBlock, suspicion)) k += kBlock;
    if (std::abs(curvature_at(rate, k)) <= suspicion || !is_outlier(k)) continue;
    found.push_back(k);
    for (const std::int64_t step : {-1, 1}) {
      for (std::int64_t j = k + step; j >= 0 && j < samples && std::abs(j - k) <= kReach && is_outlier(j); j += step) {
        found.push_back(j);
      }
    }
  }
  return found;
}

}  // namespace

double median_distance(std::span<const double> rate, std::int64_t looks) {
  const auto samples = static_cast<std::int64_t>(rate.size());
  looks = std::min(samples, looks);
  std::vector<double> distances;
  for (std::int64_t i = 0; i < looks; ++i) {
    const std::int64_t k = i * (samples / looks);
    if (!std::isfinite(rate[static_cast<std::size_t>(k)])) continue;
    const double distance = std::abs(distance_at(rate, k, false));
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  return distances.empty() ? 0 : median(distances);
}

std::vector<Outlier> find_outliers(std::span<const double> rate, const OutlierOptions& options) {
  if (!(options.false_alarm > 0 && options.false_alarm < 1)) {
    throw std::invalid_argument(
        fmt::format("false alarm probability is {}; it must be in (0, 1)", options.false_alarm));
  }
  if (!(options.limit >= 0))
    throw std::invalid_argument(fmt::format("limit of outliers is {} sigmas; it must not be negative", options.limit));
  const auto samples = static_cast<std::int64_t>(rate.size());
  const Scale scale = scale_of(rate);
  if (!(scale.distance > 0)) return {};
  const double each = options.false_alarm / static_cast<double>(samples);
  const double sigmas = options.limit > 0 ? options.limit : std::sqrt(2.) * boost::math::erfc_inv(each);
  const double limit = scale.distance * sigmas;
  // The edge of a burst has half its height as curvature; coarse counts have no scale of curvature. Of white noise the
  // curvature at a distance is that distance and 0.7 sigma of the neighbours', over 1.22 in sigmas of its own: beyond a
  // low limit one in a hundred hides behind them.
  constexpr double kSuspicious = 3, kEdge = 0.3, kNeighbours = 0.7 * 2.33, kOwn = 1.22;
  const double suspicious = std::clamp((sigmas - kNeighbours) / kOwn, 0., kSuspicious);
  const double suspicion = std::max(suspicious * scale.curvature, kEdge * limit);
  const auto chunks = static_cast<std::size_t>((samples + kChunk - 1) / kChunk);
  std::vector<std::vector<std::int64_t>> parts(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t i) {
    const std::int64_t begin = static_cast<std::int64_t>(i) * kChunk;
    parts[i] = search(rate, begin, std::min(begin + kChunk, samples), limit, suspicion);
  });
  std::vector<std::int64_t> indices;
  for (const auto& part : parts) indices.insert(indices.end(), part.begin(), part.end());
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  std::vector<Outlier> outliers;
  for (const std::int64_t k : indices) {
    const double distance = distance_at(rate, k);
    outliers.push_back({k, distance, std::abs(distance) / scale.distance});
  }
  return outliers;
}

}  // namespace gyrobudget::inline v0::allan
