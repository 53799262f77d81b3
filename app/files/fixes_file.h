// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/scenario.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::files {

/// The fixes of one device as CSV that a scene reads: time (s) and, as it measures them, latitude (deg), longitude
/// (deg), height (m); velocity_north (m/s), velocity_east, velocity_down; q_w (1) ... q_z of the body against north,
/// east, down. One row a time; what is not measured then is empty.
struct DeviceFixes {
  std::string device;                               ///< "gnss"
  std::vector<navigation::Aid::Kind> kinds;         ///< what it measures
  std::vector<std::vector<navigation::Fix>> fixes;  ///< of each kind, ascending
};
[[nodiscard]] std::string fixes_csv(const DeviceFixes&);

/// What each device of a scenario measures along a trajectory, in the order of its aids: those of one device stand one
/// behind the other and are named DEVICE.WHAT. Aids that are not used, and rests, measure nothing.
[[nodiscard]] std::vector<DeviceFixes> simulated_devices(const navigation::Scenario&, const earth::Trajectory&,
                                                         std::uint64_t seed, std::uint64_t run);

}  // namespace gyrobudget::inline v0::files
