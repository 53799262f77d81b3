// SPDX-License-Identifier: MIT
// Inside io: the part of a scene that flies.
#pragma once

#include "gyrobudget/io/scene_file.h"
#include "gyrobudget/io/yaml_reader.h"

#include <filesystem>

namespace gyrobudget::inline v0::io {

/// Reads `flight:` of a scene in its folder. Site, azimuth and end of the scene are not in it: see place_flight().
/// @throws InputError with the place of what is wrong.
[[nodiscard]] FlightSource read_flight(const YamlReader&, const YAML::Node&,
                                       const std::filesystem::path& folder);

/// Puts a flight on the scene's site and azimuth, to the scene's end where that is given.
void place_flight(FlightSource&, const navigation::Scenario&);

}  // namespace gyrobudget::inline v0::io
