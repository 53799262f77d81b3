// SPDX-License-Identifier: MIT
// What gpsd reports: one JSON object a line, as gpspipe -w and gpsd's own clients log it.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

/// A line that begins with {"class":"...".
[[nodiscard]] bool is_gpsd_json(std::string_view head);

/// A stream for each device, "TPV" or "TPV /dev/ttyACM0", of its TPV reports (time, position, velocity). Its clock is
/// UTC, the report's own `time`; reports without one are left out. Fields, NaN where a report has none:
///
/// - latitude, longitude [deg], height [m] (altHAE, over the ellipsoid), height_over_geoid [m] (altMSL, or alt of old
///   versions), quality (mode: 1 none, 2 without a height, 3 with);
/// - velocity_north, _east, _down [m/s]; or speed [m/s], course [deg] (`track`, from true north, NaN where it stands;
///   never `magtrack`) and velocity_up [m/s] (climb);
/// - position_sigma_east, _north, _up [m] (epx, epy, epv), velocity_sigma_horizontal, _up [m/s] (eps, epc): gpsd does
///   not say at which confidence.
///
/// Source: gpsd_json(5) of gpsd 3.22. Lines that are no JSON are left out, and said.
[[nodiscard]] std::unique_ptr<Recording> open_gpsd_json(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
