// SPDX-License-Identifier: MIT
// Where a log is cut into stretches without long gaps.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "table.h"

namespace gyrobudget::inline v0::log {

/// Rows of a log that follow one another without a long gap.
struct Stretch {
  std::size_t first = 0, rows = 0;
  double start_s = 0;           ///< since the first row of the log, by its own clock
  std::optional<double> gap_s;  ///< before it; empty for the first, and where the clock went back
};

/// Fewest rows of a stretch that is kept: the rate of fewer is known to a few per cent only.
inline constexpr std::size_t kFewestRows = 32;

struct Stretches {
  std::vector<Stretch> kept;
  std::size_t short_ones = 0, short_rows = 0;  ///< left out: below kFewestRows
  std::size_t longest_rows = 0;                ///< of all, kept or not
};

/// Cuts a table where time goes back, and where more than `longest_gap_s` passes from one row that holds a number (and
/// a stamp) to the next one. Without stamps rows are 1 / `rate_hz` apart. Rows without numbers at the ends of a
/// stretch belong to the gap.
[[nodiscard]] Stretches cut(const Table&, double rate_hz, double longest_gap_s);

/// One sentence on the stretches: how many, how long, where the cuts are, what is left out.
[[nodiscard]] std::string describe(const Stretches&, const std::vector<std::string>& lengths, double longest_gap_s);

}  // namespace gyrobudget::inline v0::log
