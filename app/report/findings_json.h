// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "result.h"

namespace gyrobudget::inline v0::report {

/// Adds `used` and `findings` to an axis: both null for a table of deviations.
void add_findings(nlohmann::ordered_json& out, const AxisResult& axis, double rate_hz);

}  // namespace gyrobudget::inline v0::report
