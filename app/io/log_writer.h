// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/io/error.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::io {

/// A column of a log to be written.
struct LogColumn {
  std::string name;            ///< "gyro_x"
  std::string unit;            ///< as it stands in the header, "rad/s"; anything that noise::parse_unit reads
  std::vector<double> values;  ///< SI; NaN is written as nan
};

/// Writes a log that read_log reads back: a comment line where one is given, the header
/// `time (s),gyro_x (rad/s),...`, and one row for each sample, k / rate_hz first. Numbers have the fewest digits that
/// give the same double, so a column in an SI unit comes back bit for bit; in another unit to the last digit or two.
///
/// A path that ends in .gz is compressed; "-" is standard output; see OutputFile for what a failure leaves behind.
/// Formatting and compressing run on all cores; the bytes do not depend on their number.
/// @throws OutputError, and std::invalid_argument where columns differ in length, a name or the comment has a line
/// break, a unit is unknown, or rate_hz is not above 0.
void write_log(const std::string& path, std::span<const LogColumn> columns, double rate_hz,
               std::string_view comment = {});

}  // namespace gyrobudget::inline v0::io
