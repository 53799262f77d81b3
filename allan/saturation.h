// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// Samples that are held at an end of a sensor's range.
struct Saturation {
  double value = 0;          ///< that end [signal]
  std::int64_t count = 0;    ///< samples at it
  std::int64_t first = 0;    ///< index of the first of them
  std::int64_t longest = 0;  ///< most of them in a row
};

/// Where a record stops at its largest or smallest value, the lower end first.
///
/// Noise has its fewest samples at its ends, so the extreme value is no more frequent than the four different values
/// next to it. It is an end of the range where it occurs 10 times more than four times as often as any of these: of
/// Gaussian noise with Poisson counts below 1e-6 a record, whether rounded or not; a sinusoid has 2.4 times as many
/// samples in its outermost step as in the next. Records of fewer than ten different values have none found.
/// @param rate  NaN is missing
[[nodiscard]] std::vector<Saturation> find_saturation(std::span<const double> rate);

}  // namespace gyrobudget::inline v0::allan
