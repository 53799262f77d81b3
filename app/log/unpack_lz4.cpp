// SPDX-License-Identifier: MIT
#include "unpack.h"

#ifdef GYROBUDGET_WITH_LZ4
#include <lz4frame.h>

#include <new>
#endif

namespace gyrobudget::inline v0::log {
#ifdef GYROBUDGET_WITH_LZ4
namespace {

class Lz4Unpacker : public Unpacker {
 public:
  Lz4Unpacker() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  }
  ~Lz4Unpacker() override { LZ4F_freeDecompressionContext(context_); }

  Step step(std::string_view& packed, std::span<char> out) override {
    std::size_t taken = packed.size(), written = out.size();
    const std::size_t status = LZ4F_decompress(context_, out.data(), &written, packed.data(), &taken, nullptr);
    if (LZ4F_isError(status) != 0) return {0, false, LZ4F_getErrorName(status)};
    packed.remove_prefix(taken);
    return {written, status == 0, {}};
  }
  void restart() override { LZ4F_resetDecompressionContext(context_); }

 private:
  LZ4F_dctx* context_ = nullptr;
};

}  // namespace

std::unique_ptr<Unpacker> lz4_unpacker() { return std::make_unique<Lz4Unpacker>(); }
#else
std::unique_ptr<Unpacker> lz4_unpacker() { return nullptr; }
#endif

}  // namespace gyrobudget::inline v0::log
