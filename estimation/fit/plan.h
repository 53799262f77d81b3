// SPDX-License-Identifier: MIT
// How long to record for an accuracy, and what accuracy a length buys.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace gyrobudget::inline v0::fit {

/// The fit reaches the Cramer-Rao bound below this relative standard deviation; above it the bound is a lower bound.
inline constexpr double kBoundReached = 0.10;

struct PlanOptions {
  double rate_hz = 100;
  std::optional<double> duration_s;  ///< what this length buys
  struct Wish {
    noise::Term term = noise::Term::flicker;
    double relative_std = 0.1;  ///< one sigma
  };
  std::vector<Wish> wishes;  ///< how long for each of these
  std::size_t axis = 0;      ///< 0, 1, 2 for x, y, z of the sensor
};

/// Accuracies are one sigma, relative to the coefficient, and Cramer-Rao bounds; see kBoundReached.
struct Plan {
  struct Term {
    noise::Term term = noise::Term::white;
    double value = 0;  ///< coefficient, SI
  };
  struct Row {
    double duration_s = 0;
    std::vector<double> relative_std;  ///< one for each of `terms`
  };
  struct Answer {
    noise::Term term = noise::Term::white;
    double relative_std = 0;
    double duration_s = 0;  ///< infinite: no record of 1e15 samples would do
  };
  std::vector<Term> terms;
  std::vector<Row> rows;
  std::vector<Answer> answers;
};

/// What a record must tell apart: the terms of a sensor's axis among Q, N, B and K, in this order.
[[nodiscard]] std::vector<noise::Process> planned_terms(const noise::ErrorModel& model, std::size_t axis = 0);

/// Whether a record of this length holds from 16 to 1e15 samples, which is what a plan is made for.
[[nodiscard]] bool can_plan(double duration_s, double rate_hz);

/// Plans the record of a sensor's axis whose coefficients are expected to be those of the model. With a duration its
/// row is the answer, and with wishes theirs; without either there are rows from half an hour to 300 hours, and the
/// duration that each coefficient needs for 10 %.
/// @throws std::invalid_argument for an axis without any of the terms, a wish for a term that it has not, a duration
/// that can_plan refuses, and what duration_for refuses.
[[nodiscard]] Plan plan(const noise::ErrorModel& model, const PlanOptions& options = {});

/// Plans for the axes of a sensor.
struct AxesPlan {
  struct Part {
    std::vector<std::size_t> axes;  ///< that are alike
    Plan plan;
  };
  std::vector<Part> parts;  ///< one where all are alike; axes without any of the terms have none
  Plan all;                 ///< of the same record: each term as the axis that knows it worst does
};

/// Plans one record for all axes of a sensor; PlanOptions::axis does nothing here.
/// @throws std::invalid_argument as plan() does, where no axis has any of the terms or the wished for one.
[[nodiscard]] AxesPlan plan_axes(const noise::ErrorModel& model, const PlanOptions& options = {});

}  // namespace gyrobudget::inline v0::fit
