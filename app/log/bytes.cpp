// SPDX-License-Identifier: MIT
#include "bytes.h"

#include "gyrobudget/app/text/input.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <new>
#include <system_error>

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;  // bytes per read or inflate

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

// --- gzip ------------------------------------------------------------------------------------------------------

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

/// One gzip stream; a file may hold several, one behind the other.
class Inflater {
 public:
  explicit Inflater(std::string_view name) : name_(name) {
    constexpr int kWindow = 15 + 16;  // 32 KiB, gzip header and check sum
    if (inflateInit2(&stream_, kWindow) != Z_OK) throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  Pages unpack(std::string_view bytes) {
    Pages text;
    Guard guard(name_);
    for (;;) {
      const int status = step(bytes, text);
      guard.check(text.text());
      if (status != Z_STREAM_END) continue;
      bytes = next_member(bytes);
      if (bytes.empty()) return text;
      inflateReset(&stream_);
    }
  }

 private:
  int step(std::string_view& bytes, Pages& text) {
    const std::size_t offered = std::min(bytes.size(), kBlock);
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib's interface; only read
    stream_.avail_in = static_cast<uInt>(offered);
    stream_.next_out = reinterpret_cast<Bytef*>(text.room(kBlock));
    stream_.avail_out = static_cast<uInt>(kBlock);
    const int status = inflate(&stream_, Z_NO_FLUSH);
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR) {
      text::fail(name_, fmt::format("the gzip data are damaged after {} bytes of text ({}); fetch the file again",
                                    text.text().size(), stream_.msg ? stream_.msg : "check sum"));
    }
    text.grow(kBlock - stream_.avail_out);
    bytes.remove_prefix(offered - stream_.avail_in);
    if (status == Z_BUF_ERROR && bytes.empty()) fail_truncated(text.text().size());  // it wants more than there is
    return status;
  }

  /// What follows the end of a member: another one, or padding with zeros, which is legal.
  std::string_view next_member(std::string_view rest) const {
    if (rest.empty() || is_gzip(rest)) return rest;
    if (rest.find_first_not_of('\0') == std::string_view::npos) return {};
    text::fail(name_, "the gzip data end, but the file goes on with something else; fetch the file again");
  }

  [[noreturn]] void fail_truncated(std::size_t size) const {
    text::fail(
        name_,
        fmt::format(
            "the gzip data stop in the middle, after {} bytes of text; fetch the file again, or rescue its whole lines with zcat | head -n -1",
            size));
  }

  std::string_view name_;
  z_stream stream_ = {};
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
    if (content == Content::text && is_gzip(pages_.text())) unpack();
  } catch (const std::system_error& error) {
    text::fail_unreadable(name_, error.code().value());
  } catch (const std::bad_alloc&) {
    text::fail(name_, "does not fit into memory; cut the log into pieces, or give it as an unpacked file");
  }
  text_ = pages_.text();
  if (text_.empty()) text::fail(name_, "is empty, expected a log or a sensor file; check how it was written");
  if (content == Content::bytes) return;
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
    if (content == Content::text && !is_gzip(pages_.text())) guard.check(pages_.text());
  }
}

void Bytes::unpack() {
  pages_ = Inflater(name_).unpack(pages_.text());
  unpacked_ = true;
}

void fail_long_line(std::string_view name, std::int64_t line, std::string_view start) {
  text::fail_at(
      name, line, 1,
      fmt::format(
          "found a line of more than {} bytes that starts with {}, expected one sample per line; put each sample on a line of its own (tr -s ' ' '\\n')",
          kLongestLine, text::quoted(start)));
}

}  // namespace gyrobudget::inline v0::log
