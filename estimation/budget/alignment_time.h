// SPDX-License-Identifier: MIT
// How long a scene must stand before it starts, for a wanted position.
#pragma once

#include "scene.h"

namespace gyrobudget::inline v0::budget {

struct AlignmentTime {
  bool met = false;
  double duration = 0;  ///< the shortest that meets the limit, else the best [s]
  double sigma = 0;     ///< of position over the axes with it [m]
};

/// For scenes that align themselves: the duration of SelfAlignment at which the root sum square of position over the
/// columns of `axes` (ECEF) at `at` falls to `limit` [m], all else as in the scene, the sensor's epoch included.
///
/// White noise falls with the duration, 1/f stays and random walk grows, so that there is a best one. Budgets are
/// made anew, by the adjoint, for kShortestAlignment and durations kAlignmentFactor apart up to kLongestAlignment, and
/// between the first of these that meets the limit and the one before it by bisection, to kAlignmentExact. A limit that
/// only durations between two of these meet is missed. Takes a second or two for the shipped ascents.
/// @throws navigation::SetupError for a scene that does not align itself, a limit not above 0, and as budget_scene.
[[nodiscard]] AlignmentTime alignment_time(const navigation::Scenario& scenario, const earth::Trajectory& trajectory,
                                           const BudgetQuestion& question, double at,
                                           const Eigen::Matrix<double, 3, Eigen::Dynamic>& axes, double limit);
inline constexpr double kShortestAlignment = 10;   ///< [s]
inline constexpr double kLongestAlignment = 3600;  ///< [s]
inline constexpr double kAlignmentFactor = 1.5, kAlignmentExact = 0.01;

}  // namespace gyrobudget::inline v0::budget
