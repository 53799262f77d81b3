// SPDX-License-Identifier: MIT
// Which columns of a log are time and which are data, and in what units.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calendar.h"
#include "layout.h"
#include "log.h"

namespace gyrobudget::inline v0::log {

/// A column that is (a part of) the time stamp; a stamp is the sum of its parts (secs and nsecs).
struct StampColumn {
  std::size_t index = 0;
  std::int64_t ns_per_unit = 1;
  StampForm form = StampForm::number;
};

/// Where a clock starts again from nothing.
struct Wrap {
  std::int64_t period_ns = 0;
  bool known = false;  ///< it surely does, a time of day at midnight; else only where the step across fits the others
};

struct DataColumn {
  std::size_t index = 0;
  std::string name;
  noise::Signal signal = noise::Signal::angular_rate;
  double to_si = 1;                      ///< number in the file * to_si is SI, the scale included
  double zero = 0;                       ///< added to that: of a temperature, whose SI here is degC
  std::optional<std::string> word = {};  ///< its cells are words: 1 where one is this, else 0
};

struct Choice {
  std::vector<StampColumn> stamps;  ///< empty: no time column, the rate is given
  std::string time_name;            ///< of the (first) time column
  std::vector<Wrap> wraps;          ///< of that clock, ascending
  std::int64_t count_ns = 0;        ///< above 0: the stamps count the samples, by this from each to the next
  bool time_asked = false;          ///< by LogOptions::time
  std::vector<DataColumn> data;
  std::optional<DataColumn> temperature;  ///< read beside the data [degC]
  std::optional<DataColumn> rows_of;      ///< whose number chooses the rows
  std::vector<std::string> notes;         ///< what was taken for what, and what was left out
};

/// Chooses by names, units, the options and the numbers of the first rows. Nothing is guessed: a column whose unit or
/// a log whose rate cannot be told is an error.
/// @param clock  the column of the time, in nanoseconds, where it is known
/// @throws InputError, and std::invalid_argument for options that are wrong with any log (an unknown --unit).
[[nodiscard]] Choice choose_columns(const std::string& source, const Layout& layout, const LogOptions& options,
                                    std::optional<std::size_t> clock = {});

/// Puts what is read beside the data behind it: the temperature, and then what chooses the rows.
void put_beside(Choice& choice);

}  // namespace gyrobudget::inline v0::log
