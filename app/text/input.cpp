// SPDX-License-Identifier: MIT
#include "input.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

namespace gyrobudget::inline v0::text {
namespace {

std::string_view mend(int error) {
  switch (error) {
    case ENOENT:
      return "check the name and the folder";
    case EACCES:
    case EPERM:
      return "ask for the right to read it";
    default:
      return "check the path and the disk";
  }
}

struct Signature {
  std::string_view bytes, what, mend;
};

using namespace std::string_view_literals;
constexpr std::string_view kExport = "export it as CSV first";
constexpr std::string_view kUnpack = "unpack it first (gzip is read as it is)";
constexpr Signature kSignatures[] = {
    {"PK\x03\x04"sv, "a zip archive or a spreadsheet", "unpack it, or save the sheet as CSV"},
    {"BZh"sv, "bzip2 data", kUnpack},
    {"\xfd\x37zXZ\0"sv, "xz data", kUnpack},
    {"\x28\xb5\x2f\xfd"sv, "zstd data", kUnpack},
    {"#ROSBAG"sv, "a ROS bag", "export the IMU topic as CSV first"},
    {"\x89MCAP0"sv, "an MCAP recording", "export the IMU topic as CSV first"},
    {"SQLite format 3"sv, "an SQLite data base, perhaps a ROS 2 bag", "export the IMU topic as CSV first"},
    {"MATLAB 5.0 MAT-file"sv, "a MATLAB file", kExport},
    {"\x89HDF\r\n"sv, "an HDF5 or MATLAB 7.3 file", kExport},
    {"\x93NUMPY"sv, "a NumPy file", "let its name end in .npy, or give --format npy"},
    {"\xff\xfe"sv, "text in UTF-16", "save it as UTF-8"},
    {"\xfe\xff"sv, "text in UTF-16", "save it as UTF-8"},
};

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  constexpr unsigned char kEscape = 0x1b;
  return byte < 0x09 || (byte > 0x0d && byte < 0x20 && byte != kEscape);
}

}  // namespace

std::string input_name(const std::string& path) { return path == "-" ? "standard input" : path; }

void fail_unreadable(std::string_view name, int error) {
  fail(name, fmt::format("cannot be read: {}; {}", std::generic_category().message(error), mend(error)));
}

InputFile::InputFile(const std::string& path)
    : descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY)),
      owned_(path != "-") {
  struct stat status = {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) fail_unreadable(input_name(path), errno);
  if (!S_ISDIR(status.st_mode)) return;
  if (owned_) ::close(descriptor_);
  fail(input_name(path), "is a folder, expected a file; name a file in it");
}

InputFile::~InputFile() {
  if (owned_) ::close(descriptor_);
}

std::string read_text(const std::string& path, std::size_t most, std::string_view what) {
  const std::string name = input_name(path);
  const InputFile file(path);
  std::string text;
  std::array<char, std::size_t{1} << 14> block{};
  for (;;) {
    const ssize_t got = ::read(file.descriptor(), block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_unreadable(name, errno);
    if (got == 0) break;
    text.append(block.data(), static_cast<std::size_t>(got));
    if (text.size() > most)
      fail(name, fmt::format("has more than {} bytes, expected {} of at most that; is it a log?", most, what));
  }
  if (text.empty()) fail(name, fmt::format("is empty, expected {}; check how it was written", what));
  check_text(name, text);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

void check_text(std::string_view name, std::string_view text) {
  for (const Signature& s : kSignatures) {
    if (text.starts_with(s.bytes)) fail(name, fmt::format("found {}, expected a text file; {}", s.what, s.mend));
  }
  const std::string_view head = text.substr(0, kTextHead);
  const auto* control = std::ranges::find_if(head, is_control);
  if (control == head.end()) return;
  fail(
      name,
      fmt::format(
          "found the byte 0x{:02x} at offset {}, expected a text file; this is binary data or a damaged copy: export it as CSV first",
          static_cast<unsigned char>(*control), control - head.begin()));
}

}  // namespace gyrobudget::inline v0::text
