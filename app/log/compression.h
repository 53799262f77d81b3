// SPDX-License-Identifier: MIT
// What inputs are packed in: gzip, zstd, bzip2 and lz4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

enum class Compression { none, gzip, zstd, bzip2, lz4 };

/// Told by the first bytes of an input; ten of them are enough.
[[nodiscard]] Compression compression_of(std::string_view head);
/// "gzip", "zstd", "bzip2", "lz4"; empty for none.
[[nodiscard]] std::string_view name(Compression compression);
/// The command that unpacks to its standard output: "zcat".
[[nodiscard]] std::string_view command(Compression compression);
/// The name without the ending that says how it is packed: "log.npy" for "log.npy.zst".
[[nodiscard]] std::string_view without_compression(std::string_view path);

/// Unpacks one frame (gzip: member, bzip2: stream) behind the other. It keeps no more than a window of what it wrote.
class Decompressor {
 public:
  struct Step {
    std::size_t written = 0;
    bool ended = false;  ///< of this frame; restart() begins the next one
    std::string damage;  ///< what is wrong with the data; empty for nothing
  };

  Decompressor() = default;
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;
  virtual ~Decompressor() = default;
  /// Takes what it uses off the front of `packed`. Where it neither takes nor writes anything, it wants more bytes.
  /// @throws std::bad_alloc
  virtual Step step(std::string_view& packed, std::span<char> out) = 0;
  virtual void restart() = 0;
};

/// @param source  for messages
/// @throws InputError where this build has no library for it, with the package that brings it; std::bad_alloc
[[nodiscard]] std::unique_ptr<Decompressor> make_decompressor(Compression compression, std::string_view source);

/// @throws InputError where this build has no library for it, as make_decompressor does.
void require_library(Compression compression, std::string_view source);

/// What packed bytes may unpack to: 1100 times their number, which is the most that gzip can do, and 64 MiB. No data of
/// sensors come near it; beyond it a few bytes would fill the memory.
[[nodiscard]] std::uint64_t most_unpacked(std::size_t packed);

/// Unpacks frame after frame; behind the last one may be padding with zeros.
class FrameReader {
 public:
  enum class State {
    going_on,
    whole,
    cut,      ///< the data stop in the middle: no more is written
    damaged,  ///< Piece::damage says how
    foreign,  ///< behind a frame follows what is none
  };
  struct Piece {
    std::size_t written = 0;
    State state = State::going_on;
    std::string damage;
  };

  /// @param decompressor  of the compression of `packed`, at the beginning of a frame; it must outlive this
  FrameReader(Decompressor& decompressor, std::string_view packed);
  /// Where `out` is empty it only finds out whether the frame ends here.
  Piece next(std::span<char> out);
  /// What was not taken yet.
  [[nodiscard]] std::string_view rest() const { return packed_; }

 private:
  [[nodiscard]] State behind_frame();

  Decompressor& decompressor_;
  Compression compression_;
  std::string_view packed_;
};

/// The first bytes of a packed input, `most` of them or fewer where it ends, is damaged, or cannot be unpacked.
[[nodiscard]] std::string unpacked_head(std::string_view packed, std::size_t most);

// Each in a file of its own, with its library; null in a build without it.
[[nodiscard]] std::unique_ptr<Decompressor> gzip_decompressor();
[[nodiscard]] std::unique_ptr<Decompressor> zstd_decompressor();
[[nodiscard]] std::unique_ptr<Decompressor> bzip2_decompressor();
[[nodiscard]] std::unique_ptr<Decompressor> lz4_decompressor();

}  // namespace gyrobudget::inline v0::log
