// SPDX-License-Identifier: MIT
// Inside navigation: delays of aids, relinearised by running again.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

namespace gyrobudget::inline v0::navigation::detail {

/// run(), repeated with the estimates of time tags added to the stamps until they stand still (navigate.h). A scene
/// without such estimates is run once.
[[nodiscard]] Navigation run_with_time_tags(const Scenario& scenario, const Recording& recording);

}  // namespace gyrobudget::inline v0::navigation::detail
