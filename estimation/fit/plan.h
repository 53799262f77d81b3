// SPDX-License-Identifier: MIT
// How long to record for an accuracy, and what accuracy a length buys.
#pragma once

#include "gyrobudget/noise/sensor.h"

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

/// What a record must tell apart: the terms of a sensor among Q, N, B and K, in this order.
[[nodiscard]] std::vector<noise::Process> planned_terms(const noise::ErrorModel& model);

/// Whether a record of this length holds from 16 to 1e15 samples, which is what a plan is made for.
[[nodiscard]] bool can_plan(double duration_s, double rate_hz);

/// Plans the record of a sensor whose coefficients are expected to be those of the model. With a duration its row is
/// the answer, and with wishes theirs; without either there are rows from half an hour to 300 hours, and the duration
/// that each coefficient needs for 10 %.
/// @throws std::invalid_argument for a model without any of the terms, a wish for a term that it has not, a duration
/// that can_plan refuses, and what duration_for refuses.
[[nodiscard]] Plan plan(const noise::ErrorModel& model, const PlanOptions& options = {});

}  // namespace gyrobudget::inline v0::fit
