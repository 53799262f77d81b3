// SPDX-License-Identifier: MIT
// How the temperature goes, as the command line and scenes say it.
#pragma once

#include "gyrobudget/noise/temperature.h"

#include <string>

namespace gyrobudget::inline v0::files {

/// - `35 degC`: the same throughout;
/// - `from=20 degC,to=45 degC,time_constant=10 min`: of something that was switched on;
/// - otherwise the path of a table with the columns time and temperature (a unit in brackets, degC where it has none),
///   as logs have them.
/// @throws std::invalid_argument for words that are none of these, or wrong in them; InputError for the table.
[[nodiscard]] noise::TemperatureProfile temperature_profile(const std::string& text);

}  // namespace gyrobudget::inline v0::files
