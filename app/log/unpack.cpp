// SPDX-License-Identifier: MIT
#include "unpack.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace gyrobudget::inline v0::log {
namespace {

using namespace std::string_view_literals;

/// What is to be known of each way to pack.
struct PackingFacts {
  Packing packing;
  std::string_view name, command, ending, package;
  std::unique_ptr<Unpacker> (*make)();
};

constexpr std::array<PackingFacts, 5> kPackings{
    {{Packing::none, "", "", "", "", nullptr},
     {Packing::gzip, "gzip", "zcat", ".gz", "zlib1g-dev", gzip_unpacker},
     {Packing::zstd, "zstd", "zstdcat", ".zst", "libzstd-dev", zstd_unpacker},
     {Packing::bzip2, "bzip2", "bzcat", ".bz2", "libbz2-dev", bzip2_unpacker},
     {Packing::lz4, "lz4", "lz4cat", ".lz4", "liblz4-dev", lz4_unpacker}}};

const PackingFacts& facts(Packing packing) { return kPackings.at(static_cast<std::size_t>(packing)); }

/// Whether the text, as far as both go, is that of the mark.
bool agrees(std::string_view text, std::string_view mark) {
  const std::size_t shared = std::min(text.size(), mark.size());
  return text.substr(0, shared) == mark.substr(0, shared);
}

/// A level, then the mark of a block or of the end: text may begin with BZh too.
bool is_bzip2(std::string_view head) {
  constexpr std::size_t kMark = 3;
  if (!head.starts_with("BZh") || head.size() <= kMark || head[kMark] < '1' || head[kMark] > '9') return false;
  const std::string_view block = head.substr(kMark + 1);
  return agrees(block, "\x31\x41\x59\x26\x53\x59"sv) || agrees(block, "\x17\x72\x45\x38\x50\x90"sv);
}

}  // namespace

Packing packing_of(std::string_view head) {
  if (head.starts_with("\x1f\x8b") && agrees(head, "\x1f\x8b\x08"sv)) return Packing::gzip;
  if (head.starts_with("\x28\xb5\x2f\xfd"sv)) return Packing::zstd;
  if (head.starts_with("\x04\x22\x4d\x18"sv)) return Packing::lz4;
  return is_bzip2(head) ? Packing::bzip2 : Packing::none;
}

std::string_view name(Packing packing) { return facts(packing).name; }
std::string_view command(Packing packing) { return facts(packing).command; }

std::string_view without_packing(std::string_view path) {
  const std::string lower = text::lower(path);
  for (const PackingFacts& f : kPackings)
    if (!f.ending.empty() && lower.ends_with(f.ending)) return path.substr(0, path.size() - f.ending.size());
  constexpr std::string_view kLong = ".zstd";  // as rosbag2 has it
  return lower.ends_with(kLong) ? path.substr(0, path.size() - kLong.size()) : path;
}

std::unique_ptr<Unpacker> make_unpacker(Packing packing, std::string_view source) {
  const PackingFacts& f = facts(packing);
  std::unique_ptr<Unpacker> unpacker = f.make ? f.make() : nullptr;
  if (unpacker) return unpacker;
  text::fail(
      source,
      fmt::format(
          "holds {} data, which this build cannot unpack; build it with Debian's package {}, or unpack the file first ({})",
          f.name, f.package, f.command));
}

std::string unpacked_head(std::string_view packed, std::size_t most) {
  const PackingFacts& f = facts(packing_of(packed));
  const std::unique_ptr<Unpacker> unpacker = f.make ? f.make() : nullptr;
  std::string head(most, '\0');
  std::size_t size = 0;
  while (unpacker && size < most) {
    const std::size_t before = packed.size();
    const Unpacker::Step step = unpacker->step(packed, std::span(head).subspan(size));
    size += step.written;
    if (step.ended || !step.damage.empty() || (step.written == 0 && packed.size() == before)) break;
  }
  head.resize(size);
  return head;
}

}  // namespace gyrobudget::inline v0::log
