// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/fit/plan.h"

#include <string>
#include <vector>

namespace gyrobudget::inline v0::report {

/// What `plan` answers for a gyro.
struct PlanStudy {
  std::string sensor;  ///< its name
  std::string command;
  double rate_hz = 0;
  fit::AxesPlan plan;
  std::vector<std::string> notes;  ///< of the sensor file
};

[[nodiscard]] std::string plan_table(const PlanStudy&);
/// The fields are described by schema/plan-1.schema.json, which is installed with the program.
[[nodiscard]] std::string plan_json(const PlanStudy&);

}  // namespace gyrobudget::inline v0::report
