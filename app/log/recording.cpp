// SPDX-License-Identifier: MIT
#include "recording.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "formats/mcap.h"
#include "formats/ros1_bag.h"
#include "formats/rosbag2.h"
#include "formats/sqlite_source.h"
#include "formats/unpacker.h"

namespace gyrobudget::inline v0::log {
namespace {

/// How a format is known and opened.
struct RecordedFormat {
  std::string_view name;
  bool (*is)(std::string_view head);
  std::unique_ptr<Recording> (*open)(const std::string& path);
};

/// The first that says yes is taken.
constexpr auto kFormats = std::to_array<RecordedFormat>({
    {"ROS 1 bag", is_ros1_bag, open_ros1_bag},
    {"ROS 1 bag of an older version", is_old_ros1_bag, open_old_ros1_bag},
    {"MCAP", is_mcap, open_mcap},
    {"rosbag2", is_sqlite, open_rosbag2_database},
    {"zstd", is_zstd, open_packed_recording},
});

std::string head_of(const std::string& path) {
  constexpr std::size_t kHead = 4096;
  std::string head(kHead, '\0');
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const auto got = descriptor < 0 ? 0 : ::read(descriptor, head.data(), head.size());
  if (descriptor >= 0) ::close(descriptor);
  head.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return head;
}

}  // namespace

std::string_view name(StreamKind kind) {
  constexpr std::array<std::string_view, 6> kNames{"imu",          "gyroscope", "accelerometer",
                                                   "magnetometer", "gnss",      "other"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view recorded_format(std::string_view head) {
  for (const RecordedFormat& format : kFormats)
    if (format.is(head)) return format.name;
  return {};
}

std::unique_ptr<Recording> open_recording(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return open_rosbag2_folder(path);
  if (!std::filesystem::is_regular_file(path, error)) return nullptr;
  const std::string head = head_of(path);
  for (const RecordedFormat& format : kFormats)
    if (format.is(head)) return format.open(path);
  return nullptr;
}

}  // namespace gyrobudget::inline v0::log
