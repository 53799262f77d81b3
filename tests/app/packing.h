// SPDX-License-Identifier: MIT
// Packs as zlib does.
#pragma once

#include <zlib.h>

#include <string>
#include <string_view>

namespace gyrobudget::app_tests {

/// @param window  15 for zlib's own format, 15 + 16 for gzip, -15 for neither
inline std::string deflated(std::string_view text, int window) {
  z_stream stream = {};
  deflateInit2(&stream, 6, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
  std::string result(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

inline std::string gzip(std::string_view text) { return deflated(text, 15 + 16); }

}  // namespace gyrobudget::app_tests
