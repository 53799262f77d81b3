// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/scenario.h"
#include "gyrobudget/vehicle/earth/trajectory.h"
#include "gyrobudget/vehicle/flight/dispersion.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vehicle_file.h"

namespace gyrobudget::inline v0::files {

/// An instant as people write it.
struct ClockEpoch {
  std::int64_t ns = 0;  ///< since 1970, without leap seconds
  std::string scale;    ///< "GPST", "UTC", "JST"; empty: not said
};

/// Where an IMU log is and how it is to be read.
struct ImuSource {
  std::string path;
  std::optional<std::string> topic;            ///< of a recording; unset: its only IMU
  std::map<std::string, std::string> columns;  ///< "gyro_x" -> "wx (deg/s)"
  std::optional<double> rate_hz;               ///< where there is no time column
  std::array<int, 3> axis{0, 1, 2};            ///< which axis of the log is forward, right, down
  std::array<int, 3> sign{1, 1, 1};
  bool instants = false;  ///< rates hold at their stamps; else they are means over the interval
  navigation::StampAt stamp = navigation::StampAt::end;
  std::optional<ClockEpoch> epoch;  ///< what its time 0 is
};

/// Where the fixes of an aid are.
struct AidSource {
  std::string path;                  ///< empty: not recorded
  std::optional<std::string> topic;  ///< of a recording; unset: its only GNSS receiver
  std::map<std::string, std::string> columns;
  bool sigma_from_file = false;  ///< Fix::sigma
  std::optional<double>
      geoid_separation;         ///< heights are over the geoid, and this is that of it over the ellipsoid [m]
  std::vector<double> quality;  ///< fixes that are used; empty: all that the file's format calls measured
};

/// What flies in place of a trajectory.
struct FlightSource {
  flight::Plan plan;
  flight::Dispersion dispersion;
  /// The vehicle's file, with where its numbers come from; what flies is in the plan.
  struct Vehicle {
    std::string path;
    std::vector<VehicleNumber> numbers;
    std::vector<VehicleOmission> left_out;
  } vehicle;
};

/// A scene with the places of its data.
struct SceneFile {
  std::string path;  ///< of the scene itself
  navigation::Scenario scenario;
  std::string sensor;                    ///< path of the sensor file; empty: ideal
  std::optional<double> sensor_rate_hz;  ///< of the samples whose sigmas it gives (sensor_file::ReadOptions)
  std::vector<std::string> sensor_warnings, sensor_notes;  ///< of that file (sensor_file::SensorFile)
  /// The scene's own epoch of any sensor, in place of the sensor file's [s].
  std::optional<double> powered_on_before, calibrated_over;
  std::string trajectory;  ///< as read_trajectory takes it; empty: none
  std::optional<FlightSource> flight;
  std::optional<ImuSource> imu;
  std::vector<AidSource> aids;  ///< one for each of scenario.aids
};

/// Reads a scene (YAML), a test card: where, what moves, with which sensors and aids, what is asked. Every value
/// has its unit. Left out is what the scene does not need. Times are those of the IMU log's clock, or, where that
/// counts from an epoch (beyond 1e6 s), after its first sample; or after the start of the trajectory. Files are looked
/// for from the scene file's folder on, data in `data_folder` where that is given. Logs are texts or recordings
/// (log/recording.h), known by their content.
///
///     site: alcantara
///     trajectory: ascent
///     sensor: {file: mems.yaml, powered_on_before: 10 min}
///     aids:
///       gnss: {rate: 1 Hz, position: [2 m, 2 m, 4 m], outages: [[60 s, 120 s]]}
///
/// Every key, with an example and what it is when left out, stands in scene_help().
///
/// @throws InputError with file:line:column, what was found, what was expected; an unknown key gets the nearest
/// name. The sensor file is read with it; logs are not.
[[nodiscard]] SceneFile read_scene(const std::string& path, const std::string& data_folder = {});

/// The trajectory of a scene that plans one: by name, from a file, or of its flight as planned, with perfect
/// navigation and without dispersion; a flight that ends early has a short one.
/// @throws InputError as read_trajectory(), and for a flight that does not last a second.
[[nodiscard]] earth::Trajectory planned_trajectory(const SceneFile&);

/// Whether a path is that of a scene, by its ending.
[[nodiscard]] bool is_scene(std::string_view path);
/// The trajectory of a scene, or one by name or from another file as read_trajectory() takes it.
/// @throws as planned_trajectory() and read_trajectory().
[[nodiscard]] earth::Trajectory scene_or_trajectory(const std::string& name_or_path);

/// Another sensor file, or "ideal", in the same scene, at the scene's epoch. @throws InputError as read_sensor.
void change_sensor(SceneFile&, const std::string& path);

/// All keys of a scene as one commented example, which read_scene reads.
[[nodiscard]] std::string_view scene_help();

/// What was recorded.
struct SceneData {
  navigation::Recording recording;
  std::vector<std::string> notes;  ///< what a person should know of how it was read, one sentence each
};

/// Reads the logs of a scene, texts or recordings. Rows of an aid with a number missing, or that the receiver calls no
/// fix, are passed over, and said; IMU samples with a number missing are bridged (recording.h). Heights are over the
/// ellipsoid: of those over the geoid it has to be known how high that lies, by the file or by the scene. Clocks that
/// one recording gives its streams are one; of others the scale is said where it is known, and never changed.
/// @throws InputError for logs that are missing or malformed, a scene without `imu`, heights over a geoid that nobody
/// tells, and clocks of which one counts from an epoch and the other does not.
[[nodiscard]] SceneData read_recording(const SceneFile&);

}  // namespace gyrobudget::inline v0::files
