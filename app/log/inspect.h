// SPDX-License-Identifier: MIT
// What is in a log, of any format: for a person who was handed one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "recording.h"

namespace gyrobudget::inline v0::log {

/// A column of a stream, over its rows as they stand.
struct InspectedColumn {
  std::string name;
  std::string unit;                              ///< as the log has it; empty: not told
  std::string unit_from;                         ///< who tells it; empty: nobody
  std::int64_t numbers = 0;                      ///< that are finite
  std::optional<double> mean, std, least, most;  ///< of these, in the unit of the log; std of two and more
};

struct InspectedStream {
  std::string name;  ///< of the topic, message or struct; of a text the file's
  std::string type;
  StreamKind kind = StreamKind::other;
  std::int64_t samples = 0;
  bool is_read = false;  ///< its numbers can be read; what follows is of these alone
  std::string clock;     ///< whose stamps these are; empty: it has none
  std::optional<std::int64_t> first_ns, last_ns;
  std::optional<double> rate_hz;        ///< one over the median step
  std::optional<double> mean_rate_hz;   ///< steps over the time from first to last
  std::optional<double> largest_gap_s;  ///< the longest step
  std::int64_t gaps = 0;                ///< steps longer than 1.5 medians
  std::int64_t repeats = 0;             ///< rows with the stamp of the one before
  std::int64_t back = 0;                ///< rows whose stamp is before that of the one before
  std::vector<InspectedColumn> columns;
  std::vector<std::string> odd;  ///< what a person should know, one sentence each
};

struct Inspection {
  std::string source;
  std::string format;  ///< "ROS 1 bag", "text"
  std::vector<InspectedStream> streams;
  std::vector<std::string> notes;      ///< on the whole log
  std::vector<std::string> calibrate;  ///< arguments behind `gyrobudget calibrate`, one line for each inertial stream
};

/// Looks through a log: a recording, a text, or a .npy. Streams that hold no IMU, magnetometer, GNSS or arrays are only
/// counted.
/// @throws text::InputError for what cannot be read at all.
[[nodiscard]] Inspection inspect(const std::string& path);

}  // namespace gyrobudget::inline v0::log
