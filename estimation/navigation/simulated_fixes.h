// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>
#include <vector>

#include "recording.h"
#include "scenario.h"

namespace gyrobudget::inline v0::navigation {

/// The fixes that an aid would give along a trajectory, with the errors the scene says it has: white noise from fix
/// to fix, and drawn once a run bias, lever arm and time tag, beside a Gauss-Markov error. Times are 0, 1/rate ...
/// within the aid's validity and outside its outages; stamps count from 0 and, like a real aid's, are off by what the
/// scene says is to be added to them and by the tag that was drawn. Lever arms are about the IMU. A `rest` aid has
/// none.
///
/// Deterministic in (seed, run, number of the aid, clock).
/// @param clock number of the aid whose clock it shares (clock_of): the tag drawn is that one's; below 0: its own
/// @throws SetupError for what check(Aid) refuses.
[[nodiscard]] std::vector<Fix> simulated_fixes(const Aid& aid, int number, const earth::Trajectory& trajectory,
                                               std::uint64_t seed, std::uint64_t run, int clock = -1);

}  // namespace gyrobudget::inline v0::navigation
