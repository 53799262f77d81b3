// SPDX-License-Identifier: MIT
#include "check.h"

#include "gyrobudget/estimation/navigation/errors.h"

#include <fmt/core.h>

namespace gyrobudget::inline v0::navigation::detail {

void require(bool good, std::string_view what, double value, std::string_view expected) {
  if (!good) throw SetupError(fmt::format("{} is {}, expected {}", what, value, expected));
}

}  // namespace gyrobudget::inline v0::navigation::detail
