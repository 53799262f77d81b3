// SPDX-License-Identifier: MIT
// The names that a scene's `columns` may map.
#pragma once

#include <string>
#include <vector>

namespace gyrobudget::inline v0::files {

[[nodiscard]] const std::vector<std::string>& imu_column_names();
[[nodiscard]] const std::vector<std::string>& aid_column_names();

}  // namespace gyrobudget::inline v0::files
