// SPDX-License-Identifier: MIT
#include "packing_library.h"

#if GYROBUDGET_HAS_LZ4
#include <lz4frame.h>

#include <algorithm>
#include <memory>
#include <new>
#endif

namespace gyrobudget::inline v0::log {

#if GYROBUDGET_HAS_LZ4
namespace {

struct FreeLz4Context {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

LZ4F_dctx* lz4_context() {
  thread_local const std::unique_ptr<LZ4F_dctx, FreeLz4Context> kContext = [] {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) throw std::bad_alloc();
    return std::unique_ptr<LZ4F_dctx, FreeLz4Context>(context);
  }();
  LZ4F_resetDecompressionContext(kContext.get());
  return kContext.get();
}

/// In one go, or block by block, where a damaged block spoils no more than itself.
PackingResult unpack_frame(std::string_view packed, std::span<char> out, bool by_blocks) {
  LZ4F_dctx* context = lz4_context();
  LZ4F_decompressOptions_t options = {};
  options.stableDst = 1;
  std::size_t filled = 0, wanted = by_blocks ? 1 : packed.size();
  for (;;) {
    std::size_t taken = std::min(wanted, packed.size()), made = out.size() - filled;
    const std::size_t next = LZ4F_decompress(context, out.data() + filled, &made, packed.data(), &taken, &options);
    if (LZ4F_isError(next)) return {filled, LZ4F_getErrorName(next)};
    filled += made;
    packed.remove_prefix(taken);
    if (next == 0) return {filled, {}};
    if (made == 0 && taken == 0) return {filled, std::string(packed.empty() ? kPackedEndsEarly : kUnpacksToMore)};
    wanted = by_blocks ? next : packed.size();
  }
}

PackingResult unpack_lz4(std::string_view packed, std::span<char> out) {
  PackingResult result = unpack_frame(packed, out, false);
  return result.fault.empty() ? result : unpack_frame(packed, out, true);
}

}  // namespace
#endif

const PackingLibrary& lz4_library() {
#if GYROBUDGET_HAS_LZ4
  static constexpr PackingLibrary kLibrary{"lz4", "liblz4-dev", unpack_lz4};
#else
  static constexpr PackingLibrary kLibrary{"lz4", "liblz4-dev", nullptr};
#endif
  return kLibrary;
}

}  // namespace gyrobudget::inline v0::log
