// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/scenario.h"

#include <span>
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

}  // namespace gyrobudget::inline v0::files
