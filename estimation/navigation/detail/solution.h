// SPDX-License-Identifier: MIT
// Inside navigation: what a filter holds, as a solution.
#pragma once

#include "gyrobudget/estimation/navigation/aiding.h"
#include "gyrobudget/estimation/navigation/navigate.h"

namespace gyrobudget::inline v0::navigation::detail {

/// At time t [s]; P is of the estimate's model.
[[nodiscard]] Solution solution(const Estimate& estimate, const StateMatrix& P, double t);

}  // namespace gyrobudget::inline v0::navigation::detail
