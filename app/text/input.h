// SPDX-License-Identifier: MIT
// Inputs before anyone knows what is in them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "text.h"

namespace gyrobudget::inline v0::text {

/// Bytes that are looked at to tell text from anything else.
inline constexpr std::size_t kTextHead = std::size_t{1} << 16;

/// The path; "standard input" for "-".
[[nodiscard]] std::string input_name(const std::string& path);

/// An input open for reading: a file, a pipe or a device, and standard input for "-".
class InputFile {
 public:
  /// @throws InputError where it cannot be opened, or is a folder.
  explicit InputFile(const std::string& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
  bool owned_ = false;
};

/// A small text, whole, a byte order mark left out.
/// @param path  "-" is standard input
/// @param most  bytes that it may have
/// @param what  "a scene", for messages
/// @throws InputError where it cannot be read, is empty, is larger, or is no text.
[[nodiscard]] std::string read_text(const std::string& path, std::size_t most, std::string_view what);

/// @param text  of which the first kTextHead bytes are looked at
/// @throws InputError for what is no text.
void check_text(std::string_view name, std::string_view text);

/// @param error  the system's errno
/// @throws InputError "name: cannot be read: reason; mend"
[[noreturn]] void fail_unreadable(std::string_view name, int error);

}  // namespace gyrobudget::inline v0::text
