// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::log {

/// What was found while reading, for people: the first of each sort, and how many more there were. A damaged file can
/// give a finding for each of its bytes.
class Findings {
 public:
  /// Something of which each case is worth a look, as long as there are few.
  void add(std::string text);
  /// The findings, and that there were more.
  [[nodiscard]] std::vector<std::string> texts() const;

 private:
  std::vector<std::string> texts_;
  std::int64_t more_ = 0;
};

}  // namespace gyrobudget::inline v0::log
