// SPDX-License-Identifier: MIT
#include "temporary_folder.h"

#include "gyrobudget/app/log/bytes.h"
#include "gyrobudget/app/log/compression.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::log {

TemporaryFolder::TemporaryFolder(std::string name) : name_(std::move(name)) {
  std::error_code error;
  std::string pattern = (std::filesystem::temp_directory_path(error) / "gyrobudget-XXXXXX").string();
  if (error || !::mkdtemp(pattern.data())) {
    text::fail(name_,
               fmt::format("needs a temporary folder, and {} cannot be made; name one that can be written to in TMPDIR",
                           error ? "none" : pattern));
  }
  folder_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void TemporaryFolder::copy(const std::string& from, std::string_view file) const {
  std::error_code error;
  std::filesystem::copy_file(from, folder_ / file, error);
  if (error) {
    text::fail(name_, fmt::format("cannot be copied to {}: {}; name a folder with more room in TMPDIR",
                                  folder_.string(), error.message()));
  }
}

std::string TemporaryFolder::unpack(const std::string& from, std::string_view file) const {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  using State = FrameReader::State;
  const Bytes packed(from, Content::stored);
  const auto decompressor = make_decompressor(compression_of(packed.text()), name_);
  FrameReader frames(*decompressor, packed.text());
  const std::uint64_t most = most_unpacked(packed.text().size());
  std::ofstream out(folder_ / file, std::ios::binary);
  std::vector<char> room(kPiece);
  FrameReader::Piece piece;
  for (std::uint64_t size = 0; piece.state == State::going_on;) {
    piece = frames.next(room);
    size += piece.written;
    if (size > most)
      text::fail(name_, fmt::format(
                            "unpacks to more than {} bytes, which {} packed bytes of a recording cannot; it is damaged",
                            most, packed.text().size()));
    out.write(room.data(), static_cast<std::streamsize>(piece.written));
    if (!out)
      text::fail(name_, fmt::format("cannot be unpacked to {}: {}; name a folder with more room in TMPDIR",
                                    folder_.string(), std::strerror(errno)));
  }
  out.flush();
  if (piece.state == State::damaged) return piece.damage;
  if (piece.state == State::foreign) return "something else follows";
  return piece.state == State::cut ? "it ends early" : "";
}

}  // namespace gyrobudget::inline v0::log
