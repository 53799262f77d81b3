// SPDX-License-Identifier: MIT
#include "unpacker.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace gyrobudget::inline v0::log {

Decompressor& Unpacker::decompressor(Compression compression) {
  if (!decompressor_ || compression != compression_) {
    decompressor_ = make_decompressor(compression, name_);
    compression_ = compression;
  } else {
    decompressor_->restart();
  }
  return *decompressor_;
}

Unpacked Unpacker::unpack(Compression compression, std::string_view packed, std::optional<std::uint64_t> size) {
  if (compression == Compression::none) return {packed, {}};
  Decompressor& by = decompressor(compression);
  const std::uint64_t most = most_unpacked(packed.size()), room = size.value_or(most);
  if (room > most) return {{}, fmt::format("{} packed bytes cannot unpack to {}", packed.size(), room)};
  // Of this room the kernel gives only what is written to.
  const std::span<char> out(pages_.room(static_cast<std::size_t>(std::max<std::uint64_t>(room, 1))),
                            static_cast<std::size_t>(room));
  using State = FrameReader::State;
  FrameReader frames(by, packed);
  std::size_t filled = 0;
  for (;;) {
    const std::size_t before = frames.rest().size();
    const FrameReader::Piece piece = frames.next(out.subspan(filled));
    filled += piece.written;
    const std::string_view bytes(out.data(), filled);
    const bool is_stuck = piece.written == 0 && frames.rest().size() == before;
    if (piece.state == State::damaged) return {bytes, piece.damage};
    if (piece.state == State::cut) return {bytes, "the packed bytes end early"};
    if (piece.state == State::going_on && !is_stuck) continue;
    if (piece.state == State::going_on && frames.rest().empty()) return {bytes, "the packed bytes end early"};
    if (piece.state == State::going_on) return {bytes, "it unpacks to more bytes than it says"};
    if (size && filled != *size) return {bytes, fmt::format("it unpacks to {} bytes, expected {}", filled, *size)};
    return {bytes, {}};
  }
}

}  // namespace gyrobudget::inline v0::log
