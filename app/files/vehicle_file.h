// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/vehicle/flight/vehicle.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::files {

/// One number, or table, of a vehicle file and what the file says of it.
struct VehicleNumber {
  std::string key;                       ///< "lift_off_mass", "actuator.frequency"
  std::string value;                     ///< as written: "28 t", of a table "0: 7 m, 1: 10 m"
  std::optional<flight::Origin> origin;  ///< none: the file does not state it
  std::string reason;                    ///< empty where the origin is not stated
};

/// What a vehicle file does not give, and what that means.
struct VehicleOmission {
  std::string_view key;
  std::string_view meaning;  ///< "no back-pressure"
};

struct VehicleFile {
  flight::Vehicle vehicle;
  std::vector<VehicleNumber> numbers;     ///< in the order of Vehicle's members
  std::vector<VehicleOmission> left_out;  ///< so too
};

/// "sourced", "derived", "assumed", "not stated".
[[nodiscard]] std::string_view to_string(const std::optional<flight::Origin>&);

/// Reads a vehicle (YAML): every value with its unit, and where it comes from.
///
///     name: VLM-1, first stage
///     lift_off_mass: {value: 28 t, origin: sourced, reason: published for the VLM-1}
///     centre_of_mass: {points: [[0, 7 m], [1, 10 m]], origin: assumed, reason: arm of the gimbal}
///     actuator: {frequency: 4 Hz, delay: 10 ms, origin: assumed, reason: usual of flexible nozzles}
///     burn_time: 83 s                      # for a quick try: its origin is not stated
///
/// `based_on: other.yaml` takes over what this file does not give; paths start at the file's folder. Every
/// key, with an example and what it is when left out, stands in vehicle_help().
///
/// @throws InputError with file:line:column, what was found, what was expected; an unknown key gets the
/// nearest name, and what Vehicle::check refuses the place of the number.
[[nodiscard]] VehicleFile read_vehicle(const std::string& path);

/// All keys of a vehicle as one commented example, which read_vehicle reads.
[[nodiscard]] std::string_view vehicle_help();

}  // namespace gyrobudget::inline v0::files
