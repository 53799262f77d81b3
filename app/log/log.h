// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/record.h"
#include "gyrobudget/app/text/error.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "format.h"

namespace gyrobudget::inline v0::log {

/// What a column holds for each sample: a rate (or acceleration); its increment over the sample interval, an angle (or
/// velocity); or the angle (velocity) itself. n angles give n - 1 rates. An angle that is kept within one turn is
/// unwrapped.
enum class Input { rate, increment, angle };

/// Which rows of a log are read: those that have this number, or this word, in this column.
struct RowsOf {
  std::string column;  ///< name or number (from 1)
  double value = 0;
  std::optional<std::string> word = {};  ///< in place of the number; of text only
};

/// Which column is the time, for a log that does not tell.
struct TimeOf {
  std::string column;     ///< name or number (from 1); parts of it with +, "week+sow"; "none": the log has no time
  std::string unit = {};  ///< s, ms, us, ns, iso, gps (week and seconds), counter (of samples); empty: as the log tells
};
/// What TimeOf::unit may be.
inline constexpr std::array<std::string_view, 7> kTimeUnitNames{"s", "ms", "us", "ns", "iso", "gps", "counter"};

/// A further log of the same time: a phone's accelerometer beside its gyro.
struct With {
  std::string path;
  std::optional<std::string> unit = {};  ///< of its columns without one in the header
};

struct LogOptions {
  std::string path = {};                 ///< "-" is standard input
  std::optional<double> rate_hz = {};    ///< needed where there is no time column; checked where there is one
  std::optional<std::string> unit = {};  ///< of data columns without one in the header; "1" is dimensionless
  Input input = Input::rate;
  double scale = 1;                        ///< units per count, for all data columns
  std::vector<std::string> columns = {};   ///< names or numbers (from 1); empty: every data column
  std::optional<RowsOf> rows = {};         ///< unset: all
  std::optional<TimeOf> time = {};         ///< unset: found by name, unit and numbers
  std::vector<With> with = {};             ///< text logs that are joined to this one by time
  std::optional<std::string> topic = {};   ///< stream of a recording (inspect names them); unset: its only IMU
  std::optional<Format> format = {};       ///< unset: what the content says, or else the ending of the path
  std::int64_t file_columns = 1;           ///< numbers a row of a raw binary log has
  std::optional<double> resample_hz = {};  ///< average uneven readings over even intervals; else never
  /// Text that one task parses, in bytes; the result does not depend on it.
  std::size_t chunk_bytes = std::size_t{1} << 20;
};

// How the time column becomes a grid; each is said in a note or in the error.
inline constexpr double kRateTolerance = 0.01;  ///< LogOptions::rate_hz may differ this much from the time column
inline constexpr double kMostRepeated = 0.05;   ///< share of repeated stamps from which the column is refused
inline constexpr double kMostMissing = 0.5;     ///< share of missing samples from which the record is refused
inline constexpr double kLargestJitter = 0.25;  ///< rms of the stamps about the grid, in sample intervals

/// Reads a log as people have them.
///
/// **Text**: cells parted by commas, semicolons, tabs or blanks; comment lines (#, %, //) and blank lines anywhere; a
/// header with units in brackets, also as a comment, or none; LF or CR LF; byte order mark; decimal commas where they
/// are not delimiters too. Empty cells, NaN, Inf, NA and the like are missing samples. Numbers are correctly
/// rounded; a chosen cell that holds text, a row with more or fewer cells than the others, and a number beyond double
/// are errors, and the first one in the file is reported.
///
/// **Packed**: any log may be packed by gzip, zstd, bzip2 or lz4, as far as the build has their libraries.
///
/// **Columns**: a unit comes from the header, `gyro_x (deg/s)`, or from LogOptions::unit. Its dimension tells gyros
/// from accelerometers. Without LogOptions::columns every column is read that has a unit of the kind that
/// LogOptions::input asks for; what is left out is said in the notes.
///
/// **Temperature**: a column whose unit is one of temperature, or whose name is and that has no unit and plausible
/// values in degC, is Record::temperature [degC], and never data; the first is taken.
///
/// **Joining**: the rows of LogOptions::with are put beside those at the nearest time of the fastest of the logs,
/// within an interval; where a slower one has none its samples are missing. The notes say how far the stamps are
/// apart. Logs whose times do not overlap are an error.
///
/// **Rows**: LogOptions::rows reads those of one sensor where several wrote by turns.
///
/// **Preamble**: lines above the header that are neither names nor rows are skipped, and the notes say which line was
/// taken as the header.
///
/// **Time**: the column that LogOptions::time names; else the one that is named time, timestamp, t ... or has a unit
/// of time, absolute or relative, in integer nanoseconds (never through double), or dates and times of day, in one
/// column or two (zones are heeded, leap seconds are not counted), or hour, minute and second; week and seconds of it.
/// A column without such a name that rises as time does is the time where it agrees with LogOptions::rate_hz; one that
/// counts the samples shows which of them are lost. What looks like a clock is never data. Clocks that start again
/// (midnight, counters of 16, 24, 32 bits) run on. Stamps of which runs are equal are counted through where the rate
/// is given. A time column without unit is taken only where one of s, ms, us, ns agrees with LogOptions::rate_hz. The
/// rate is the slope of the stamps over the sample number. Gaps become missing samples; a stamp that repeats masks its
/// grid point; jitter is tolerated up to kLargestJitter and said. Time that goes back is an error, and so are rows
/// that several sensors wrote by turns: the column that tells them apart is named.
///
/// **Resampling**, only where LogOptions::resample_hz asks for it: for readings at truly uneven times. Rates become
/// means over even intervals, angles and increments are interpolated at their ends; intervals without readings are
/// missing. The notes say what that does to white noise at short averaging times (see resample.h).
///
/// **Recordings** (recording.h: bags, flight logs, files of arrays) are known by their content. Units are those of the
/// format, the clock is the sample's own before the recorder's, and rows are put in its order. Of several IMUs none is
/// picked: LogOptions::topic chooses. Arrays have names only: rate_hz and unit as below, a time by its name.
///
/// **Binary** (Format::f32, f64, npy): numbers without time or names; rate_hz and unit must be given, and the columns
/// are named "column 1" and so on. What is not finite is missing.
///
/// **Memory**: a plain file is mapped and parsed in chunks on all cores; the peak is about the numbers read, as
/// doubles. Packed inputs, pipes and standard input take the length of the content beside that.
///
///     const allan::Record record = log::read_log({.path = "log.csv", .rate_hz = 100, .unit = "deg/s"});
///
/// @throws InputError for the log, with place, finding, expectation and mend; std::invalid_argument for options that
/// are wrong with any log (rate_hz or scale not a positive number, an unknown unit).
[[nodiscard]] allan::Record read_log(const LogOptions&);

/// A log of several stretches (power-ups, dropped data), cut where no column has a number for longer than
/// `longest_gap_s` [s] and where time goes back. Each is a record on a grid of its own; they share the rate of the
/// longest one. Pieces of fewer than 32 rows are left out. The notes say how many there are and how long, what was
/// left out, and, after "segment K:", what is to be known of one.
/// @return at least one, in the order of the log.
/// @throws as read_log; InputError too for rates that differ by more than kRateTolerance between segments, and where
/// no piece is long enough; std::invalid_argument for a gap that is not positive.
[[nodiscard]] std::vector<allan::Record> read_segments(const LogOptions&, double longest_gap_s);

}  // namespace gyrobudget::inline v0::log
