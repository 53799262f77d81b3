// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/files/vehicle_file.h"
#include "gyrobudget/estimation/closed_loop/study.h"
#include "gyrobudget/vehicle/flight/dispersion.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <span>
#include <string>
#include <vector>

// Closed-loop flights as people and programs want them. Positions and velocities are of the IMU, in the launch plane's
// axes at the pad: downrange, crossrange (left), up; what navigation errs by stands in east, north, up too.
namespace gyrobudget::inline v0::report {

/// One scene flown with one sensor. Where results side by side have the same nominal flight, it, what the vehicle
/// disperses and the margins are told once.
struct FlightResult {
  std::string scene;                                     ///< its path
  std::string name;                                      ///< as it calls itself
  std::string sensor;                                    ///< path of the sensor file; empty: ideal
  std::string command;                                   ///< as typed
  std::string vehicle;                                   ///< path of the vehicle's file; empty: the program's own
  std::vector<files::VehicleNumber> vehicle_numbers;     ///< of that file, with where they come from
  std::vector<files::VehicleOmission> vehicle_left_out;  ///< so too
  flight::Plan plan;
  flight::Dispersion dispersion;
  closed_loop::Study study;
  std::vector<std::string> not_stated;  ///< by the sensor file (sensor_words.h)
  std::vector<std::string> notes;       ///< beside those of the study
};

/// Tables for the terminal: where each flight ends, how far from the nominal one, navigation error by source,
/// dispersion by cause, limits and margins. Of one result at least, as the others.
[[nodiscard]] std::string flight_text(std::span<const FlightResult>);
/// The fields are described by schema/flight-1.schema.json, and those of several flights by
/// schema/flights-1.schema.json; both are installed with the program. Sigmas are one sigma; bands are 99 %; a margin
/// without a limit is null.
[[nodiscard]] std::string flight_json(std::span<const FlightResult>);
/// One HTML page that opens offline.
[[nodiscard]] std::string flight_page(std::span<const FlightResult>);

}  // namespace gyrobudget::inline v0::report
