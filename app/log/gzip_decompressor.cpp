// SPDX-License-Identifier: MIT
#include <zlib.h>

#include <algorithm>
#include <new>

#include "compression.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kMostGzip = std::size_t{1} << 30;  // bytes a step, which zlib counts with 32 bits

class GzipDecompressor : public Decompressor {
 public:
  GzipDecompressor() {
    constexpr int kWindow = 15 + 16;  // 32 KiB, gzip header and check sum
    if (inflateInit2(&stream_, kWindow) != Z_OK) throw std::bad_alloc();
  }
  ~GzipDecompressor() override { inflateEnd(&stream_); }

  Step step(std::string_view& packed, std::span<char> out) override {
    const std::size_t offered = std::min(packed.size(), kMostGzip), room = std::min(out.size(), kMostGzip);
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // zlib's interface; only read
    stream_.avail_in = static_cast<uInt>(offered);
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(room);
    const int status = inflate(&stream_, Z_NO_FLUSH);
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    packed.remove_prefix(offered - stream_.avail_in);
    Step step{room - stream_.avail_out, status == Z_STREAM_END, {}};
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR)
      step.damage = stream_.msg ? stream_.msg : "check sum";
    return step;
  }
  void restart() override { inflateReset(&stream_); }

 private:
  z_stream stream_ = {};
};

}  // namespace

std::unique_ptr<Decompressor> gzip_decompressor() { return std::make_unique<GzipDecompressor>(); }

}  // namespace gyrobudget::inline v0::log
