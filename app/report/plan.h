// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <string>
#include <vector>

namespace gyrobudget::inline v0::report {

/// What `plan` answers for a gyro: accuracies are one sigma, relative, and bounds (Cramer-Rao): the fit reaches them
/// below about 10 %, above that they are lower bounds.
struct PlanRow {
  double duration_s = 0;
  std::vector<double> relative_std;  ///< one for each of Plan::terms
};

struct PlanTerm {
  noise::Term term = noise::Term::white;
  double value = 0;  ///< SI
};

struct PlanAnswer {
  noise::Term term = noise::Term::white;
  double relative_std = 0;
  double duration_s = 0;  ///< infinite: no record would do
};

struct Plan {
  std::string sensor;
  std::string command;
  double rate_hz = 0;
  std::vector<PlanTerm> terms;
  std::vector<PlanRow> rows;
  std::vector<PlanAnswer> answers;
};

[[nodiscard]] std::string plan_table(const Plan&);
/// The fields are described by schema/plan-1.schema.json, which is installed with the program.
[[nodiscard]] std::string plan_json(const Plan&);

}  // namespace gyrobudget::inline v0::report
