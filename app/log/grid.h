// SPDX-License-Identifier: MIT
// From time stamps to a uniform grid.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "log.h"

namespace gyrobudget::inline v0::log {

/// Where the rows of a log stand on a uniform grid.
struct Grid {
  double rate_hz = 0;
  std::int64_t points = 0;
  /// Grid point of each row; kNoStamp where the row has no stamp; ~k (negative) where it repeats the stamp of the row
  /// before it, which masks point k. Empty: row i is point i.
  std::vector<std::int64_t> places;
  std::vector<std::string> notes;
};

/// What messages say about the time column.
struct TimeColumn {
  std::string source;                                    ///< name of the file
  std::string name;                                      ///< of the column
  std::function<std::int64_t(std::size_t)> line_of_row;  ///< counted from 1
};

/// Finds rate and grid from stamps [ns].
///
/// The sample interval is first the mean of the steps within half an interval of their median: blind to gaps and true
/// for stamps that were rounded coarsely. A tracker follows the stamps, so that a clock that drifts gains or loses no
/// samples; a step longer than 1.5 intervals is a gap where the next stamps are late too, and jitter where they are
/// not. The rate is the least-squares slope of the stamps over the grid points; a given rate within 1e-6 of it is
/// taken instead.
/// @throws InputError for time that goes back, hardly rises, is too uneven or full of gaps, or contradicts the rate.
[[nodiscard]] Grid make_grid(const std::vector<std::int64_t>& stamps, std::optional<double> rate_hz, const TimeColumn&);

/// A count of samples in place of a clock.
struct CountedGrid {
  Grid grid;
  std::string fault;       ///< why there is none: it goes back, or counts something else; empty: there is
  std::size_t at_row = 0;  ///< the row of that
};
/// Finds the grid from stamps that count samples, `interval_ns` from each to the next; counts that are left out are
/// missing samples.
/// @param rate_hz  the count has none of its own
[[nodiscard]] CountedGrid make_counted_grid(const std::vector<std::int64_t>& stamps, std::int64_t interval_ns,
                                            double rate_hz, const TimeColumn& column);

/// The values of the rows on the grid; NaN where there is none.
void put_on_grid(const Grid&, std::vector<double>& values);

}  // namespace gyrobudget::inline v0::log
