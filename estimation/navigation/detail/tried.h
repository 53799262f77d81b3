// SPDX-License-Identifier: MIT
// Inside navigation: runs that only ask what if: over the first part of a log, and in a hurry.
#pragma once

#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/scenario.h"

namespace gyrobudget::inline v0::navigation::detail {

inline constexpr double kMostSeconds = 200;
inline constexpr std::size_t kMostSteps = 40'000;

/// The first kMostSeconds of the log from the alignment's start on, at most kMostSteps intervals; all fixes.
[[nodiscard]] Recording beginning(const Scenario& scenario, const Recording& whole);

/// The scene without recovery, smoothing and references, one solution, the covariance moved ten times a second.
[[nodiscard]] Scenario quick(Scenario scenario);

}  // namespace gyrobudget::inline v0::navigation::detail
