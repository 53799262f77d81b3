// SPDX-License-Identifier: MIT
#include "phase.h"

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

template <bool has_gaps>
double centred(double sample, double mean) {
  const double value = sample - mean;
  if constexpr (!has_gaps) return value;
  return value - value == 0 ? value : 0;  // Inf - Inf and NaN are not 0
}

std::int64_t count_missing(std::span<const double> rate) {
  return std::count_if(rate.begin(), rate.end(), [](double sample) { return !std::isfinite(sample); });
}

/// Sum of the samples that exist, less `mean` each, and the number of those that do not.
struct Tally {
  CompensatedSum sum;
  std::int64_t missing = 0;
};

template <bool has_gaps>
double plain_sum(std::span<const double> rate, double mean) {
  constexpr std::size_t kLanes = 8;
  double lane[kLanes] = {};
  std::size_t k = 0;
  for (; k + kLanes <= rate.size(); k += kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) lane[l] += centred<has_gaps>(rate[k + l], mean);
  }
  for (; k < rate.size(); ++k) lane[k % kLanes] += centred<has_gaps>(rate[k], mean);
  return ((lane[0] + lane[4]) + (lane[1] + lane[5])) + ((lane[2] + lane[6]) + (lane[3] + lane[7]));
}

/// Plain sums of few samples, compensated sums of those: as good as compensating each, at the speed of plain ones.
Tally tally(std::span<const double> rate, double mean) {
  constexpr std::size_t kBlock = 256;
  Tally total;
  for (std::size_t k = 0; k < rate.size(); k += kBlock) {
    const auto block = rate.subspan(k, std::min(kBlock, rate.size() - k));
    const double sum = plain_sum<false>(block, mean);
    if (std::isfinite(sum)) {
      total.sum.add(sum);
    } else {
      total.sum.add(plain_sum<true>(block, mean));
      total.missing += count_missing(block);
    }
  }
  return total;
}

std::vector<Tally> tally_tiles(std::span<const double> rate, double mean) {
  std::vector<Tally> result(tiles(rate.size()));
  tbb::parallel_for(std::size_t{0}, result.size(), [&](std::size_t i) { result[i] = tally(tile(rate, i), mean); });
  return result;
}

std::vector<Mask::Gap> missing_runs(std::span<const double> rate) {
  std::vector<Mask::Gap> runs;
  for (std::size_t k = 0; k < rate.size(); ++k) {
    if (std::isfinite(rate[k])) continue;
    const auto at = static_cast<std::int64_t>(k);
    if (runs.empty() || runs.back().first + runs.back().count != at) runs.push_back({at, 0});
    ++runs.back().count;
  }
  return runs;
}

/// Continues prefix sums: writes one after each sample. Sums within a block are plain: they are small beside the
/// compensated sum before it.
template <bool has_gaps>
void integrate_onwards(CompensatedSum sum, std::span<const double> rate, double mean, double* x) {
  constexpr std::size_t kBlock = 32;
  for (std::size_t k = 0; k < rate.size();) {
    const double before = sum.value();
    double within = 0;
    for (const std::size_t end = std::min(k + kBlock, rate.size()); k < end; ++k) {
      within += centred<has_gaps>(rate[k], mean);
      x[k] = before + within;
    }
    sum.add(within);
  }
}

void integrate_onwards(CompensatedSum sum, std::span<const double> rate, bool has_gaps, double mean, double* x) {
  if (has_gaps) {
    integrate_onwards<true>(sum, rate, mean, x);
  } else {
    integrate_onwards<false>(sum, rate, mean, x);
  }
}

/// Mean of some samples of a stretch, for a constant to subtract.
double rough_mean(std::span<const double> rate) {
  constexpr std::size_t kStride = 16;
  double sum = 0;
  std::int64_t count = 0;
  for (std::size_t k = 0; k < rate.size(); k += kStride) {
    if (!std::isfinite(rate[k])) continue;
    sum += rate[k];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace

Census census(std::span<const double> rate, double minimum_fill) {
  Tally total;
  for (const Tally& part : tally_tiles(rate, 0)) {
    total.sum.add(part.sum);
    total.missing += part.missing;
  }
  const auto samples = static_cast<std::int64_t>(rate.size()), existing = samples - total.missing;
  Census result;
  result.mean =
      existing > 0 ? total.sum.value() / static_cast<double>(existing) : std::numeric_limits<double>::quiet_NaN();
  if (existing > 0 && !std::isfinite(result.mean)) {
    throw std::invalid_argument("samples are too large: their sum exceeds the range of double (1.8e308)");
  }
  if (total.missing > 0) result.mask = std::make_shared<Mask>(samples, missing_runs(rate), minimum_fill);
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
    integrate_onwards(start[i], tile(rate, i), facts.mask != nullptr, facts.mean, phase.x.get() + i * kTile + 1);
  });
  if (facts.mask) {
    phase.missing = std::make_unique_for_overwrite<std::uint32_t[]>(rate.size() + 1);
    count_missing(rate, phase.missing.get());
  }
  return phase;
}

void integrate_stretch(std::span<const double> rate, bool has_gaps, double* x) {
  x[0] = 0;
  integrate_onwards({}, rate, has_gaps, rough_mean(rate), x + 1);
}

void count_missing(std::span<const double> rate, std::uint32_t* missing) {
  missing[0] = 0;
  for (std::size_t k = 0; k < rate.size(); ++k) missing[k + 1] = missing[k] + (std::isfinite(rate[k]) ? 0 : 1);
}

}  // namespace gyrobudget::inline v0::allan::detail
