// SPDX-License-Identifier: MIT
#include "check.h"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::noise::detail {

void require(bool valid, std::string_view what, double value, std::string_view limit) {
  if (!valid) throw std::invalid_argument(fmt::format("{} is {}; it must be {}", what, value, limit));
}

void require_interval(double dt) {
  require(dt > 0 && std::isfinite(dt), "sample interval dt", dt, "positive and finite (s)");
}

}  // namespace gyrobudget::inline v0::noise::detail
