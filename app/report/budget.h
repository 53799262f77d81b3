// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/budget/study.h"

#include <string>
#include <vector>

// An error budget as people and programs want it. Local axes are east, north, up at the site, or where the scene has
// none at the place reached; downrange and crossrange (left of it) lie in the launch plane's frame; attitude errors are
// rotation vectors in east, north, up.
namespace gyrobudget::inline v0::report {

/// The budget of one scene with one sensor.
struct BudgetResult {
  std::string scene;                    ///< its path
  std::string name;                     ///< as it calls itself
  std::string sensor;                   ///< path of the sensor file; empty: ideal
  std::string command;                  ///< as typed
  std::string limit;                    ///< the limit that was asked for, as typed: "crossrange < 10 m"
  std::vector<std::string> not_stated;  ///< by the sensor file (sensor_words.h)
  std::vector<std::string>
      notes;  ///< how the sensor was read and how what moves came about; those of the study come behind (budget_notes)
  budget::Study study;
};

/// Tables for the terminal; several results side by side below the first's.
[[nodiscard]] std::string budget_text(const std::vector<BudgetResult>& results);
/// The fields are described by schema/budget-1.schema.json, and those of several sensors by
/// schema/budgets-1.schema.json; both are installed with the program. A ratio is null where its axis has below a
/// hundredth of the total's variance, or less than second order may add. Bands are 99 %.
[[nodiscard]] std::string budget_json(const std::vector<BudgetResult>& results);
/// One HTML page that opens offline.
[[nodiscard]] std::string budget_page(const std::vector<BudgetResult>& results);

}  // namespace gyrobudget::inline v0::report
