// SPDX-License-Identifier: MIT
// Monte Carlo of a scene's budget: all of it, and each source alone.
#pragma once

#include <optional>

#include "monte_carlo.h"
#include "scene.h"

namespace gyrobudget::inline v0::budget {

/// Options with what the scene says: vibration, filter, alignment and the errors of its world, which are drawn once a
/// run.
[[nodiscard]] MonteCarlo::Options whole_scene(const BudgetScene& scene, const navigation::Scenario& scenario,
                                              MonteCarlo::Options options);

/// The scene with all that is wrong in it. Of the options runs, seed, imu_interval and progress count; all else is the
/// scene's. A source that was left out (leave_out) is flown all the same but for those of the world.
/// @throws std::invalid_argument as monte_carlo.
[[nodiscard]] MonteCarlo fly(const BudgetScene& scene, const navigation::Scenario& scenario,
                             MonteCarlo::Options options);

/// The scene with one source wrong and all else right. The filter keeps the design of the whole scene, so its gains are
/// those of the budget; its covariance moves in the budget's steps (Timeline). The random numbers of a sensor's error
/// are those it has in fly(), run by run. What is the same in every run (Earth's rate left out) is flown as often as
/// the rest. Nothing for what no flight has: a heading at the start that is in the filter's P0 alone, as an alignment
/// on the pad finds none and none is given.
/// @throws std::invalid_argument as monte_carlo.
[[nodiscard]] std::optional<MonteCarlo> fly_alone(const BudgetScene& scene, const navigation::Scenario& scenario,
                                                  const Source& source, MonteCarlo::Options options);

}  // namespace gyrobudget::inline v0::budget
