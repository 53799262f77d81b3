// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/navigation/innovation_check.h"
#include "gyrobudget/estimation/navigation/navigate.h"
#include "gyrobudget/estimation/navigation/suspects.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// A navigation run as people and programs want it. Local axes are east, north, up; attitude errors are rotation
// vectors in them; body axes are forward, right, down.
namespace gyrobudget::inline v0::report {

struct NavigationResult {
  std::string scene;    ///< its path
  std::string source;   ///< path of the IMU log
  std::string command;  ///< as typed
  navigation::Scenario scenario;
  navigation::Recording recording;
  navigation::Navigation run;
  std::vector<std::string> notes;                      ///< how the data were read
  std::vector<std::string> not_stated;                 ///< by the sensor file (sensor_words.h)
  std::vector<navigation::Suspect> suspects;           ///< of a run that was lost
  std::optional<navigation::NoiseFactors> noise;       ///< where innovations are not as the sigmas say
  std::array<std::string, 3> imu_axes{"x", "y", "z"};  ///< of the log, as the scene takes them: forward, right, down
};

/// An estimated error with its unit for people.
struct StateText {
  std::string name;  ///< "gyro bias x", "ins.attitude mounting y", "gnss.position lever arm x"
  std::string unit;  ///< "deg/h", "ug", "deg"
  double to_si = 1;  ///< SI of one unit
};
[[nodiscard]] StateText state_text(const navigation::Scenario&, const navigation::ErrorTerm&);

/// Unit of what an aid measures.
[[nodiscard]] std::string_view unit_of(navigation::Aid::Kind);

/// Summary for the terminal.
[[nodiscard]] std::string navigation_text(const NavigationResult&);
/// The solution: time (s) on the log's clock, latitude (deg), longitude (deg), height (m), velocity_north (m/s),
/// velocity_east, velocity_down, q_w (1), q_x, q_y, q_z (of q_nb), heading (deg), pitch, roll; one sigma
/// sigma_position_east (m) ..., sigma_velocity_east (m/s) ..., sigma_attitude_east (deg) ...; gyro_bias_x (rad/s),
/// sigma_gyro_bias_x ..., accel_bias_x (m/s^2), sigma_accel_bias_x ..., lost (1): 1 in a span in which the filter was
/// lost, where nothing may be used. A trajectory for --trajectory, and for other
/// scenes.
[[nodiscard]] std::string solution_csv(const NavigationResult&);
/// One line for each fix: time (s), aid, status (used, gated, not_finite), nis, dof, and residual and sigma of each
/// component in SI.
[[nodiscard]] std::string innovations_csv(const NavigationResult&);
/// The fields are described by schema/navigation-1.schema.json, which is installed with the program. "nis"."mean" is
/// over the aids' degrees of freedom: 1 where the sigmas are right; of one aid it is the mean NIS, to lie between low
/// and high.
[[nodiscard]] std::string navigation_json(const NavigationResult&);
/// One HTML page that opens offline.
[[nodiscard]] std::string navigation_page(const NavigationResult&);

}  // namespace gyrobudget::inline v0::report
