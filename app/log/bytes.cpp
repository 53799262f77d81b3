// SPDX-License-Identifier: MIT
#include "bytes.h"

#include "gyrobudget/app/text/input.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <system_error>

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;  // bytes per read or step of a decompressor

/// Watches a text while it grows, so that what is no log is refused before it fills the memory.
class Guard {
 public:
  explicit Guard(std::string_view name) : name_(name) {}

  void check(std::string_view text) {
    if (text.size() >= text::kTextHead && seen_ < text::kTextHead) text::check_text(name_, text);
    const std::string_view fresh = text.substr(seen_);
    lines_ += std::ranges::count(fresh, '\n');
    const std::size_t last = fresh.rfind('\n');
    if (last != std::string_view::npos) line_ = seen_ + last + 1;
    seen_ = text.size();
    if (seen_ - line_ > kLongestLine) fail_long_line(name_, lines_ + 1, text.substr(line_));
  }

 private:
  std::string_view name_;
  std::size_t seen_ = 0, line_ = 0;
  std::int64_t lines_ = 0;
};

// --- Packed inputs ---------------------------------------------------------------------------------------------

/// Unpacks an input into memory.
class Unpacking {
 public:
  Unpacking(std::string_view name, Content content, std::string_view packed)
      : name_(name),
        content_(content),
        compression_(compression_of(packed)),
        most_(most_unpacked(packed.size())),
        decompressor_(make_decompressor(compression_, name)),
        frames_(*decompressor_, packed) {}

  Pages run() {
    using State = FrameReader::State;
    Pages unpacked;
    Guard guard(name_);
    for (State state = State::going_on; state == State::going_on;) {
      const FrameReader::Piece piece = frames_.next(std::span(unpacked.room(kBlock), kBlock));
      unpacked.grow(piece.written);
      const std::size_t size = unpacked.text().size();
      state = piece.state;
      if (state == State::damaged) fail_damaged(size, piece.damage);
      if (state == State::foreign) fail_foreign();
      if (content_ == Content::text) guard.check(unpacked.text());
      if (size > most_) fail_too_large();
      cut_ = state == State::cut;
      if (cut_ && content_ != Content::recording) fail_truncated(size);
    }
    return unpacked;
  }
  /// The data stop in the middle; what was whole was kept.
  [[nodiscard]] bool cut() const { return cut_; }

 private:
  [[noreturn]] void fail_damaged(std::size_t size, std::string_view damage) const {
    text::fail(name_, fmt::format("the {} data are damaged after {} bytes of {} ({}); fetch the file again",
                                  log::name(compression_), size, what(), damage));
  }

  [[noreturn]] void fail_foreign() const {
    text::fail(name_, fmt::format("the {} data end, but the file goes on with something else; fetch the file again",
                                  log::name(compression_)));
  }

  [[nodiscard]] std::string_view what() const { return content_ == Content::text ? "text" : "content"; }

  [[noreturn]] void fail_truncated(std::size_t size) const {
    const std::string rescue =
        content_ == Content::text
            ? fmt::format(", or rescue its whole lines with {} | head -n -1", command(compression_))
            : "";
    text::fail(name_, fmt::format("the {} data stop in the middle, after {} bytes of {}; fetch the file again{}",
                                  log::name(compression_), size, what(), rescue));
  }

  [[noreturn]] void fail_too_large() const {
    text::fail(
        name_,
        fmt::format("unpacks to more than {} bytes, which no log of its size does; if it is one, unpack it first ({})",
                    most_, command(compression_)));
  }

  std::string_view name_;
  Content content_;
  Compression compression_;
  std::uint64_t most_;
  std::unique_ptr<Decompressor> decompressor_;
  FrameReader frames_;
  bool cut_ = false;
};

}  // namespace

// --- Pages -----------------------------------------------------------------------------------------------------

Pages::~Pages() {
  if (capacity_ > 0) ::munmap(data_, capacity_);
}

void Pages::swap(Pages& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  std::swap(capacity_, other.capacity_);
  std::swap(is_file_, other.is_file_);
}

Pages Pages::map_file(int descriptor, std::size_t size) {
  Pages result;
  if (size == 0) return result;
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (data == MAP_FAILED) throw std::system_error(errno, std::generic_category());
  result.data_ = static_cast<char*>(data);
  result.size_ = result.capacity_ = size;
  result.is_file_ = true;
  return result;
}

char* Pages::room(std::size_t bytes) {
  if (capacity_ - size_ >= bytes) return data_ + size_;
  const std::size_t wanted = std::max(2 * capacity_, capacity_ + bytes);
  void* data = capacity_ == 0
                   ? ::mmap(nullptr, wanted, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)
                   : ::mremap(data_, capacity_, wanted, MREMAP_MAYMOVE);
  if (data == MAP_FAILED) throw std::bad_alloc();
  data_ = static_cast<char*>(data);
  capacity_ = wanted;
  return data_ + size_;
}

void Pages::release(std::string_view part) const noexcept {
  if (!is_file_) return;
  static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const auto offset = static_cast<std::size_t>(part.data() - data_);
  const std::size_t first = (offset + page - 1) / page * page;
  const std::size_t last = offset + part.size() == size_ ? size_ : (offset + part.size()) / page * page;
  if (first < last) ::madvise(data_ + first, last - first, MADV_DONTNEED);
}

// --- Bytes ----------------------------------------------------------------------------------------------------

Bytes::Bytes(const std::string& path, Content content) : name_(text::input_name(path)) {
  const text::InputFile file(path);
  try {
    load(file.descriptor(), content);
    if (content != Content::stored && compression_of(pages_.text()) != Compression::none) unpack(content);
  } catch (const std::system_error& error) {
    text::fail_unreadable(name_, error.code().value());
  } catch (const std::bad_alloc&) {
    text::fail(name_, "does not fit into memory; cut the log into pieces, or give it as an unpacked file");
  }
  text_ = pages_.text();
  if (text_.empty()) text::fail(name_, "is empty, expected a log or a sensor file; check how it was written");
  if (content != Content::text) return;
  text::check_text(name_, text_);
  if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
  if (line_end(text_, 0) == std::string_view::npos) fail_long_line(name_, 1, text_);
}

void Bytes::load(int descriptor, Content content) {
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0) throw std::system_error(errno, std::generic_category());
  if (S_ISDIR(status.st_mode)) text::fail(name_, "is a folder, expected a file; name a file in it");
  if (S_ISREG(status.st_mode) && status.st_size > 0 && ::lseek(descriptor, 0, SEEK_CUR) == 0) {
    pages_ = Pages::map_file(descriptor, static_cast<std::size_t>(status.st_size));
    return;
  }
  Guard guard(name_);
  for (;;) {
    const ssize_t got = ::read(descriptor, pages_.room(kBlock), kBlock);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw std::system_error(errno, std::generic_category());
    if (got == 0) return;
    pages_.grow(static_cast<std::size_t>(got));
    if (content == Content::text && compression_of(pages_.text()) == Compression::none) guard.check(pages_.text());
  }
}

void Bytes::unpack(Content content) {
  compression_ = compression_of(pages_.text());
  Unpacking unpacking(name_, content, pages_.text());
  pages_ = unpacking.run();
  cut_ = unpacking.cut();
}

void fail_long_line(std::string_view name, std::int64_t line, std::string_view start) {
  text::fail_at(
      name, line, 1,
      fmt::format(
          "found a line of more than {} bytes that starts with {}, expected one sample per line; put each sample on a line of its own (tr -s ' ' '\\n')",
          kLongestLine, text::quoted(start)));
}

}  // namespace gyrobudget::inline v0::log
