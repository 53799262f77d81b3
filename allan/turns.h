// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace gyrobudget::inline v0::allan {

/// Rows that belong by turns to more than one sensor.
struct Turns {
  std::int64_t sensors = 2;  ///< every how many rows the same one comes again
  double levels = 0;         ///< distance of the two mean levels that differ most [signal]
  double noises = 1;         ///< largest over smallest standard deviation
};

/// Whether the rows of a record come by turns from 2, 3 or 4 sensors: the fewest that explain it, more where
/// these differ by clearly more (1.9 times in variance, 1.25 times in level).
///
/// In windows of 96 rows the rows i mod p have means and variances of their own. The median over the windows of the
/// largest over the smallest variance is 1.1 to 1.9 for one sensor, whatever its noise; by turns they are seen from 3
/// on, where three quarters of the windows have the same one loudest as the window before (a spectral line at a third
/// or a quarter of the rate has not). The median of the largest distance of means, in standard deviations of a sample,
/// is 0.1 to 0.4 for one sensor; they are seen from 1.5 on, likewise. A dropped row blurs its own window alone. Of 3000
/// records of white noise, flicker, walk and noise behind filters (4096 samples) none was taken for several (tests). A
/// sensor whose output toggles at half its rate looks like two, and so may one whose steps are half of its scatter or
/// more, or an angle in such steps: ask no record of those (rounding.h).
/// @param rate  without outliers (outliers.h); NaN is missing, and windows that lack a quarter are passed over
/// @return nothing where the rows are of one, or fewer than 16 windows are complete.
[[nodiscard]] std::optional<Turns> find_turns(std::span<const double> rate);

}  // namespace gyrobudget::inline v0::allan
