// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// Rows of a log that repeat the row before: its sensor is slower than the log.
struct Repeats {
  std::int64_t repeated = 0;  ///< rows that equal the row before in every axis of the sensor
  std::int64_t compared = 0;  ///< rows that have, with the row before, a number in every axis
  double chance = 0;          ///< share of rows that rounding alone would repeat, about
  double rows_each = 1;       ///< rows for each reading of the sensor, mean; its own rate is that of the log over this
  double longest = 1;         ///< most rows for one reading, but for readings that froze

  [[nodiscard]] double share() const { return static_cast<double>(repeated) / static_cast<double>(compared); }
};

/// Repeats of one sensor, if it has more than chance makes.
///
/// Noise without rounding never gives the same number twice; rounded, it does by chance. In an axis of fine steps (less
/// than 2 % of its increments other than 0 are of one step) at most as many increments are 0 by chance as are of one
/// step; in an axis of coarser ones all of its repeats may be. By chance these shares multiply over the axes. Rows
/// repeat where they do so in all axes together more than twice as often, by six standard deviations, in 0.5 % of the
/// rows or more, and in half of the rows in which the axis with the fewest does by itself: chance is seldom together.
/// None was found in 600 records of one axis of white noise, rounded to steps up to its sigma or not, behind low passes
/// or not (20 000 samples; tests), nor in counts of a ring laser gyro (PSINS). One axis of coarse steps leaves nothing
/// to judge by.
/// @param axes  of one sensor, of one length; NaN is missing. Axes that never change are passed over.
/// @return nothing where nothing repeats, no axis changes, or there are fewer than 64 rows.
/// @throws std::invalid_argument for axes of different lengths.
[[nodiscard]] std::optional<Repeats> find_repeats(std::span<const std::span<const double>> axes);

/// The readings of a sensor that is slower than its log, one after the other.
struct Readings {
  std::vector<std::int64_t> rows;   ///< the row in which each stands first; -1 where one is missing
  std::vector<std::int64_t> holds;  ///< the rows in which it stands; 0 where one is missing
  double rows_each = 1;             ///< mean of those, without missing and frozen ones

  /// The readings of one axis; NaN where one is missing.
  [[nodiscard]] std::vector<double> of(std::span<const double> axis) const;
};

/// Rows that repeat are left out, and what is left is numbered at the sensor's own rate. Where rows are missing, or one
/// reading stands for more than three times the mean (the sensor froze), as many readings are missing as fit in there.
/// Noise that is white from reading to reading is so in this series, whatever the pattern of the repeats.
/// @param axes  as find_repeats has them
/// @throws std::invalid_argument for axes of different lengths.
[[nodiscard]] Readings readings_of(std::span<const std::span<const double>> axes);

/// What uneven holds add to the white noise of the log.
///
/// Whoever sums the rows of the log counts a reading h times where it stands in h rows. With h of mean H and variance V
/// the spectral density at low frequencies becomes that of the readings at their own rate plus V P dt/H^2, where P is
/// the power of the readings at the frequencies of the pattern of h (their variance, if they are white) and dt their
/// interval. P is measured over blocks of 8 readings: mean of (sum of h' y)^2 over that of h'^2, with h' = h less its
/// mean in the block, y the readings less theirs.
/// @param readings  of one axis, NaN where missing
/// @param holds     as Readings has them
/// @return V P/H^2 [signal^2]; 0 for even holds and for fewer than 8 readings
/// @throws std::invalid_argument for lengths that differ.
[[nodiscard]] double added_by_uneven_holds(std::span<const double> readings, std::span<const std::int64_t> holds);

}  // namespace gyrobudget::inline v0::allan
