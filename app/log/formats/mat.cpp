// SPDX-License-Identifier: MIT
#include "mat.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "arrays.h"
#include "rows.h"

namespace gyrobudget::inline v0::log::mat {
namespace {

constexpr std::string_view kTitle = "MATLAB 5.0 MAT-file";
constexpr std::size_t kHeader = 128, kSubsystemAt = 116, kVersionAt = 124, kOrderAt = 126, kTag = 8;
constexpr int kZlibWindow = 15;

/// Types of elements.
enum ElementType : std::uint32_t { kInt8 = 1, kInt32 = 5, kUint32 = 6, kMatrix = 14, kCompressed = 15 };
std::optional<NumberType> number_type(std::uint32_t element) {
  switch (element) {
    case kInt8:
      return NumberType::i8;
    case 2:
      return NumberType::u8;
    case 3:
      return NumberType::i16;
    case 4:
      return NumberType::u16;
    case kInt32:
      return NumberType::i32;
    case kUint32:
      return NumberType::u32;
    case 7:
      return NumberType::f32;
    case 9:
      return NumberType::f64;
    case 12:
      return NumberType::i64;
    case 13:
      return NumberType::u64;
    default:
      return std::nullopt;
  }
}

/// Classes of matrices; those from double to uint64 are numbers.
enum MatrixClass : std::uint32_t {
  kCell = 1,
  kStruct = 2,
  kObject = 3,
  kChar = 4,
  kSparse = 5,
  kFirstNumber = 6,
  kLastNumber = 15,
  kFunction = 16,
  kOpaque = 17
};
constexpr std::uint32_t kComplex = 0x800;  // a flag beside the class

/// A part of a file is not as it should be.
struct Damage {};

struct Tag {
  std::uint32_t type = 0;
  std::uint32_t size = 0;   ///< bytes of data
  std::size_t padding = 0;  ///< behind them
};

/// Reads elements one behind the other.
class Elements {
 public:
  Elements(ByteStream stream, bool big_endian) : stream_(std::move(stream)), big_endian_(big_endian) {}

  [[nodiscard]] std::uint32_t u32(std::string_view bytes, std::size_t at) const {
    const auto value = load<std::uint32_t>(bytes, at);
    return big_endian_ ? __builtin_bswap32(value) : value;
  }
  [[nodiscard]] std::string_view take(std::size_t size) {
    const std::string_view bytes = stream_.take(size);
    if (bytes.size() < size) throw Damage{};
    return bytes;
  }
  void skip(std::uint64_t size) {
    if (!stream_.skip(size)) throw Damage{};
  }
  /// In the small form the data stand in the tag itself.
  Tag tag() {
    constexpr std::size_t kHalf = kTag / 2, kLargestSmall = 4;
    const std::uint32_t first = u32(take(kHalf), 0);
    const std::uint32_t small = first >> 16;
    if (small > kLargestSmall) throw Damage{};
    if (small != 0) return {first & 0xffffU, small, kLargestSmall - small};
    const std::uint32_t size = u32(take(kHalf), 0);
    return {first, size, (kTag - size % kTag) % kTag};
  }
  /// The data of a short element.
  std::string text(std::size_t most) {
    const Tag t = tag();
    if (t.size > most) throw Damage{};
    std::string data;
    while (data.size() < t.size) data += take(std::min(ByteStream::kMost, t.size - data.size()));
    skip(t.padding);
    return data;
  }
  [[nodiscard]] std::uint64_t at() const { return stream_.taken(); }
  [[nodiscard]] bool finish() { return stream_.finish(); }
  [[nodiscard]] bool big_endian() const { return big_endian_; }

 private:
  ByteStream stream_;
  bool big_endian_;
};

/// Where a variable stands: as it is, or compressed.
struct Place {
  std::string_view bytes;
  bool compressed = false;
  /// All of it was inflated and agreed with its check sum. Set once, while it is listed.
  std::shared_ptr<bool> is_sound = std::make_shared<bool>(false);

  [[nodiscard]] ByteStream stream(const Bytes& file) const {
    return compressed ? ByteStream(file, bytes, kZlibWindow) : ByteStream(file, bytes);
  }
  /// No more can come out of it.
  [[nodiscard]] std::uint64_t most() const {
    constexpr std::uint64_t kMostGrowth = 1100;
    return compressed ? kMostGrowth * bytes.size() : bytes.size();
  }
};

struct Head {
  std::uint32_t type = 0, flags = 0;  ///< type: a MatrixClass
  std::vector<std::int64_t> dimensions;
  std::string name;
};

class Reader {
 public:
  explicit Reader(const std::shared_ptr<const Bytes>& bytes) : bytes_(bytes), text_(bytes->text()) {}

