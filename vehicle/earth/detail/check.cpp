// SPDX-License-Identifier: MIT
#include "check.h"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::earth::detail {
namespace {

void require(bool valid, double value, std::string_view what, std::string_view unit, std::string_view limit) {
  if (!valid) throw std::invalid_argument(fmt::format("{} is {} {}; it must be {}", what, value, unit, limit));
}

}  // namespace

void check_finite(double value, std::string_view what, std::string_view unit) {
  require(std::isfinite(value), value, what, unit, "finite");
}

void check_positive(double value, std::string_view what, std::string_view unit) {
  require(value > 0 && std::isfinite(value), value, what, unit, "positive and finite");
}

void check_not_negative(double value, std::string_view what, std::string_view unit) {
  require(value >= 0 && std::isfinite(value), value, what, unit, "0 or more, and finite");
}

void check_position(const Geodetic& g) {
  require(std::abs(g.latitude) <= std::numbers::pi / 2, g.latitude, "latitude", "rad", "from -pi/2 to pi/2");
  check_finite(g.longitude, "longitude", "rad");
  check_finite(g.height, "height", "m");
}

void check_unit(const Eigen::Quaterniond& q, std::string_view what) {
  constexpr double kOffUnit = 1e-6;
  require(std::abs(q.norm() - 1) <= kOffUnit, q.norm(), fmt::format("norm of {}", what), "", "1 to 1e-6");
}

}  // namespace gyrobudget::inline v0::earth::detail
