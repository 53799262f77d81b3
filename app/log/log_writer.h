// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "format.h"

namespace gyrobudget::inline v0::log {

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
///
/// In a binary format the columns are written row by row in their units, without time, names and comment.
/// @throws OutputError, and std::invalid_argument where columns differ in length, a name or the comment has a line
/// break, a unit is unknown, or rate_hz is not above 0.
void write_log(const std::string& path, std::span<const LogColumn> columns, double rate_hz,
               std::string_view comment = {}, Format = Format::csv);

/// What a log says before its rows.
struct LogHead {
  struct Column {
    std::string name;  ///< "gyro_x"
    std::string unit;  ///< as in LogColumn
  };
  std::vector<Column> columns;
  double rate_hz = 0;
  std::string comment;             ///< one line; empty: none
  std::uint64_t first_sample = 0;  ///< k of the first row: its time is k / rate_hz
  Format format = Format::csv;
};

/// Fills the next rows, one span for each column, all equally long. Called by one thread at a time, in order.
using LogProducer = std::function<void(std::span<const std::span<double>> columns)>;

/// The same log, its rows made while it is written, in constant memory: `produce` is asked for `samples` rows in all,
/// at most 16384 at a time. The rows of a log that starts at k are the bytes of the longer log from its row k on.
/// @throws what write_log above throws, and what `produce` does.
void write_log(const std::string& path, const LogHead&, std::uint64_t samples, const LogProducer& produce);

}  // namespace gyrobudget::inline v0::log
