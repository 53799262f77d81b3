// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/estimator.h"

#include "gyrobudget/allan/factors.h"

#include <algorithm>
#include <iterator>

namespace gyrobudget::inline v0::allan {

std::string_view name(Estimator estimator) {
  constexpr std::string_view kNames[] = {"adev",   "oadev",   "mdev",    "tdev",    "hdev", "ohdev",
                                         "totdev", "mtotdev", "ttotdev", "htotdev", "theo1"};
  static_assert(std::size(kNames) == std::size(kEstimators));
  return kNames[static_cast<std::size_t>(estimator)];
}

std::optional<Estimator> estimator_named(std::string_view wanted) {
  const auto* const found = std::find_if(std::begin(kEstimators), std::end(kEstimators),
                                         [&](Estimator estimator) { return name(estimator) == wanted; });
  if (found == std::end(kEstimators)) return std::nullopt;
  return *found;
}

FactorRange factor_range(Estimator estimator, std::int64_t samples) {
  switch (estimator) {
    case Estimator::adev:
    case Estimator::oadev:
      return {1, samples / 2, 1};
    case Estimator::mdev:
    case Estimator::tdev:
    case Estimator::mtotdev:
    case Estimator::ttotdev:
      return {1, samples < 2 ? 0 : (samples + 1) / 3, 1};
    case Estimator::hdev:
    case Estimator::ohdev:
    case Estimator::htotdev:
      return {1, samples / 3, 1};
    case Estimator::totdev:
      return {1, samples - 1, 1};
    case Estimator::theo1:
      return {10, samples - samples % 2, 2};
  }
  return {1, 0, 1};
}

std::vector<std::int64_t> octave_factors(Estimator estimator, std::int64_t samples) {
  // The longest lists of all serve the estimators that reach tau = T.
  return usable_factors(estimator, samples, octave_factors(2 * samples));
}

std::vector<std::int64_t> usable_factors(Estimator estimator, std::int64_t samples,
                                         std::span<const std::int64_t> factors) {
  const FactorRange range = factor_range(estimator, samples);
  std::vector<std::int64_t> usable;
  for (std::int64_t m : factors) {
    if (estimator == Estimator::theo1) m = (2 * m + 1) / 3 * 2;  // 4m/3, to the nearest even number
    if (m >= range.least && m <= range.most) usable.push_back(m);
  }
  std::sort(usable.begin(), usable.end());
  usable.erase(std::unique(usable.begin(), usable.end()), usable.end());
  return usable;
}

}  // namespace gyrobudget::inline v0::allan
