// SPDX-License-Identifier: MIT
#include "check.h"

#include <fmt/core.h>

#include <stdexcept>

namespace gyrobudget::inline v0::noise::detail {

void require(bool valid, std::string_view what, double value, std::string_view limit) {
  if (!valid) throw std::invalid_argument(fmt::format("{} is {}; it must be {}", what, value, limit));
}

}  // namespace gyrobudget::inline v0::noise::detail
