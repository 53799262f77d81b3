// SPDX-License-Identifier: MIT
#include "npz.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "../binary.h"
#include "arrays.h"
#include "rows.h"

namespace gyrobudget::inline v0::log::npz {
namespace {

using namespace std::string_view_literals;

// --- Zip ------------------------------------------------------------------------------------------------------------

constexpr std::string_view kLocal = "PK\x03\x04"sv, kCentral = "PK\x01\x02"sv, kEnd = "PK\x05\x06"sv,
                           kEnd64 = "PK\x06\x06"sv, kEnd64Locator = "PK\x06\x07"sv;
constexpr std::size_t kLocalBytes = 30, kCentralBytes = 46, kEndBytes = 22, kEnd64Bytes = 56, kLocatorBytes = 20;
constexpr std::uint32_t kIn64 = 0xffffffff;  // the number stands in the extra field
constexpr std::uint16_t kStored = 0, kDeflated = 8;
constexpr int kRawWindow = -15;

struct Member {
  std::string name;
  std::uint16_t method = 0, flags = 0;
  std::uint32_t crc = 0;
  std::uint64_t packed = 0, size = 0;  ///< bytes
  std::string_view data;
};

/// Numbers of 8 bytes for those of 4 that say so, in their order.
bool widen(std::string_view extra, std::initializer_list<std::uint64_t*> numbers) {
  constexpr std::uint16_t kZip64 = 1;
  constexpr std::size_t kFieldHead = 4;
  while (extra.size() >= kFieldHead) {
    const auto id = load<std::uint16_t>(extra, 0), size = load<std::uint16_t>(extra, 2);
    if (size > extra.size() - kFieldHead) return false;
    std::string_view field = extra.substr(kFieldHead, size);
    extra.remove_prefix(kFieldHead + size);
    if (id != kZip64) continue;
    for (std::uint64_t* number : numbers) {
      if (*number != kIn64) continue;
      if (field.size() < sizeof(std::uint64_t)) return false;
      *number = load<std::uint64_t>(field, 0);
      field.remove_prefix(sizeof(std::uint64_t));
    }
  }
  return true;
}

/// A member by its own header. @returns where the next begins; 0 where the member is not whole or not told
std::size_t read_local(std::string_view zip, std::size_t at, Member& member) {
  if (at > zip.size() || zip.size() - at < kLocalBytes || !zip.substr(at).starts_with(kLocal)) return 0;
  const std::size_t name = load<std::uint16_t>(zip, at + 26), extra = load<std::uint16_t>(zip, at + 28);
  const std::size_t left = zip.size() - at - kLocalBytes;
  if (name + extra > left) return 0;
  if (member.name.empty()) {  // no directory has told of it
    member.name = zip.substr(at + kLocalBytes, name);
    member.flags = load<std::uint16_t>(zip, at + 6);
    member.method = load<std::uint16_t>(zip, at + 8);
    member.crc = load<std::uint32_t>(zip, at + 14);
    member.packed = load<std::uint32_t>(zip, at + 18);
    member.size = load<std::uint32_t>(zip, at + 22);
    if (!widen(zip.substr(at + kLocalBytes + name, extra), {&member.size, &member.packed})) return 0;
    constexpr std::uint16_t kSizesBehind = 8;
    if ((member.flags & kSizesBehind) != 0) return 0;
  }
  if (member.packed > left - name - extra) return 0;
  const std::size_t begin = at + kLocalBytes + name + extra;
  member.data = zip.substr(begin, member.packed);
  return begin + member.packed;
}

struct Directory {
  std::vector<Member> members;
  bool whole = false;
  std::size_t end = 0;  ///< where the last whole member ends
};

/// Where the central directory is, told by what ends the file.
std::optional<std::pair<std::uint64_t, std::uint64_t>> find_directory(std::string_view zip) {
  const std::size_t at = zip.rfind(kEnd);
  if (at == std::string_view::npos || zip.size() - at < kEndBytes) return std::nullopt;
  std::uint64_t entries = load<std::uint16_t>(zip, at + 10), offset = load<std::uint32_t>(zip, at + 16);
  if (at >= kLocatorBytes && zip.substr(at - kLocatorBytes).starts_with(kEnd64Locator)) {
    const auto at64 = load<std::uint64_t>(zip, at - kLocatorBytes + 8);
    if (at64 > zip.size() || zip.size() - at64 < kEnd64Bytes || !zip.substr(at64).starts_with(kEnd64))
      return std::nullopt;
    entries = load<std::uint64_t>(zip, at64 + 32);
    offset = load<std::uint64_t>(zip, at64 + 48);
  }
  return std::pair{entries, offset};
}

Directory read_directory(std::string_view zip) {
  Directory directory;
  const auto place = find_directory(zip);
  if (!place) return directory;
  std::uint64_t at = place->second;
  for (std::uint64_t i = 0; i < place->first; ++i) {
    if (at > zip.size() || zip.size() - at < kCentralBytes || !zip.substr(at).starts_with(kCentral)) return directory;
    Member member;
    member.flags = load<std::uint16_t>(zip, at + 8);
    member.method = load<std::uint16_t>(zip, at + 10);
    member.crc = load<std::uint32_t>(zip, at + 16);
    member.packed = load<std::uint32_t>(zip, at + 20);
    member.size = load<std::uint32_t>(zip, at + 24);
    std::uint64_t local = load<std::uint32_t>(zip, at + 42);
    const std::size_t name = load<std::uint16_t>(zip, at + 28), extra = load<std::uint16_t>(zip, at + 30),
                      comment = load<std::uint16_t>(zip, at + 32);
    if (name == 0 || name + extra + comment > zip.size() - at - kCentralBytes) return directory;
    member.name = zip.substr(at + kCentralBytes, name);
    if (!widen(zip.substr(at + kCentralBytes + name, extra), {&member.size, &member.packed, &local})) return directory;
    if (read_local(zip, local, member) == 0) return directory;
    directory.members.push_back(std::move(member));
    at += kCentralBytes + name + extra + comment;
  }
  directory.whole = true;
  return directory;
}

/// The members of an archive; where it was cut, those whose own headers tell their lengths.
Directory read_archive(std::string_view zip) {
  Directory directory = read_directory(zip);
  if (directory.whole) return directory;
  directory.members.clear();
  for (;;) {
    Member member;
    const std::size_t next = read_local(zip, directory.end, member);
    if (next == 0) return directory;
    directory.members.push_back(std::move(member));
    directory.end = next;
  }
}

// --- Arrays ---------------------------------------------------------------------------------------------------------

/// "<f8": nothing for what is no real number.
std::optional<std::pair<NumberType, bool>> number_type(std::string_view descr) {
  struct Spelling {
    std::string_view text;
    NumberType type;
  };
  constexpr Spelling kSpellings[] = {{"i1", NumberType::i8},  {"u1", NumberType::u8},  {"b1", NumberType::u8},
                                     {"i2", NumberType::i16}, {"u2", NumberType::u16}, {"i4", NumberType::i32},
                                     {"u4", NumberType::u32}, {"i8", NumberType::i64}, {"u8", NumberType::u64},
                                     {"f2", NumberType::f16}, {"f4", NumberType::f32}, {"f8", NumberType::f64}};
  const bool has_order = !descr.empty() && "<>|="sv.find(descr.front()) != std::string_view::npos;
  const std::string_view kind = has_order ? descr.substr(1) : descr;
  const auto* found = std::ranges::find(kSpellings, kind, &Spelling::text);
  if (found == std::end(kSpellings)) return std::nullopt;
  return std::pair{found->type, descr.front() == '>'};
}

/// Where the bytes of a .npy come from.
struct Place {
  std::string_view data;
  bool deflated = false;
  std::optional<std::uint32_t> crc = {};  ///< that an archive tells

