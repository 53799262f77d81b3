// SPDX-License-Identifier: MIT
// Datasheets as reports have them: the numbers of estimation/calibration with the words that go with them.
#pragma once

#include "gyrobudget/estimation/calibration/several.h"

#include <string>
#include <string_view>
#include <vector>

#include "result.h"

namespace gyrobudget::inline v0::report {

/// A datasheet with its advice.
/// @param notes    how the log was read, one sentence each
/// @param command  the command line, to repeat it
[[nodiscard]] LogResult calibration_result(const calibration::Datasheet& sheet, std::vector<std::string> notes,
                                           std::string command);
/// @param notes  of each record
[[nodiscard]] RunsResult runs_result(const calibration::TypeDatasheet& sheet,
                                     std::vector<std::vector<std::string>> notes, std::string command);

/// What to know and do next, in plain words, most important first: what the record holds beside noise, with its times
/// and what can be done, and which coefficients want a longer record.
[[nodiscard]] std::vector<std::string> advice(const calibration::AxisDatasheet& axis,
                                              const calibration::Datasheet& sheet);

/// How to mend what makes a record unusable, behind the message of the exception.
[[nodiscard]] std::string_view mend(calibration::Unusable::Reason reason);

/// The comment of a sensor file: how it was made, from what, and what is not resolved.
[[nodiscard]] std::string provenance(const calibration::Datasheet& sheet, std::string_view command);
[[nodiscard]] std::string provenance(const calibration::TypeDatasheet& sheet, std::string_view command);

}  // namespace gyrobudget::inline v0::report
