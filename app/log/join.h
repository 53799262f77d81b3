// SPDX-License-Identifier: MIT
// Inside the reading of logs: two tables of one time as one.
#pragma once

#include <string>
#include <vector>

#include "table.h"

namespace gyrobudget::inline v0::log {

/// A log that was read, to be joined.
struct Joinable {
  std::string source;
  Table table;  ///< stamps ascending; rows without one are left out of the join
};

/// Whether the rows of `a` follow one another faster than those of `b`.
[[nodiscard]] bool is_faster(const Table& a, const Table& b);

/// Puts the columns of `other` behind those of `base`: each row at the stamp of `base` that is nearest, once what lies
/// between the two as a rule is taken off, and at most an interval of `base` away. Where there is none the columns have
/// no number.
/// @return notes: how far the stamps are apart, what had no place
/// @throws InputError where the times do not overlap, or a time goes back.
[[nodiscard]] std::vector<std::string> join(Joinable& base, Joinable other);

}  // namespace gyrobudget::inline v0::log
