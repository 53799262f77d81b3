// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/log/inspect.h"

#include <string>

// What is in a log, for people and programs.
namespace gyrobudget::inline v0::report {

struct InspectionResult {
  std::string command;
  log::Inspection log;
};

[[nodiscard]] std::string inspection_text(const InspectionResult&);
/// The fields are described by schema/inspect-1.schema.json, which is installed with the program.
[[nodiscard]] std::string inspection_json(const InspectionResult&);

}  // namespace gyrobudget::inline v0::report
