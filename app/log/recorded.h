// SPDX-License-Identifier: MIT
// From a stream of a recording to the columns that a record is made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "columns.h"
#include "log.h"
#include "recording.h"

namespace gyrobudget::inline v0::log {

struct Recorded {
  std::string source;  ///< "walk.bag, /imu/data_raw"
  Choice choice;
  std::vector<std::int64_t> stamps;          ///< [ns], ascending, each once; empty without a time
  std::vector<std::vector<double>> numbers;  ///< one for each of Choice::data, times its to_si; NaN where missing
  std::vector<std::string> notes;
};

/// The streams that a log may be read from: those that hold an IMU, a gyroscope or an accelerometer, or where there is
/// none those of arrays.
[[nodiscard]] std::vector<std::size_t> sensor_streams(const Recording& recording);

/// What a stream is looked for, and how a person asks for another one.
struct StreamUse {
  bool (*is_meant)(const StreamInfo& stream);
  std::string_view what;   ///< "IMU, gyroscope or accelerometer"
  std::string_view topic;  ///< what stands before the name: "--topic", "topic:"
};
/// Of logs: IMUs, gyroscopes and accelerometers, by the option of the program.
[[nodiscard]] const StreamUse& use_as_log();

/// The stream that is read.
/// @param source  name of the recording, for messages
/// @param topic   its name; unset: the only one that is meant, or where none is the only one of arrays
/// @return its place among Recording::streams()
/// @throws std::invalid_argument where several may be meant, or none has that name; text::InputError where none may.
[[nodiscard]] std::size_t choose_stream(const Recording& recording, const std::string& source,
                                        const std::optional<std::string>& topic, const StreamUse& use = use_as_log());

/// Puts rows in the order of their stamps, and keeps the first of those with one stamp. Both are said in their notes.
void put_in_order(Rows& rows);

/// Nanoseconds of an array of times; from its first number on a double has digits enough. kNoStamp for what is none.
[[nodiscard]] std::vector<std::int64_t> stamps_of(const std::vector<double>& times, std::int64_t ns_per_unit);

/// Reads the stream that LogOptions::topic means, and of it what choose_columns chooses. Rows are put in the order of
/// their stamps; of rows of one stamp the first is kept. Both are said.
/// @throws as choose_stream, choose_columns and Recording::read do.
[[nodiscard]] Recorded read_recorded(const Recording& recording, const LogOptions& options);

}  // namespace gyrobudget::inline v0::log
