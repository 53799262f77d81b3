// SPDX-License-Identifier: MIT
// Datasheets as reports have them: the numbers of estimation/calibration with the words that go with them.
#pragma once

#include "gyrobudget/estimation/calibration/sensor_model.h"
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

/// What begins each sentence of spoilt_texts.
inline constexpr std::string_view kNotYet = "do not use these numbers yet: ";
/// One sentence for each axis whose fit took for noise what is none: "do not use these numbers yet: gyro_x holds steps
/// that the fit took for noise". For who must be stopped: stderr, and the warnings of a sensor file.
[[nodiscard]] std::vector<std::string> spoilt_texts(const calibration::Datasheet& sheet);
[[nodiscard]] std::vector<std::string> spoilt_texts(const calibration::TypeDatasheet& sheet);

/// What the comment at the head of a sensor file tells.
struct Provenance {
  const calibration::SensorSummary& summary;
  std::string_view command;
  /// What the file holds in the end, for what it does not state.
  const noise::SensorModel& written;
};
/// The comment of a sensor file: how it was made, from what, which axes differ, what is not resolved, what was found in
/// the record and is not masked, which axes have no answer, and what no log at rest tells. Its last line is
/// sensor_file::kEndOfComment.
[[nodiscard]] std::string provenance(const calibration::Datasheet& sheet, const Provenance& of);
[[nodiscard]] std::string provenance(const calibration::TypeDatasheet& sheet, const Provenance& of);

}  // namespace gyrobudget::inline v0::report
