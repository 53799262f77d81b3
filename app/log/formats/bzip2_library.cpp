// SPDX-License-Identifier: MIT
#include "packing_library.h"

#if GYROBUDGET_HAS_BZIP2
#include <bzlib.h>

#include <algorithm>
#include <limits>
#include <new>
#endif

namespace gyrobudget::inline v0::log {

#if GYROBUDGET_HAS_BZIP2
namespace {

std::string_view bzip2_fault(int status) {
  switch (status) {
    case BZ_DATA_ERROR:
      return "a check sum does not fit";
    case BZ_DATA_ERROR_MAGIC:
      return "it is no bzip2 stream";
    default:
      return "it is damaged";
  }
}

PackingResult unpack_bzip2(std::string_view packed, std::span<char> out) {
  constexpr std::size_t kMost = std::numeric_limits<unsigned>::max();  // that the library counts
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  std::size_t taken = 0, filled = 0;
  int status = BZ_OK;
  bool moved = true;
  while (status == BZ_OK && moved) {
    stream.next_in = const_cast<char*>(packed.data() + taken);  // its interface; it only reads
    stream.avail_in = static_cast<unsigned>(std::min(kMost, packed.size() - taken));
    stream.next_out = out.data() + filled;
    stream.avail_out = static_cast<unsigned>(std::min(kMost, out.size() - filled));
    status = BZ2_bzDecompress(&stream);
    const auto now_taken = static_cast<std::size_t>(stream.next_in - packed.data());
    const auto now_filled = static_cast<std::size_t>(stream.next_out - out.data());
    moved = now_taken > taken || now_filled > filled;
    taken = now_taken;
    filled = now_filled;
  }
  BZ2_bzDecompressEnd(&stream);
  if (status == BZ_STREAM_END) return {filled, {}};
  if (status == BZ_MEM_ERROR) throw std::bad_alloc();
  if (status != BZ_OK) return {filled, std::string(bzip2_fault(status))};
  return {filled, std::string(taken == packed.size() ? kPackedEndsEarly : kUnpacksToMore)};
}

}  // namespace
#endif

const PackingLibrary& bzip2_library() {
#if GYROBUDGET_HAS_BZIP2
  static constexpr PackingLibrary kLibrary{"bzip2", "libbz2-dev", unpack_bzip2};
#else
  static constexpr PackingLibrary kLibrary{"bzip2", "libbz2-dev", nullptr};
#endif
  return kLibrary;
}

}  // namespace gyrobudget::inline v0::log
