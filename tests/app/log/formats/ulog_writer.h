// SPDX-License-Identifier: MIT
// Writes ULog byte by byte.
#pragma once

#include <cstdint>
#include <string>

#include "recorded.h"

namespace gyrobudget::app_tests {

class UlogWriter {
 public:
  explicit UlogWriter(char version = 1) {
    bytes_ = std::string("\x55\x4c\x6f\x67\x01\x12\x35", 7) + version + packed(std::uint64_t{1000});
  }
  UlogWriter& message(char type, const std::string& content) {
    bytes_ += packed(static_cast<std::uint16_t>(content.size())) + type + content;
    return *this;
  }
  UlogWriter& flags(std::uint8_t incompatible, std::uint64_t appended = 0, std::uint64_t second = 0) {
    return message('B', std::string(8, '\0') + static_cast<char>(incompatible) + std::string(7, '\0') +
                            packed(appended, second, std::uint64_t{0}));
  }
  UlogWriter& format(const std::string& text) { return message('F', text); }
  UlogWriter& subscribe(std::uint16_t id, const std::string& name, std::uint8_t instance = 0) {
    return message('A', packed(instance) + packed(id) + name);
  }
  UlogWriter& data(std::uint16_t id, const std::string& content) { return message('D', packed(id) + content); }
  UlogWriter& raw(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

inline const std::string kUlogSync = std::string("\x08\x00\x53\x2f\x73\x13\x20\x25\x0c\xbb\x12", 11);

}  // namespace gyrobudget::app_tests