  [[nodiscard]] ByteStream stream(const Bytes& file) const {
    return deflated ? ByteStream(file, data, kRawWindow) : ByteStream(file, data);
  }
  [[nodiscard]] std::uint64_t most() const {
    constexpr std::uint64_t kMostGrowth = 1100;
    return deflated ? kMostGrowth * data.size() : data.size();
  }
};

NpyHeader header_of(const Place& place, const Bytes& file) {
  constexpr std::size_t kPrefix = 12;
  const std::string prefix(place.stream(file).take(kPrefix));
  const std::size_t size = npy_header_bytes(file.name(), prefix);
  ByteStream stream = place.stream(file);
  return parse_npy_header(file.name(), stream.take(size));
}

/// An array and where its numbers are; what is wrong with it otherwise.
struct Parsed {
  std::optional<Array> array;
  std::string_view reason;
};

Parsed parse(const Place& place, const NpyHeader& header, const std::string& name,
             const std::shared_ptr<const Bytes>& bytes) {
  const auto type = number_type(header.descr);
  if (!type) return {{}, header.descr.ends_with('O') ? "Python objects" : "no real numbers"};
  const auto shape = array_shape(header.shape);
  if (!shape) return {{}, "empty, of more than two dimensions, or wide"};
  const MatrixLayout layout{type->first, type->second, *shape, header.fortran_order != shape->transposed};
  if (layout.bytes() + (place.deflated ? 0 : header.bytes) > place.most()) return {{}, "cut"};
  const auto read = [place, layout, name, skipped = header.bytes, bytes](std::span<const WantedColumn> columns) {
    ByteStream stream = place.stream(*bytes);
    if (place.crc) stream.watch();
    const bool there = stream.skip(skipped);
    const MatrixReading reading = there ? read_matrix(stream, layout, columns) : MatrixReading{false};
    const bool sound = reading.whole && (!place.crc || (stream.finish() && stream.crc() == *place.crc));
    bytes->release(place.data);
    if (sound) return reading.rounded;
    text::fail(bytes->name(),
               fmt::format("the data of {} stop in the middle or are damaged; save it again with numpy", name));
  };
  return {Array{"", name, *shape, "", read}, {}};
}

}  // namespace
}  // namespace gyrobudget::inline v0::log::npz

