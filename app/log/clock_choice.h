// SPDX-License-Identifier: MIT
// Inside the choice of columns: which of them are the time.
#pragma once

#include <string>
#include <vector>

#include "column_set.h"
#include "columns.h"

namespace gyrobudget::inline v0::log {

/// Chooses the time of a log: the column that LogOptions::time names; the one with the name and unit of a time; one
/// that holds dates or times of day; one that rises as time does and agrees with LogOptions::rate_hz; one that counts
/// the samples. Fills Choice::stamps and what belongs to them, and says in Choice::notes what was not plain.
/// @param requested  columns that were asked for as data: none of them is the time, except by LogOptions::time
/// @throws InputError for a time whose unit nothing tells, and for rows that two sensors wrote by turns.
void choose_clock(const ColumnSet& columns, const LogOptions& options, const std::vector<std::size_t>& requested,
                  Choice& choice);

/// Whether its first rows rise like a time or a counter, and not like what a sensor reads. False for a column whose
/// name or unit is that of a sensor.
[[nodiscard]] bool looks_like_a_clock(const ColumnSet& columns, const Column& column);

}  // namespace gyrobudget::inline v0::log
