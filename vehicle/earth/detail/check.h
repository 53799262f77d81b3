// SPDX-License-Identifier: MIT
// Options are checked in one voice: what, its value, its limit, its unit. All throw std::invalid_argument.
#pragma once

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <string_view>

#include <Eigen/Geometry>

namespace gyrobudget::inline v0::earth::detail {

void check_finite(double value, std::string_view what, std::string_view unit);
void check_positive(double value, std::string_view what, std::string_view unit);
void check_not_negative(double value, std::string_view what, std::string_view unit);
void check_position(const Geodetic&);                               ///< finite, latitude within +-90 degrees
void check_unit(const Eigen::Quaterniond&, std::string_view what);  ///< norm within 1e-6 of 1

}  // namespace gyrobudget::inline v0::earth::detail
