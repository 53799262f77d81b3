// SPDX-License-Identifier: MIT
#include "compression.h"

#if GYROBUDGET_HAS_ZSTD
#include <zstd.h>
#include <zstd_errors.h>

#include <new>
#endif

namespace gyrobudget::inline v0::log {
#if GYROBUDGET_HAS_ZSTD
namespace {

class ZstdDecompressor : public Decompressor {
 public:
  ZstdDecompressor() : stream_(ZSTD_createDStream()) {
    if (!stream_) throw std::bad_alloc();
  }
  ~ZstdDecompressor() override { ZSTD_freeDStream(stream_); }

  Step step(std::string_view& packed, std::span<char> out) override {
    ZSTD_inBuffer from{packed.data(), packed.size(), 0};
    ZSTD_outBuffer to{out.data(), out.size(), 0};
    const std::size_t status = ZSTD_decompressStream(stream_, &to, &from);
    packed.remove_prefix(from.pos);
    Step step{to.pos, status == 0, {}};
    if (ZSTD_isError(status) == 0) return step;
    if (ZSTD_getErrorCode(status) == ZSTD_error_memory_allocation) throw std::bad_alloc();
    step.damage = ZSTD_getErrorName(status);
    return step;
  }
  void restart() override { ZSTD_DCtx_reset(stream_, ZSTD_reset_session_only); }

 private:
  ZSTD_DStream* stream_;
};

}  // namespace

std::unique_ptr<Decompressor> zstd_decompressor() { return std::make_unique<ZstdDecompressor>(); }
#else
std::unique_ptr<Decompressor> zstd_decompressor() { return nullptr; }
#endif

}  // namespace gyrobudget::inline v0::log