  std::unique_ptr<Recording> run() {
    big_endian_ = text_[kOrderAt] == 'M';
    const Elements header(ByteStream(*bytes_, text_), big_endian_);
    subsystem_ = header.u32(text_, kSubsystemAt);  // blanks where there is none, which is no place of a small file
    for (std::size_t at = kHeader; at < text_.size();) at = variable(at);
    return finish();
  }

 private:
  /// @returns where the next one begins
  std::size_t variable(std::size_t at) {
    const std::size_t left = text_.size() - at;
    const Elements e(ByteStream(*bytes_, text_), big_endian_);
    const std::uint32_t type = left < kTag ? 0 : e.u32(text_, at), size = left < kTag ? 0 : e.u32(text_, at + 4);
    if (left < kTag || size > left - kTag) {
      notes_.push_back(fmt::format("the file ends inside a variable that begins at byte {}: it is left out", at));
      return text_.size();
    }
    const Place place{text_.substr(at + kTag, size), type == kCompressed};
    if (type == kMatrix && at != subsystem_) read(place, 0, at);
    if (type == kCompressed) {
      try {
        Elements inner(place.stream(*bytes_), big_endian_);
        if (inner.tag().type == kMatrix && at != subsystem_) read(place, kTag, at);
      } catch (const Damage&) {
        damaged(at);
      }
    }
    bytes_->release(place.bytes);
    return at + kTag + size + (type == kCompressed ? 0 : (kTag - size % kTag) % kTag);
  }

  void read(const Place& place, std::uint64_t skipped, std::size_t at) {
    try {
      Elements elements(place.stream(*bytes_), big_endian_);
      elements.skip(skipped);
      const bool all = matrix(elements, place, "", "", 0);
      if (place.compressed && all) *place.is_sound = elements.finish();
      if (place.compressed && all && !*place.is_sound) throw Damage{};
    } catch (const Damage&) {
      damaged(at);
    }
  }

  void leave_out(std::string_view reason, std::string_view name) {
    left_out_.add(fmt::format("left out, {}", reason), name);
  }

  void damaged(std::size_t at) {
    notes_.push_back(fmt::format("the variable at byte {} is damaged: what was not read of it is left out", at));
  }

  /// The start of a matrix: what it is, and for all but opaque ones its dimensions and name.
  static Head head(Elements& elements) {
    constexpr std::size_t kFlagBytes = 8, kMostName = 1024, kMostDimensions = 32;
    Head head;
    const std::string flags = elements.text(kFlagBytes);
    if (flags.size() != kFlagBytes) throw Damage{};
    head.flags = elements.u32(flags, 0);
    head.type = head.flags & 0xffU;
    if (head.type != kOpaque) {
      const std::string lengths = elements.text(kMostDimensions * sizeof(std::uint32_t));
      for (std::size_t i = 0; i + sizeof(std::uint32_t) <= lengths.size(); i += sizeof(std::uint32_t))
        head.dimensions.push_back(elements.u32(lengths, i));
    }
    head.name = clean_name(elements.text(kMostName));
    return head;
  }

  /// @param field  its name where it is one of a struct's, whose matrices have none
  /// @returns whether it was gone through to its end, as structs are
  bool matrix(Elements& elements, const Place& place, const std::string& group, const std::string& field, int depth) {
    constexpr std::size_t kMostName = 1024;
    const Head h = head(elements);
    const std::string name = field.empty() ? h.name : field;
    const std::string full = group.empty() ? name : group + "." + name;
    if (h.type == kOpaque) {
      static_cast<void>(elements.text(kMostName));  // "MCOS"
      objects_.add(full, clean_name(elements.text(kMostName)));
    } else if (h.type >= kFirstNumber && h.type <= kLastNumber) {
      numbers(elements, place, h, group, name);
    } else if (h.type == kStruct) {
      structure(elements, place, h, full, depth);
    } else {
      leave_out(h.type == kCell       ? "cells"
                : h.type == kChar     ? "text"
                : h.type == kSparse   ? "sparse matrices"
                : h.type == kObject   ? "objects"
                : h.type == kFunction ? "functions"
                                      : "of a class that is not known",
                full);
    }
    return h.type == kStruct;
  }

