// SPDX-License-Identifier: MIT
#include "steps.h"

#include "gyrobudget/allan/detail/means.h"

#include <boost/math/special_functions/erf.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::int64_t kShortest = 32;        // cluster
constexpr std::int64_t kFewestClusters = 32;  // in the record, for a scale
constexpr std::int64_t kFewestSamples = 2048;
constexpr std::int64_t kPerCluster = 4;  // differences begin every m/4 samples

/// Difference of the cluster means either side of a sample, relative to what chance allows.
struct Difference {
  std::int64_t middle = 0;
  std::int64_t m = 0;
  double excess = 0;  // |difference| / limit
  double sigma = 0;
};

double median_size(const std::vector<double>& differences) {
  std::vector<double> sizes;
  for (const double d : differences) {
    if (std::isfinite(d)) sizes.push_back(std::abs(d));
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

/// Differences at one factor that leave what chance allows.
void add_excesses(std::vector<Difference>& found, const Series& record, std::int64_t m, double limit) {
  constexpr double kMadToSigma = 1.4826, kMadScatter = 1.17, kStandardErrors = 4;
  const std::int64_t stride = m / kPerCluster;
  std::vector<double> differences;
  for (std::int64_t k = 0; k + 2 * m <= record.samples(); k += stride) {
    differences.push_back(detail::mean_of(record.phase(), k + m, m) - detail::mean_of(record.phase(), k, m));
  }
  const double independent = static_cast<double>(record.samples()) / static_cast<double>(m);
  const double margin = 1 + kStandardErrors * kMadScatter / std::sqrt(independent);
  const double sigma = kMadToSigma * median_size(differences);
  if (!(sigma > 0)) return;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    const double excess = std::abs(differences[i]) / (limit * margin * sigma);
    if (excess > 1) found.push_back({static_cast<std::int64_t>(i) * stride + m, m, excess, sigma});
  }
}

/// Where within half a cluster of the middle the means either side differ most.
Step placed(const Series& record, const Difference& d) {
  Step step{.index = d.middle, .span = d.m};
  const std::int64_t begin = d.middle - d.m, end = d.middle + d.m;
  double best = -1;
  for (std::int64_t k = d.middle - d.m / 2; k <= d.middle + d.m / 2; ++k) {
    const double size = detail::mean_of(record.phase(), k, end - k) - detail::mean_of(record.phase(), begin, k - begin);
    // Sum of squares between the two parts.
    const double between = size * size * static_cast<double>(k - begin) * static_cast<double>(end - k);
    if (between > best) best = between, step.index = k;
  }
  const std::int64_t before = std::max<std::int64_t>(0, step.index - d.m);
  const std::int64_t after = std::min(record.samples(), step.index + d.m);
  step.size = detail::mean_of(record.phase(), step.index, after - step.index) -
              detail::mean_of(record.phase(), before, step.index - before);
  step.sigmas = std::abs(step.size) / d.sigma;
  return step;
}

}  // namespace

std::vector<Step> find_steps(const Series& record, const StepOptions& options) {
  if (!(options.false_alarm > 0 && options.false_alarm < 1)) {
    throw std::invalid_argument(
        fmt::format("false alarm probability is {}; it must be in (0, 1)", options.false_alarm));
  }
  if (record.samples() < kFewestSamples) return {};
  // Differences at all factors: 4 n/m each, twice those of the shortest together.
  const double tests = 2. * kPerCluster * static_cast<double>(record.samples()) / kShortest;
  const double limit = std::sqrt(2.) * boost::math::erfc_inv(options.false_alarm / tests);
  std::vector<Difference> found;
  for (std::int64_t m = record.samples() / kFewestClusters; m >= kShortest; m /= 2)
    add_excesses(found, record, m, limit);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.excess > b.excess; });
  std::vector<Step> steps;
  for (const Difference& d : found) {
    if (steps.size() == options.most) break;
    const bool explained = std::any_of(steps.begin(), steps.end(),
                                       [&](const Step& s) { return std::abs(s.index - d.middle) < d.m + s.span / 2; });
    if (explained) continue;
    const Step step = placed(record, d);
    if (std::isfinite(step.size)) steps.push_back(step);  // none beside a gap that leaves no mean
  }
  std::sort(steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
  return steps;
}

}  // namespace gyrobudget::inline v0::allan
