// SPDX-License-Identifier: MIT
#include "unpack.h"

#ifdef GYROBUDGET_WITH_ZSTD
#include <zstd.h>
#include <zstd_errors.h>

#include <new>
#endif

namespace gyrobudget::inline v0::log {
#ifdef GYROBUDGET_WITH_ZSTD
namespace {

class ZstdUnpacker : public Unpacker {
 public:
  ZstdUnpacker() : stream_(ZSTD_createDStream()) {
    if (!stream_) throw std::bad_alloc();
  }
  ~ZstdUnpacker() override { ZSTD_freeDStream(stream_); }

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

std::unique_ptr<Unpacker> zstd_unpacker() { return std::make_unique<ZstdUnpacker>(); }
#else
std::unique_ptr<Unpacker> zstd_unpacker() { return nullptr; }
#endif

}  // namespace gyrobudget::inline v0::log
