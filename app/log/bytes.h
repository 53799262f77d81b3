// SPDX-License-Identifier: MIT
// The bytes of an input, wherever they come from.
#pragma once

#include "gyrobudget/app/text/text.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "compression.h"

namespace gyrobudget::inline v0::log {

/// No line of a text may be longer: a guard against files that are no logs at all.
inline constexpr std::size_t kLongestLine = std::size_t{1} << 20;

/// Pages from the kernel: a mapped file, or memory that grows without being copied.
class Pages {
 public:
  Pages() = default;
  Pages(Pages&& other) noexcept { swap(other); }
  Pages& operator=(Pages&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Pages();
  /// The first `size` bytes of an open file; throws std::system_error.
  static Pages map_file(int descriptor, std::size_t size);
  /// Room for at least `bytes` more behind the text; throws std::bad_alloc.
  char* room(std::size_t bytes);
  void grow(std::size_t bytes) { size_ += bytes; }
  [[nodiscard]] std::string_view text() const { return {data_, size_}; }
  /// Tells the kernel that a part of a mapped file may leave memory; it comes back when it is read again.
  void release(std::string_view part) const noexcept;

 private:
  void swap(Pages& other) noexcept;

  char* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  bool is_file_ = false;
};

enum class Content {
  text,
  bytes,      ///< of a binary log
  recording,  ///< as bytes; where packed data stop in the middle, what is whole is kept
  stored,     ///< the bytes of the file itself, packed or not
};

/// An input as text, or as bytes. A regular file is mapped, not copied. A pipe, a device and "-" (standard input) are
/// read to their end, and gzip, zstd, bzip2 and lz4 are unpacked, into memory: as much as the content is long.
class Bytes {
 public:
  /// @throws InputError where it cannot be read, is a folder or empty, or is packed data that are damaged, truncated,
  /// of a kind that this build cannot unpack, or of more than a thousand times their size; as text also where it is
  /// binary, or begins with a line of more than kLongestLine bytes (found without reading further).
  explicit Bytes(const std::string& path, Content = Content::text);
  /// A piece of an input that is read piece by piece. It refers to the text.
  Bytes(std::string name, std::string_view piece) : name_(std::move(name)), text_(piece) {}

  /// The path; "standard input" for "-".
  [[nodiscard]] const std::string& name() const { return name_; }
  /// All of it, a byte order mark left out.
  [[nodiscard]] std::string_view text() const { return text_; }
  [[nodiscard]] Compression compression() const { return compression_; }  ///< what it was packed in
  [[nodiscard]] bool cut() const { return cut_; }  ///< packed data of a recording stop in the middle
  /// This part will not be read soon.
  void release(std::string_view part) const noexcept { pages_.release(part); }

 private:
  void load(int descriptor, Content);
  void unpack(Content);

  std::string name_;
  Pages pages_;
  std::string_view text_;
  Compression compression_ = Compression::none;
  bool cut_ = false;
};

/// End of the line that starts at `begin`: the position of its '\n', or the size of the text.
/// npos where the line has more than kLongestLine bytes.
[[nodiscard]] inline std::size_t line_end(std::string_view text, std::size_t begin) {
  const std::string_view within = text.substr(begin, kLongestLine + 1);
  const std::size_t found = within.find('\n');
  if (found != std::string_view::npos) return begin + found;
  return within.size() <= kLongestLine ? text.size() : std::string_view::npos;
}

/// @throws InputError for a line longer than kLongestLine.
[[noreturn]] void fail_long_line(std::string_view name, std::int64_t line, std::string_view start);

}  // namespace gyrobudget::inline v0::log
