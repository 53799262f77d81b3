// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation_table.h"
#include "gyrobudget/app/text/error.h"

#include <optional>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::log {

struct CurveOptions {
  std::string path;                  ///< "-" is standard input
  std::optional<std::string> unit;   ///< of the deviation columns without one in the header
  std::vector<std::string> columns;  ///< names or numbers (from 1); empty: every column with a unit but limits
};

/// Reads a table with one column of averaging times, named tau or with a unit of time in its header (`tau (s)`; a bare
/// `tau` or `tau_s` is in seconds), and one to many of deviations (`adev (deg/h)`). Columns named lower, upper, min or
/// max are no deviations.
/// @throws InputError where there is no such column, a unit is missing, or a tau or deviation is not above zero or the
/// taus do not ascend.
[[nodiscard]] allan::DeviationTable read_curve(const CurveOptions&);

}  // namespace gyrobudget::inline v0::log
