// SPDX-License-Identifier: MIT
// A scene's YAML, with what its sections share.
#pragma once

#include "gyrobudget/app/sensor_file/yaml_reader.h"

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scene_file.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::files {

/// All throw InputError with the place of what is wrong.
class SceneYaml : public sensor_file::YamlReader {
 public:
  /// Paths start at the scene's folder, those of data at `data_folder` where that is not empty.
  SceneYaml(const std::string& path, const std::string& data_folder);

  [[nodiscard]] double time(std::string_view key, const YAML::Node&, sensor_file::Sign) const;  ///< [s]
  /// One for all three, or a list of three.
  [[nodiscard]] Eigen::Vector3d triple(std::string_view key, const YAML::Node&, const noise::Dimension&,
                                       sensor_file::Sign) const;
  /// A date and time of day, and the scale that it is in: 2025-08-28 17:30:39.749 GPST.
  [[nodiscard]] ClockEpoch epoch(std::string_view key, const YAML::Node& node) const;
  /// A path as written, or from the scene's folder.
  [[nodiscard]] std::string path(std::string_view key, const YAML::Node&) const;
  [[nodiscard]] std::string data_path(std::string_view key, const YAML::Node&) const;
  /// Columns of a log by their names here, of which there are `known`.
  [[nodiscard]] std::map<std::string, std::string> columns(const YAML::Node&,
                                                           const std::vector<std::string>& known) const;

 private:
  std::filesystem::path folder_, data_folder_;
};

/// Reads `aids:` into the scene.
void read_aids(const SceneYaml&, const YAML::Node&, SceneFile&);
/// Reads `flight:`. Site, azimuth and end of the scene are not in it: see place_flight().
[[nodiscard]] FlightSource read_flight(const SceneYaml&, const YAML::Node&);
/// Puts a flight on the scene's site and azimuth, to the scene's end where that is given.
void place_flight(FlightSource&, const navigation::Scenario&);

}  // namespace gyrobudget::inline v0::files
