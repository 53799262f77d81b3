// SPDX-License-Identifier: MIT
// Numbers and strings at the front of bytes that a stranger wrote.
#pragma once

#include <cstdint>
#include <string_view>

#include "number_type.h"

namespace gyrobudget::inline v0::log {

/// Takes little-endian numbers and strings off the front. What lies past the end is zero or empty, and from then on
/// ok() is false: a record is read to its end and judged once.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <class Number>
  Number number() {
    const std::string_view taken = bytes(sizeof(Number));
    return taken.size() == sizeof(Number) ? load<Number>(taken.data()) : Number{};
  }
  std::string_view bytes(std::uint64_t count) {
    if (count > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(count));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  /// A string, a map or an array behind its length in bytes.
  std::string_view prefixed() { return bytes(number<std::uint32_t>()); }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace gyrobudget::inline v0::log
