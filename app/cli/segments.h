// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/record.h"

#include <string>
#include <vector>

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// The paths of all logs that allan pools. @throws std::invalid_argument for one that is given twice: pooled with
/// itself it would look twice as sure.
[[nodiscard]] std::vector<std::string> logs_of(const AllanArguments&);

/// One or several power-ups of a sensor, from one or several logs, at the rate of the first; says their notes.
/// @throws text::InputError as read_log does, and for a log that does not match the first.
[[nodiscard]] std::vector<allan::Record> read_segments(const AllanArguments&);

}  // namespace gyrobudget::inline v0::cli