namespace gyrobudget::inline v0::log {

bool is_npz(std::string_view head) {
  if (!head.starts_with(npz::kLocal) || head.size() < npz::kLocalBytes) return false;
  const std::string_view name = head.substr(npz::kLocalBytes, load<std::uint16_t>(head, 26));
  return name.ends_with(".npy");
}

bool is_other_zip(std::string_view head) { return head.starts_with(npz::kLocal) && !is_npz(head); }

bool is_other_npy(std::string_view head) {
  if (!head.starts_with("\x93NUMPY")) return false;
  try {
    const NpyHeader header = parse_npy_header("", head);
    const bool plain = header.descr == "<f8" || header.descr == "<f4";
    const auto shape = array_shape(header.shape);
    if (!shape || !npz::number_type(header.descr)) return false;
    return !plain || header.shape.size() > 2 ||
           (header.fortran_order && header.shape.size() == 2 && header.shape[1] != 1);
  } catch (const text::InputError&) {
    return false;  // read_log says what is wrong
  }
}

std::unique_ptr<Recording> open_npz(std::shared_ptr<const Bytes> bytes) {
  constexpr std::string_view kEnding = ".npy";
  const std::string_view zip = bytes->text();
  const npz::Directory directory = npz::read_archive(zip);
  std::vector<Array> arrays;
  std::vector<std::string> notes;
  NamesByReason left_out;
  const auto leave_out = [&](std::string_view reason, std::string_view name) {
    left_out.add(fmt::format("left out, {}", reason), name);
  };
  if (!directory.whole)
    notes.push_back(fmt::format("the archive has no end: {} were found whole up to byte {}",
                                counted(directory.members.size(), "array"), directory.end));
  for (const npz::Member& member : directory.members) {
    if (!member.name.ends_with(kEnding)) {
      leave_out("no arrays", clean_name(member.name));
      continue;
    }
    const std::string name = clean_name(std::string_view(member.name).substr(0, member.name.size() - kEnding.size()));
    const bool encrypted = (member.flags & 1) != 0;
    if (encrypted || (member.method != npz::kStored && member.method != npz::kDeflated)) {
      leave_out(encrypted ? "encrypted" : "packed in a way that NumPy has not", name);
      continue;
    }
    const npz::Place place{member.data, member.method == npz::kDeflated, member.crc};
    try {
      npz::Parsed parsed = npz::parse(place, npz::header_of(place, *bytes), name, bytes);
      if (parsed.array) {
        arrays.push_back(std::move(*parsed.array));
      } else {
        leave_out(parsed.reason, name);
      }
    } catch (const text::InputError&) {
      leave_out("records of several fields, or damaged", name);
    }
  }
  left_out.note(notes);
  return std::make_unique<ArrayRecording>("NumPy npz", std::move(arrays), std::move(notes), bytes);
}

std::unique_ptr<Recording> open_other_npy(std::shared_ptr<const Bytes> bytes) {
  const npz::Place place{bytes->text()};
  npz::Parsed parsed = npz::parse(place, npz::header_of(place, *bytes), "array", bytes);
  if (!parsed.array)
    text::fail(bytes->name(),
               fmt::format("holds an array that is {}; copy the file again, or save it as numbers", parsed.reason));
  std::vector<Array> arrays;
  arrays.push_back(std::move(*parsed.array));
  return std::make_unique<ArrayRecording>("NumPy array", std::move(arrays), std::vector<std::string>{}, bytes);
}

}  // namespace gyrobudget::inline v0::log
