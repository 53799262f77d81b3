// SPDX-License-Identifier: MIT
// Trajectories by name.
#pragma once

#include "gyrobudget/vehicle/earth/trajectory.h"

#include <optional>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::files {

/// `cruise:speed=250,duration=600` as read_trajectory has it; empty where the text does not begin with a
/// known name.
/// @throws std::invalid_argument for options that the path does not have or refuses.
[[nodiscard]] std::optional<earth::Trajectory> named_trajectory(const std::string& text);

/// Whether named_trajectory would make one, with its complaints of options that there are not; makes none.
[[nodiscard]] bool is_named_trajectory(const std::string& text);

/// static, cruise, climb, ascent.
[[nodiscard]] std::vector<std::string> trajectory_words();

}  // namespace gyrobudget::inline v0::files
