// SPDX-License-Identifier: MIT
#include "compression.h"

#if GYROBUDGET_HAS_LZ4
#include <lz4frame.h>

#include <algorithm>
#include <new>
#endif

namespace gyrobudget::inline v0::log {
#if GYROBUDGET_HAS_LZ4
namespace {

class Lz4Decompressor : public Decompressor {
 public:
  Lz4Decompressor() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  }
  ~Lz4Decompressor() override { LZ4F_freeDecompressionContext(context_); }

  // As much at a time as the library asks for, a block: of a call that fails it tells nothing of what it wrote.
  Step step(std::string_view& packed, std::span<char> out) override {
    std::size_t taken = std::min(wanted_, packed.size()), written = out.size();
    const std::size_t status = LZ4F_decompress(context_, out.data(), &written, packed.data(), &taken, nullptr);
    if (LZ4F_isError(status) != 0) return {0, false, LZ4F_getErrorName(status)};
    packed.remove_prefix(taken);
    wanted_ = std::max<std::size_t>(status, 1);
    return {written, status == 0, {}};
  }
  void restart() override {
    LZ4F_resetDecompressionContext(context_);
    wanted_ = 1;
  }

 private:
  LZ4F_dctx* context_ = nullptr;
  std::size_t wanted_ = 1;
};

}  // namespace

std::unique_ptr<Decompressor> lz4_decompressor() { return std::make_unique<Lz4Decompressor>(); }
#else
std::unique_ptr<Decompressor> lz4_decompressor() { return nullptr; }
#endif

}  // namespace gyrobudget::inline v0::log
