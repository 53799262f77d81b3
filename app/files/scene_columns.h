// SPDX-License-Identifier: MIT
// The names that a scene's `columns` may map.
#pragma once

#include "gyrobudget/app/log/named_columns.h"

#include <initializer_list>
#include <span>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::files {

[[nodiscard]] const std::vector<std::string>& imu_column_names();
[[nodiscard]] const std::vector<std::string>& aid_column_names();

/// "time" and the names of lists of columns.
[[nodiscard]] std::vector<std::string> column_names(std::initializer_list<std::span<const log::Wanted>> lists);

}  // namespace gyrobudget::inline v0::files
