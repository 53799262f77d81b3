// SPDX-License-Identifier: MIT
#include "recording.h"

#include "gyrobudget/app/text/text.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <system_error>

#include "bytes.h"
#include "compression.h"
#include "formats/dataflash.h"
#include "formats/gpsd_json.h"
#include "formats/hdf5.h"
#include "formats/mat.h"
#include "formats/mcap.h"
#include "formats/nmea.h"
#include "formats/npz.h"
#include "formats/ros1_bag.h"
#include "formats/rosbag2.h"
#include "formats/rtklib_pos.h"
#include "formats/sqlite_source.h"
#include "formats/ulog.h"

namespace gyrobudget::inline v0::log {
namespace {

/// How a format is known and opened: by its path, or from bytes, which may have been unpacked.
struct RecordedFormat {
  std::string_view name;
  bool (*is)(std::string_view head);
  std::unique_ptr<Recording> (*open)(const std::string& path);
  std::unique_ptr<Recording> (*open_bytes)(std::shared_ptr<const Bytes> bytes) = nullptr;
};

// --- What is no log of ours -----------------------------------------------------------------------------------------

bool is_blackbox(std::string_view head) { return head.starts_with("H Product:Blackbox"); }

std::unique_ptr<Recording> refuse_blackbox(std::shared_ptr<const Bytes> bytes) {
  text::fail(
      bytes->name(),
      "is a log of Betaflight's or INAV's blackbox, which is not read; decode it first: blackbox_decode LOG, and read the CSV");
}

/// Times of eight bytes, big-endian microseconds since 1970, each before a message of MAVLink 1 or 2.
bool is_tlog(std::string_view head) {
  constexpr std::size_t kTime = 8, kShortest = kTime + 12;
  constexpr unsigned char kVersion1 = 0xfe, kVersion2 = 0xfd;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(head[at]); };
  const auto is_start = [&](std::size_t at) {
    std::uint64_t us = 0;
    for (std::size_t i = 0; i < kTime; ++i) us = us << 8 | byte(at + i);
    constexpr std::uint64_t kYear2000 = 946'684'800'000'000, kYear2100 = 4'102'444'800'000'000;
    const bool is_mark = byte(at + kTime) == kVersion1 || byte(at + kTime) == kVersion2;
    return is_mark && us > kYear2000 && us < kYear2100;
  };
  if (head.size() < kShortest || !is_start(0)) return false;
  constexpr std::size_t kFrame1 = 8, kFrame2 = 12, kSignature = 13;
  const bool is_signed = (byte(kTime + 2) & 1) != 0;
  const std::size_t frame = byte(kTime) == kVersion1 ? kFrame1 : kFrame2 + (is_signed ? kSignature : 0);
  const std::size_t next = kTime + frame + byte(kTime + 1);
  return next + kShortest > head.size() || is_start(next);
}

std::unique_ptr<Recording> refuse_tlog(std::shared_ptr<const Bytes> bytes) {
  text::fail(
      bytes->name(),
      "is a telemetry log of MAVLink (.tlog), too slow and uneven for a sensor's noise; read the log of the autopilot itself (.BIN, .ulg), or export it: mavlogdump.py --format csv --types RAW_IMU LOG");
}

std::unique_ptr<Recording> refuse_zip(std::shared_ptr<const Bytes> bytes) {
  text::fail(bytes->name(), "is a zip archive or a spreadsheet; unpack it, or save the sheet as CSV");
}

/// The first that says yes is taken.
constexpr auto kFormats = std::to_array<RecordedFormat>({
    {"ROS 1 bag", is_ros1_bag, open_ros1_bag},
    {"ROS 1 bag of an older version", is_old_ros1_bag, open_old_ros1_bag},
    {"MCAP", is_mcap, open_mcap},
    {"rosbag2", is_sqlite, open_rosbag2_database},
    {"PX4 ULog", is_ulog, nullptr, open_ulog},
    {"ArduPilot dataflash", is_dataflash, nullptr, open_dataflash},
    {"ArduPilot dataflash, as text", is_dataflash_text, nullptr, open_dataflash_text},
    {"MATLAB 5 to 7", is_mat, nullptr, open_mat},
    {"MATLAB 7.3", is_matlab_73, nullptr, open_hdf5},
    {"HDF5", is_hdf5, nullptr, open_hdf5},
    {"RTKLIB solution", is_rtklib_pos, nullptr, open_rtklib_pos},
    {"NMEA 0183", is_nmea, nullptr, open_nmea},
    {"gpsd's JSON", is_gpsd_json, nullptr, open_gpsd_json},
    {"NumPy npz", is_npz, nullptr, open_npz},
    {"NumPy array", is_other_npy, nullptr, open_other_npy},
    {"Betaflight blackbox", is_blackbox, nullptr, refuse_blackbox},
    {"MAVLink telemetry", is_tlog, nullptr, refuse_tlog},
    {"zip archive", is_other_zip, nullptr, refuse_zip},
});

const RecordedFormat* format_of_head(std::string_view head) {
  for (const RecordedFormat& format : kFormats)
    if (format.is(head)) return &format;
  return nullptr;
}

constexpr std::size_t kHead = 4096;

std::string head_of(const std::string& path) {
  std::string head(kHead, '\0');
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const auto got = descriptor < 0 ? 0 : ::read(descriptor, head.data(), head.size());
  if (descriptor >= 0) ::close(descriptor);
  head.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return head;
}

/// The first bytes of what is packed, which may need a large block of the file.
std::string head_of_packed(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (descriptor < 0 || error) return {};
  Pages pages;
  try {
    pages = Pages::map_file(descriptor, static_cast<std::size_t>(size));
  } catch (const std::system_error&) {  // whoever reads it next says so
  }
  ::close(descriptor);
  return unpacked_head(pages.text(), kHead);
}

}  // namespace

std::string_view name(StreamKind kind) {
  constexpr std::array<std::string_view, 6> kNames{"imu",          "gyroscope", "accelerometer",
                                                   "magnetometer", "gnss",      "other"};
  return kNames.at(static_cast<std::size_t>(kind));
}

std::string_view recorded_format(std::string_view head) {
  const RecordedFormat* format = format_of_head(head);
  return format ? format->name : std::string_view();
}

Format format_of_input(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return format_of(path);
  const std::string head = head_of(path);
  const bool is_packed = compression_of(head) != Compression::none;
  return (is_packed ? head_of_packed(path) : head).starts_with("\x93NUMPY") ? Format::npy : format_of(path);
}

std::unique_ptr<Recording> open_recording(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return open_rosbag2_folder(path);
  if (!std::filesystem::is_regular_file(path, error)) return nullptr;
  const std::string head = head_of(path);
  const Compression compression = compression_of(head);
  const RecordedFormat* format = format_of_head(compression == Compression::none ? head : head_of_packed(path));
  if (!format) return nullptr;
  if (format->open_bytes) return format->open_bytes(std::make_shared<const Bytes>(path, Content::recording));
  if (compression == Compression::none) return format->open(path);
  return open_packed_recording(path);
}

}  // namespace gyrobudget::inline v0::log
