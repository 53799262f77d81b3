// SPDX-License-Identifier: MIT
#include "compression.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

using namespace std::string_view_literals;

/// What is to be known of each way to pack.
struct CompressionFacts {
  Compression compression;
  std::string_view name, command, ending, package;
  std::unique_ptr<Decompressor> (*make)();
};

constexpr std::array<CompressionFacts, 5> kCompressions{
    {{Compression::none, "", "", "", "", nullptr},
     {Compression::gzip, "gzip", "zcat", ".gz", "zlib1g-dev", gzip_decompressor},
     {Compression::zstd, "zstd", "zstdcat", ".zst", "libzstd-dev", zstd_decompressor},
     {Compression::bzip2, "bzip2", "bzcat", ".bz2", "libbz2-dev", bzip2_decompressor},
     {Compression::lz4, "lz4", "lz4cat", ".lz4", "liblz4-dev", lz4_decompressor}}};

const CompressionFacts& facts(Compression compression) {
  return kCompressions.at(static_cast<std::size_t>(compression));
}

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

Compression compression_of(std::string_view head) {
  if (head.starts_with("\x1f\x8b") && agrees(head, "\x1f\x8b\x08"sv)) return Compression::gzip;
  if (head.starts_with("\x28\xb5\x2f\xfd"sv)) return Compression::zstd;
  if (head.starts_with("\x04\x22\x4d\x18"sv)) return Compression::lz4;
  return is_bzip2(head) ? Compression::bzip2 : Compression::none;
}

std::string_view name(Compression compression) { return facts(compression).name; }
std::string_view command(Compression compression) { return facts(compression).command; }

std::string_view without_compression(std::string_view path) {
  const std::string lower = text::lower(path);
  for (const CompressionFacts& f : kCompressions)
    if (!f.ending.empty() && lower.ends_with(f.ending)) return path.substr(0, path.size() - f.ending.size());
  constexpr std::string_view kLong = ".zstd";  // as rosbag2 has it
  return lower.ends_with(kLong) ? path.substr(0, path.size() - kLong.size()) : path;
}

std::unique_ptr<Decompressor> make_decompressor(Compression compression, std::string_view source) {
  const CompressionFacts& f = facts(compression);
  std::unique_ptr<Decompressor> decompressor = f.make ? f.make() : nullptr;
  if (decompressor) return decompressor;
  text::fail(
      source,
      fmt::format(
          "holds {} data, which this build cannot unpack; build it with Debian's package {}, or unpack the file first ({})",
          f.name, f.package, f.command));
}

void require_library(Compression compression, std::string_view source) {
  static const auto kThere = [] {
    std::array<bool, kCompressions.size()> there{};
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = kCompressions[i].make && kCompressions[i].make();
    return there;
  }();
  if (compression == Compression::none || kThere.at(static_cast<std::size_t>(compression))) return;
  static_cast<void>(make_decompressor(compression, source));
}

std::uint64_t most_unpacked(std::size_t packed) {
  constexpr std::uint64_t kAlways = std::uint64_t{64} << 20, kRatio = 1100;
  return kAlways + kRatio * packed;
}

FrameReader::FrameReader(Decompressor& decompressor, std::string_view packed)
    : decompressor_(decompressor), compression_(compression_of(packed)), packed_(packed) {}

FrameReader::Piece FrameReader::next(std::span<char> out) {
  const std::size_t before = packed_.size();
  Decompressor::Step step = decompressor_.step(packed_, out);
  if (!step.damage.empty()) return {step.written, State::damaged, std::move(step.damage)};
  if (step.ended) return {step.written, behind_frame(), {}};
  const bool is_stuck = step.written == 0 && packed_.size() == before;
  return {step.written, is_stuck && !out.empty() ? State::cut : State::going_on, {}};
}

FrameReader::State FrameReader::behind_frame() {
  constexpr std::string_view kSkippable = "\x2a\x4d\x18";  // behind a byte from 0x50 to 0x5f, in zstd and lz4
  if (packed_.find_first_not_of('\0') == std::string_view::npos) return State::whole;
  const bool is_skippable = packed_.size() > kSkippable.size() && (packed_[0] & 0xf0) == 0x50 &&
                            packed_.substr(1).starts_with(kSkippable) &&
                            (compression_ == Compression::zstd || compression_ == Compression::lz4);
  if (compression_of(packed_) != compression_ && !is_skippable) return State::foreign;
  decompressor_.restart();
  return State::going_on;
}

std::string unpacked_head(std::string_view packed, std::size_t most) {
  const CompressionFacts& f = facts(compression_of(packed));
  const std::unique_ptr<Decompressor> decompressor = f.make ? f.make() : nullptr;
  if (!decompressor) return {};
  std::string head(most, '\0');
  std::size_t size = 0;
  FrameReader frames(*decompressor, packed);
  for (auto state = FrameReader::State::going_on; state == FrameReader::State::going_on && size < most;) {
    const FrameReader::Piece piece = frames.next(std::span(head).subspan(size));
    size += piece.written;
    state = piece.state;
  }
  head.resize(size);
  return head;
}

}  // namespace gyrobudget::inline v0::log
