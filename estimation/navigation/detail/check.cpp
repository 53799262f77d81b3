// SPDX-License-Identifier: MIT
#include "check.h"

#include <fmt/core.h>

#include <stdexcept>

namespace gyrobudget::inline v0::navigation::detail {

void require(bool good, std::string_view what, double value, std::string_view expected) {
  if (!good) throw std::invalid_argument(fmt::format("{} is {}, expected {}", what, value, expected));
}

}  // namespace gyrobudget::inline v0::navigation::detail
