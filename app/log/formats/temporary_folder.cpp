// SPDX-License-Identifier: MIT
#include "temporary_folder.h"

#include "gyrobudget/app/log/bytes.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cstring>
#include <fstream>
#include <utility>

#include "packing_library.h"
#include "unpacker.h"

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

std::string TemporaryFolder::unpack_zstd(const std::string& from, std::string_view file) const {
  require_packing(name_, Packing::zstd);
  const Bytes packed(from, Content::stored);
  const std::uint64_t most = most_unpacked(packed.text().size());
  std::ofstream out(folder_ / file, std::ios::binary);
  std::uint64_t size = 0;
  return unpack_zstd_stream(packed.text(), [&](std::string_view piece) {
    size += piece.size();
    if (size > most) {
      text::fail(name_, fmt::format(
                            "unpacks to more than {} bytes, which {} packed bytes of a recording cannot; it is damaged",
                            most, packed.text().size()));
    }
    out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
    out.flush();
    if (!out) {
      text::fail(name_, fmt::format("cannot be unpacked to {}: {}; name a folder with more room in TMPDIR",
                                    folder_.string(), std::strerror(errno)));
    }
  });
}

}  // namespace gyrobudget::inline v0::log
