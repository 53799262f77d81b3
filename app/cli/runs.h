// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/result.h"

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// One log to its datasheet. @throws io::InputError for a log that is too short.
[[nodiscard]] report::LogResult calibrate_log(const CalibrateArguments&);

/// Each of CalibrateArguments::logs to its datasheet, then combined axis by axis; never joined into one series.
/// @throws io::InputError where a log has other columns or another rate than the first.
[[nodiscard]] report::RunsResult calibrate_runs(const CalibrateArguments&);

}  // namespace gyrobudget::inline v0::cli
