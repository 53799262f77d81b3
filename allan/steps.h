// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "series.h"

namespace gyrobudget::inline v0::allan {

/// A jump of a record's mean: a range switch, a bump of the table, a bias that changed for good.
struct Step {
  std::int64_t index = 0;  ///< first sample after it
  double size = 0;         ///< mean after less mean before, over `span` samples each [signal]
  double sigmas = 0;       ///< |size| in standard deviations of such differences
  std::int64_t span = 0;   ///< samples of each mean
};

struct StepOptions {
  double false_alarm = 1e-4;  ///< probability that a record of Gaussian noise shows any step at all
  std::size_t most = 10;      ///< clearest ones to return
};

/// Steps of a record, in order of time.
///
/// At averaging factors m = n/32, n/64, ... down to 32 the differences of adjacent cluster means, every m/4 samples,
/// are compared with their own robust scale, 1.4826 times the median of their sizes. Under any Gaussian noise, random
/// walk included, they are Gaussian; a step is one that leaves what chance allows for all differences at all m, with a
/// margin for the scatter of the scale (4 standard errors). The clearest comes first, is placed where the two means
/// differ most, and differences across it are set aside for the next. A step below about 10 Allan deviations at its
/// best m is not told from noise. Knocks move means too: make them missing first (outliers.h).
///
/// @throws std::invalid_argument for a false alarm outside (0, 1).
/// Records shorter than 2048 samples have none found. Cost: prefix sums once, then O(n / 8).
[[nodiscard]] std::vector<Step> find_steps(const Series& record, const StepOptions& options = {});

}  // namespace gyrobudget::inline v0::allan