  void numbers(Elements& elements, const Place& place, const Head& h, const std::string& group,
               const std::string& name) {
    const std::string full = group.empty() ? name : group + "." + name;
    const auto shape = array_shape(h.dimensions);
    if ((h.flags & kComplex) != 0) return leave_out("complex", full);
    if (!shape) return leave_out(h.dimensions.size() > 2 ? "of more than two dimensions" : "empty or wide", full);
    if (arrays_.size() == kMostArrays) return leave_out("more arrays than a log has", full);
    const Tag tag = elements.tag();
    const auto type = number_type(tag.type);  // often smaller than the class
    if (!type) throw Damage{};
    const MatrixLayout layout{*type, elements.big_endian(), *shape, !shape->transposed};
    const std::uint64_t at = elements.at();
    if (layout.bytes() > tag.size || layout.bytes() + at > place.most() + kTag) throw Damage{};
    arrays_.push_back(
        {group, name, *shape, "", [place, at, layout, full, bytes = bytes_](auto columns) {
           ByteStream stream = place.stream(*bytes);
           const bool there = stream.skip(at);
           const MatrixReading reading = there ? read_matrix(stream, layout, columns) : MatrixReading{false};
           const bool sound = reading.whole && (!place.compressed || *place.is_sound || stream.finish());
           bytes->release(place.bytes);
           if (sound) return reading.rounded;
           text::fail(
               bytes->name(),
               fmt::format("the data of {} are damaged; fetch the file again, or save it again with '-v6'", full));
         }});
  }

  void structure(Elements& elements, const Place& place, const Head& h, const std::string& full, int depth) {
    constexpr int kDeepest = 8;
    constexpr std::size_t kMostNames = std::size_t{1} << 20, kMostLength = 1024;
    const bool one = std::ranges::all_of(h.dimensions, [](std::int64_t n) { return n == 1; });
    if (!one || depth == kDeepest) return leave_out(one ? "structs too deep" : "arrays of structs", full);
    const std::string length_bytes = elements.text(sizeof(std::uint32_t));
    if (length_bytes.size() != sizeof(std::uint32_t)) throw Damage{};
    const std::uint32_t length = elements.u32(length_bytes, 0);
    if (length == 0 || length > kMostLength) throw Damage{};
    const std::string names = elements.text(kMostNames);
    for (std::size_t i = 0; i + length <= names.size(); i += length) {
      const std::string_view padded = std::string_view(names).substr(i, length);
      const std::string field = clean_name(padded.substr(0, padded.find('\0')));
      const Tag tag = elements.tag();
      if (tag.type != kMatrix) throw Damage{};
      const std::uint64_t begin = elements.at();
      if (tag.size > 0) matrix(elements, place, full, field.empty() ? "?" : field, depth + 1);
      const std::uint64_t used = elements.at() - begin;
      if (used > tag.size) throw Damage{};
      elements.skip(tag.size - used + tag.padding);
    }
  }

  std::unique_ptr<Recording> finish() {
    if (bytes_->cut()) notes_.push_back(fmt::format("the {} data stop in the middle", name(bytes_->compression())));
    objects_.note(notes_);
    left_out_.note(notes_);
    return std::make_unique<ArrayRecording>("MATLAB 5 to 7", std::move(arrays_), std::move(notes_), bytes_);
  }

  std::shared_ptr<const Bytes> bytes_;
  std::string_view text_;
  bool big_endian_ = false;
  std::size_t subsystem_ = 0;
  std::vector<Array> arrays_;
  MatlabObjects objects_;
  NamesByReason left_out_;
  std::vector<std::string> notes_;
};

}  // namespace
}  // namespace gyrobudget::inline v0::log::mat

namespace gyrobudget::inline v0::log {

bool is_mat(std::string_view head) {
  using namespace std::string_view_literals;
  if (!head.starts_with(mat::kTitle) || head.size() < mat::kHeader) return false;
  const std::string_view version = head.substr(mat::kVersionAt, 4);
  return version == "\x00\x01IM"sv || version == "\x01\x00MI"sv;
}

std::unique_ptr<Recording> open_mat(std::shared_ptr<const Bytes> bytes) { return mat::Reader(bytes).run(); }

}  // namespace gyrobudget::inline v0::log
