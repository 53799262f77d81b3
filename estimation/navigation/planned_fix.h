// SPDX-License-Identifier: MIT
// Fixes before they are taken: when, of what, and what a filter makes of them along a true trajectory.
#pragma once

#include <utility>
#include <variant>
#include <vector>

#include "aiding.h"
#include "error_state.h"
#include "errors.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::navigation {

/// A fix that will be taken, with its true values: residual zero.
struct PlannedFix {
  double time = 0;  ///< [s] on the scene's clock, which is below 0 on the pad
  std::variant<PositionFix, VelocityFix, HeightFix, AttitudeFix> fix;
};

/// Rows of a planned fix for a model's terms, at the true motion; the residual is zero.
[[nodiscard]] Measurement linearise(const PlannedFix& planned, const earth::Motion& truth,
                                    const ErrorStateModel& model);
/// A start that is taken from a fix is wrong as the fix is: x = by_terms s + v, s the errors of the aid, cov v = white.
/// A position is that of the IMU, the lever arm taken off; taken off in an attitude wrong by psi it adds
/// by_attitude psi.
struct StartFromFix {
  Eigen::Matrix<double, kCoreStates, Eigen::Dynamic> by_terms;
  Eigen::Matrix<double, kCoreStates, 3> by_attitude = Eigen::Matrix<double, kCoreStates, 3>::Zero();
  CoreMatrix white = CoreMatrix::Zero();
};
/// @throws std::invalid_argument for a height, which gives no start.
[[nodiscard]] StartFromFix start_from(const PlannedFix& planned, const earth::Motion& truth,
                                      const ErrorStateModel& model);
/// Number of the aid that takes it.
[[nodiscard]] int aid_of(const PlannedFix& planned);

/// Fixes at `interval` from `first` to `last`, those in outages left out, with the truth of the trajectory.
struct FixPlan {
  double first = 0, last = 0, interval = 1;        ///< [s]
  std::vector<std::pair<double, double>> outages;  ///< from, to, both included [s]
};
/// first + k interval for k = 0, 1, ... up to `last`, which counts where rounding puts a fix up to 1e-9 of an interval
/// beyond; those within an outage are left out [s]. None where last < first.
/// @throws SetupError for an interval that is not above 0 and finite, and more than 1e6 fixes.
[[nodiscard]] std::vector<double> fix_times(const FixPlan& plan);

}  // namespace gyrobudget::inline v0::navigation
