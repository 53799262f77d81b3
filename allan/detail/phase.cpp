// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/detail/phase.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace gyrobudget::inline v0::allan::detail {
namespace {

// Sums run over tiles of this many samples, whatever the number of threads: same tiles, same bytes.
constexpr std::size_t kTile = 1 << 15;

template <typename T>
std::span<T> tile(std::span<T> record, std::size_t index) {
  return record.subspan(index * kTile, std::min(kTile, record.size() - index * kTile));
}

std::size_t tiles(std::size_t samples) { return (samples + kTile - 1) / kTile; }

/// Compensated sum of the samples that exist, less `mean` each, and their number.
struct Tally {
  CompensatedSum sum;
  std::int64_t existing = 0;
};

Tally tally(std::span<const double> rate, double mean) {
  constexpr std::size_t kLanes = 8;  // independent sums: one would wait for its own last addition
  CompensatedSum lane[kLanes];
  std::int64_t missing = 0;
  const auto take = [&](std::size_t k, std::size_t l) {
    lane[l].add(centred(rate[k], mean));
    missing += rate[k] - rate[k] == 0 ? 0 : 1;
  };
  std::size_t k = 0;
  for (; k + kLanes <= rate.size(); k += kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) take(k + l, l);
  }
  for (; k < rate.size(); ++k) take(k, k % kLanes);

  Tally total;
  for (const CompensatedSum& part : lane) total.sum.add(part);
  total.existing = static_cast<std::int64_t>(rate.size()) - missing;
  return total;
}

std::vector<Tally> tally_tiles(std::span<const double> rate, double mean) {
  std::vector<Tally> result(tiles(rate.size()));
  tbb::parallel_for(std::size_t{0}, result.size(),
                    [&](std::size_t i) { result[i] = tally(tile(rate, i), mean); });
  return result;
}

std::vector<Mask::Run> missing_runs(std::span<const double> rate) {
  std::vector<Mask::Run> runs;
  for (std::size_t k = 0; k < rate.size(); ++k) {
    if (std::isfinite(rate[k])) continue;
    const auto at = static_cast<std::int64_t>(k);
    if (runs.empty() || runs.back().first + runs.back().count != at) runs.push_back({at, 0});
    ++runs.back().count;
  }
  return runs;
}

/// Continues prefix sums: writes one after each sample.
void integrate_onwards(CompensatedSum sum, std::span<const double> rate, double mean, double* x) {
  for (std::size_t k = 0; k < rate.size(); ++k) {
    sum.add(centred(rate[k], mean));
    x[k] = sum.value();
  }
}

}  // namespace

Census census(std::span<const double> rate, double minimum_fill) {
  Tally total;
  for (const Tally& part : tally_tiles(rate, 0)) {
    total.sum.add(part.sum);
    total.existing += part.existing;
  }
  Census result;
  result.mean = total.existing > 0 ? total.sum.value() / static_cast<double>(total.existing)
                                   : std::numeric_limits<double>::quiet_NaN();
  if (total.existing > 0 && !std::isfinite(result.mean)) {
    throw std::invalid_argument("samples are too large: their sum exceeds the range of double (1.8e308)");
  }
  const auto samples = static_cast<std::int64_t>(rate.size());
  if (total.existing < samples)
    result.mask = std::make_shared<Mask>(samples, missing_runs(rate), minimum_fill);
  return result;
}

Phase integrate(std::span<const double> rate, const Census& facts) {
  const std::vector<Tally> parts = tally_tiles(rate, facts.mean);
  std::vector<CompensatedSum> start(parts.size());
  CompensatedSum running;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    start[i] = running;
    running.add(parts[i].sum);
  }
  Phase phase;
  phase.x = std::make_unique_for_overwrite<double[]>(rate.size() + 1);
  phase.x[0] = 0;
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    integrate_onwards(start[i], tile(rate, i), facts.mean, phase.x.get() + i * kTile + 1);
  });
  if (facts.mask) {
    phase.missing = std::make_unique_for_overwrite<std::uint32_t[]>(rate.size() + 1);
    count_missing(rate, phase.missing.get());
  }
  return phase;
}

void integrate_stretch(std::span<const double> rate, double* x) {
  const Tally total = tally(rate, 0);
  const double mean = total.existing > 0 ? total.sum.value() / static_cast<double>(total.existing) : 0;
  x[0] = 0;
  integrate_onwards({}, rate, mean, x + 1);
}

void count_missing(std::span<const double> rate, std::uint32_t* missing) {
  missing[0] = 0;
  for (std::size_t k = 0; k < rate.size(); ++k)
    missing[k + 1] = missing[k] + (std::isfinite(rate[k]) ? 0 : 1);
}

}  // namespace gyrobudget::inline v0::allan::detail
