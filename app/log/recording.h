// SPDX-License-Identifier: MIT
// What a recorder wrote: one file or folder with many streams, each of stamped rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "format.h"

namespace gyrobudget::inline v0::log {

/// A number that each row of a stream has.
struct Field {
  std::string name;  ///< "angular_velocity.x", "gyro_rad[0]", "GyrX", "wb[2]"
  std::string unit;  ///< "rad/s"; empty where nothing tells it
  /// Who tells the unit, for people: "sensor_msgs/Imu has it so", "UNIT of the log"; empty where nobody does.
  std::string unit_from;
};

enum class StreamKind { imu, gyroscope, accelerometer, magnetometer, gnss, other };

/// "imu", "gyroscope", "accelerometer", "magnetometer", "gnss", "other".
[[nodiscard]] std::string_view name(StreamKind kind);

/// A topic of a bag, an instance of a message, a struct or the arrays of equal length of a file of arrays.
struct StreamInfo {
  std::string name;  ///< "/imu/data_raw", "sensor_combined", "sensor_gyro[1]", "IMU[0]", "imu"; no other has it
  std::string type;  ///< "sensor_msgs/Imu"; empty where the format has none
  StreamKind kind = StreamKind::other;
  std::vector<Field> fields;  ///< empty for a type that is not read
  std::int64_t count = 0;     ///< of rows
  /// What its stamps are: "header.stamp", "TimeUS"; empty where it has none, as arrays do: its rows are in order, and
  /// one of its fields may be a time.
  std::string clock;
};

/// Rows of a stream in the order in which they were recorded.
struct Rows {
  std::vector<std::int64_t> stamps_ns;  ///< one a row, as recorded: neither sorted nor thinned; empty without clock
  std::string clock;                    ///< whose they are: StreamInfo::clock, or what had to stand in for it
  std::vector<std::vector<double>> columns;  ///< of the fields asked for; NaN where a row says that it has none
  std::vector<std::string> notes;            ///< what was taken for what, left out, or damaged, for people
  bool is_decimated = false;                 ///< rows say that they cover less than the time between them
};

/// A recording that was opened. Reading is const and keeps nothing: two threads may read two streams.
class Recording {
 public:
  Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  virtual ~Recording() = default;

  /// "ROS 1 bag", "MCAP", "PX4 ULog", "MATLAB 7.3".
  [[nodiscard]] virtual std::string format() const = 0;
  /// In the order of the file.
  [[nodiscard]] virtual const std::vector<StreamInfo>& streams() const = 0;
  /// What holds for the whole file: where it was cut, what was skipped.
  [[nodiscard]] virtual const std::vector<std::string>& notes() const = 0;
  /// @param stream  its place in streams() @param fields  places in StreamInfo::fields
  /// @throws text::InputError for what is damaged beyond reading; std::out_of_range for a stream or field that is none.
  [[nodiscard]] virtual Rows read(std::size_t stream, std::span<const std::size_t> fields) const = 0;
};

/// The format that the first bytes of a file, at least 512 where it has so many, are of; empty for text, raw numbers,
/// what read_log takes of .npy, packed data (open_recording looks into those), and what no reader knows.
[[nodiscard]] std::string_view recorded_format(std::string_view head);

/// How the samples of an input that is no recording are written: as its content says, which a .npy does under any name,
/// else as its name says.
[[nodiscard]] Format format_of_input(const std::string& path);

/// Opens a recording, recognised by its content and never by its name: a file, or the folder of a rosbag2.
/// @return null where recorded_format knows nothing of it
/// @throws text::InputError where it cannot be read, is of a format that this build leaves out (with the package that
/// brings it), or is one that is read elsewhere (with the tool that converts it).
[[nodiscard]] std::unique_ptr<Recording> open_recording(const std::string& path);

}  // namespace gyrobudget::inline v0::log
