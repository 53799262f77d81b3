// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// A time in which a sensor was moved: its signal leaves its level, far above the noise, and comes back.
struct Motion {
  std::int64_t first = 0;  ///< first sample
  std::int64_t count = 0;  ///< samples
  double peak = 0;         ///< largest distance from the level around it [signal]
  double turned = 0;       ///< sum of the distances times the sample interval: the angle, or the velocity [signal s]
};

/// Motions of a record, in order of time.
///
/// Blocks of 64 samples are active where their standard deviation is above ten times that which a tenth of the blocks
/// stays below. White noise would do that with a probability of e^-2000 a block, random walk (the standard deviation of
/// its blocks varies most) with 1e-10. Active blocks with less than four quiet ones between them are one motion, and it
/// is one where the level behind it comes back to that before it within a tenth of its peak: what does not is a step
/// (steps.h). A sensor that moves for more than nine tenths of a record is not told.
/// @param rate   without outliers (outliers.h): a single knock is no motion; NaN is missing
/// @param dt     sample interval [s]
/// @param floor  a standard deviation that is always quiet [signal]: half a step, where the record has steps
/// @throws std::invalid_argument for dt that is not above zero.
[[nodiscard]] std::vector<Motion> find_motion(std::span<const double> rate, double dt, double floor = 0);

}  // namespace gyrobudget::inline v0::allan
