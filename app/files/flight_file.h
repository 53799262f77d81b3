// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/vehicle/flight/fly.h"

#include <string>

namespace gyrobudget::inline v0::files {

/// Writes a flight as CSV, a row a point of the record, as far apart as its first two (a last one off that grid is left
/// out): time, then
///
///     latitude, longitude (deg), height (m), velocity_north, _east, _down (m/s), q_w, q_x, q_y, q_z   of the IMU, in
///     truth downrange, crossrange, up (m)                  from the pad along `azimuth`; crossrange to its left
///     nose_azimuth, nose_elevation (deg)             clockwise from north; above the pad's horizon
///     position_error_east, _north, _up (m), velocity_error_... (m/s), attitude_error_... (deg)   truth less navigation
///     nozzle_pitch, nozzle_yaw, command_pitch, command_yaw (deg)
///     mach (1), dynamic_pressure (Pa), angle_of_attack (deg), airspeed (m/s), thrust (N)
///
/// read_trajectory() reads it as a trajectory.
/// @throws OutputError; std::invalid_argument for a record of fewer than 2 points.
void write_flight(const std::string& path, const flight::FlightRecord&, const earth::Geodetic& site, double azimuth,
                  const std::string& comment);

}  // namespace gyrobudget::inline v0::files
