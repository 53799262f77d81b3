// SPDX-License-Identifier: MIT
#include "findings.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <utility>

namespace gyrobudget::inline v0::log {

void Findings::add(std::string text) {
  constexpr std::size_t kShown = 8;
  if (texts_.size() < kShown) {
    texts_.push_back(std::move(text));
  } else {
    ++more_;
  }
}

std::vector<std::string> Findings::texts() const {
  std::vector<std::string> all = texts_;
  if (more_ > 0) all.push_back(fmt::format("there are {} more findings like these", text::count_text(more_)));
  return all;
}

}  // namespace gyrobudget::inline v0::log
