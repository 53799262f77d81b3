// SPDX-License-Identifier: MIT
#include "packing_library.h"

#if GYROBUDGET_HAS_ZSTD
#include <zstd.h>

#include <memory>
#include <new>
#include <vector>
#endif

namespace gyrobudget::inline v0::log {

#if GYROBUDGET_HAS_ZSTD
namespace {

struct FreeZstdContext {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

ZSTD_DCtx* zstd_context() {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeZstdContext> kContext(ZSTD_createDCtx());
  if (!kContext) throw std::bad_alloc();
  ZSTD_DCtx_reset(kContext.get(), ZSTD_reset_session_only);
  return kContext.get();
}

PackingResult unpack_zstd(std::string_view packed, std::span<char> out) {
  ZSTD_DCtx* context = zstd_context();
  ZSTD_inBuffer input{packed.data(), packed.size(), 0};
  ZSTD_outBuffer output{out.data(), out.size(), 0};
  for (;;) {
    const std::size_t taken = input.pos, filled = output.pos;
    const std::size_t next = ZSTD_decompressStream(context, &output, &input);
    if (ZSTD_isError(next)) return {output.pos, ZSTD_getErrorName(next)};
    // A frame may end with padding, or be followed by another one.
    if (next == 0 && (input.pos == input.size || output.pos == output.size)) return {output.pos, {}};
    if (next == 0 || input.pos > taken || output.pos > filled) continue;
    return {output.pos, std::string(input.pos == input.size ? kPackedEndsEarly : kUnpacksToMore)};
  }
}

}  // namespace
#endif

const PackingLibrary& zstd_library() {
#if GYROBUDGET_HAS_ZSTD
  static constexpr PackingLibrary kLibrary{"zstd", "libzstd-dev", unpack_zstd};
#else
  static constexpr PackingLibrary kLibrary{"zstd", "libzstd-dev", nullptr};
#endif
  return kLibrary;
}

std::string unpack_zstd_stream([[maybe_unused]] std::string_view packed,
                               [[maybe_unused]] const std::function<void(std::string_view piece)>& take) {
#if GYROBUDGET_HAS_ZSTD
  ZSTD_DCtx* context = zstd_context();
  std::vector<char> piece(ZSTD_DStreamOutSize());
  ZSTD_inBuffer input{packed.data(), packed.size(), 0};
  for (;;) {
    ZSTD_outBuffer output{piece.data(), piece.size(), 0};
    const std::size_t next = ZSTD_decompressStream(context, &output, &input);
    take({piece.data(), output.pos});
    if (ZSTD_isError(next)) return ZSTD_getErrorName(next);
    if (next == 0 && input.pos == input.size) return {};
    if (next != 0 && input.pos == input.size && output.pos < output.size) return std::string(kPackedEndsEarly);
  }
#else
  return "this build has no zstd";
#endif
}

}  // namespace gyrobudget::inline v0::log
