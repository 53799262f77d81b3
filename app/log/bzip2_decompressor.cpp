// SPDX-License-Identifier: MIT
#include "compression.h"

#if GYROBUDGET_HAS_BZIP2
#include <bzlib.h>

#include <algorithm>
#include <new>
#endif

namespace gyrobudget::inline v0::log {
#if GYROBUDGET_HAS_BZIP2
namespace {

constexpr std::size_t kMostBzip2 = std::size_t{1} << 30;  // bytes a step, which the library counts with 32 bits

class Bzip2Decompressor : public Decompressor {
 public:
  Bzip2Decompressor() { begin(); }
  ~Bzip2Decompressor() override { BZ2_bzDecompressEnd(&stream_); }

  Step step(std::string_view& packed, std::span<char> out) override {
    const std::size_t offered = std::min(packed.size(), kMostBzip2), room = std::min(out.size(), kMostBzip2);
    stream_.next_in = const_cast<char*>(packed.data());  // the library's interface; only read
    stream_.avail_in = static_cast<unsigned>(offered);
    stream_.next_out = out.data();
    stream_.avail_out = static_cast<unsigned>(room);
    const int status = BZ2_bzDecompress(&stream_);
    if (status == BZ_MEM_ERROR) throw std::bad_alloc();
    packed.remove_prefix(offered - stream_.avail_in);
    Step step{room - stream_.avail_out, status == BZ_STREAM_END, {}};
    if (status != BZ_OK && status != BZ_STREAM_END)
      step.damage = status == BZ_DATA_ERROR ? "check sum" : "not as bzip2 writes it";
    return step;
  }
  void restart() override {
    BZ2_bzDecompressEnd(&stream_);
    begin();
  }

 private:
  void begin() {
    stream_ = {};
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }

  bz_stream stream_ = {};
};

}  // namespace

std::unique_ptr<Decompressor> bzip2_decompressor() { return std::make_unique<Bzip2Decompressor>(); }
#else
std::unique_ptr<Decompressor> bzip2_decompressor() { return nullptr; }
#endif

}  // namespace gyrobudget::inline v0::log
