// SPDX-License-Identifier: MIT
// Inside navigation: one run of a filter over a recording.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

namespace gyrobudget::inline v0::navigation::detail {

/// What navigate() does, once its input is checked.
[[nodiscard]] Navigation run(const Scenario& scenario, const Recording& recording);

}  // namespace gyrobudget::inline v0::navigation::detail
