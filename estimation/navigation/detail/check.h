// SPDX-License-Identifier: MIT
// Options are refused in one voice.
#pragma once

#include <string_view>

namespace gyrobudget::inline v0::navigation::detail {

/// @throws SetupError "what is value, expected expected" unless `good`.
void require(bool good, std::string_view what, double value, std::string_view expected);

}  // namespace gyrobudget::inline v0::navigation::detail
