// SPDX-License-Identifier: MIT
// Arguments are refused in one voice: what, its value, its limit. All throw std::invalid_argument.
#pragma once

#include <string_view>

namespace gyrobudget::inline v0::noise::detail {

void require(bool valid, std::string_view what, double value, std::string_view limit);
void require_interval(double dt);  ///< positive and finite [s]

}  // namespace gyrobudget::inline v0::noise::detail
