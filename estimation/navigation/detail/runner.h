// SPDX-License-Identifier: MIT
// Inside navigation: one run of a filter over a recording.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

namespace gyrobudget::inline v0::navigation::detail {

/// @throws SetupError and RecordingError as navigate() does for what does not fit together.
void check_input(const Scenario& scenario, const Recording& recording);

/// What navigate() does, once its input is checked; but delays are not looked for again with stamps that are shifted.
[[nodiscard]] Navigation run(const Scenario& scenario, const Recording& recording);

}  // namespace gyrobudget::inline v0::navigation::detail
