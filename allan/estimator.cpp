// SPDX-License-Identifier: MIT
#include "estimator.h"

#include <algorithm>
#include <iterator>

#include "factors.h"

namespace gyrobudget::inline v0::allan {

std::string_view name(Estimator estimator) {
  constexpr std::string_view kNames[] = {"adev",    "oadev",   "mdev",    "tdev",  "hdev",   "ohdev", "totdev",
                                         "mtotdev", "ttotdev", "htotdev", "theo1", "theobr", "theoh", "pdev"};
  static_assert(std::size(kNames) == std::size(kEstimators));
  return kNames[static_cast<std::size_t>(estimator)];
}

std::optional<Estimator> estimator_named(std::string_view wanted) {
  const auto* const found = std::find_if(std::begin(kEstimators), std::end(kEstimators),
                                         [&](Estimator estimator) { return name(estimator) == wanted; });
  if (found == std::end(kEstimators)) return std::nullopt;
  return *found;
}

namespace {
constexpr std::int64_t kFewestForRatio = 18;  // samples: the first one takes the oadev at m = 9
constexpr std::int64_t kFewestForTheo1 = 40;  // samples, so that Theo1 has terms at a fifth of them
}  // namespace

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
    case Estimator::theobr:
      return {12, samples < kFewestForRatio ? 0 : samples - samples % 2, 2};
    case Estimator::theoh:
      return {1, samples < kFewestForTheo1 ? samples / 5 : 3 * (samples / 4), 1};
    case Estimator::pdev:
      return {1, samples / 2, 1};
  }
  return {1, 0, 1};
}

bool has_terms(Estimator estimator, std::int64_t samples, std::int64_t m) {
  const FactorRange range = factor_range(estimator, samples);
  if (m < range.least || m > range.most || m % range.step != 0) return false;
  const bool is_theo1 = basis_of(estimator, samples, m).estimator == Estimator::theo1;
  return estimator != Estimator::theoh || !is_theo1 || m % 3 == 0;
}

std::vector<std::int64_t> octave_factors(Estimator estimator, std::int64_t samples) {
  // The longest lists of all serve the estimators that reach tau = T.
  return usable_factors(estimator, samples, octave_factors(2 * samples));
}

std::vector<std::int64_t> usable_factors(Estimator estimator, std::int64_t samples,
                                         std::span<const std::int64_t> factors) {
  std::vector<std::int64_t> usable;
  for (std::int64_t m : factors) {
    const bool stretched = estimator == Estimator::theo1 || estimator == Estimator::theobr;
    if (stretched) m = (2 * m + 1) / 3 * 2;  // 4m/3, to the nearest even number
    if (estimator == Estimator::theoh && 5 * m > samples) m = (m + 1) / 3 * 3;
    if (has_terms(estimator, samples, m)) usable.push_back(m);
  }
  std::sort(usable.begin(), usable.end());
  usable.erase(std::unique(usable.begin(), usable.end()), usable.end());
  return usable;
}

}  // namespace gyrobudget::inline v0::allan
