// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// Refuses, before any work, paths of simulate --trajectory that cannot be.
/// @throws std::invalid_argument, text::OutputError
void check_flight_paths(const SimulateArguments&);

/// The part of a trajectory that is simulated.
struct Flown {
  double duration_s = 0;
  std::uint64_t rows = 0;  ///< of the log: whole intervals without those skipped
};

/// @throws std::invalid_argument where --duration is beyond the trajectory's end, or --skip leaves nothing.
[[nodiscard]] Flown flown_of(const SimulateArguments&, const earth::Trajectory&);

}  // namespace gyrobudget::inline v0::cli
