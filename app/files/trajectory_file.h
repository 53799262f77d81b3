// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>
#include <limits>
#include <string>

namespace gyrobudget::inline v0::files {

/// A trajectory by name with its options, or from a file.
///
/// **By name**: `ascent`, `static`, `cruise:speed=900km/h,duration=600`: a path of earth/paths.h, `:` and
/// `key=value`s of its options, parted by commas. A value may carry its unit; without one it is in metres,
/// seconds, m/s, m/s^2, Hz, degrees or deg/s. Keys are the names of the options there; besides
/// - `site=alcantara` is the named place (cruise: its latitude and longitude), as are `latitude`,
///   `longitude`, `height`;
/// - static has `yaw`, `pitch`, `roll` (against north, east, down) and `spin_x`, `spin_y`, `spin_z`;
/// - static, cruise and climb have the vibration's `coning_angle`, `coning_frequency`, `sculling_angle`,
///   `sculling_acceleration` and `sculling_frequency`.
///
/// A name always means the path: a file of that name is "./static".
///
/// **From a file**: a CSV as write_trajectory makes it, or any text that read_log's rules can tell apart,
/// gzip too. Columns are found by name, other columns are passed over:
///
///     time (s),latitude (deg),longitude (deg),height (m),q_w,q_x,q_y,q_z
///     time (s),latitude (deg),longitude (deg),height (m),yaw (deg),pitch (deg),roll (deg)
///
/// q_nb or yaw, pitch, roll turn the body (forward, right, down) against north, east, down at its place; a
/// quaternion's length need not be 1 to more than 1 %. The trajectory is earth::through_samples of it, so
/// times may be apart as they like and time 0 is that of the first row; times beyond 1e6 s (of a day, of an
/// epoch) are read as whole nanoseconds.
///
/// @throws std::invalid_argument for a name whose options are wrong, with those there are and the nearest
/// one; what is neither a name nor a file that can be read is InputError, as is a file that holds no
/// trajectory, with its line.
[[nodiscard]] earth::Trajectory read_trajectory(const std::string& name_or_path);

/// The built-in paths with their keys, one line each, for help texts.
[[nodiscard]] std::string trajectory_names();

/// How write_trajectory gives the attitude.
enum class AttitudeForm { quaternion, euler };

struct TruthOptions {
  double rate_hz = 100;
  AttitudeForm attitude = AttitudeForm::quaternion;
  std::string comment = {};                                   ///< one line on top; empty: none
  double duration = std::numeric_limits<double>::infinity();  ///< [s], cut to the trajectory's
};

/// Writes a trajectory as CSV at times k / rate_hz, from 0 to the last within the duration:
///
///     time (s),latitude (deg),longitude (deg),height (m),
///     velocity_north (m/s),velocity_east (m/s),velocity_down (m/s),q_w (1),q_x (1),q_y (1),q_z (1)
///
/// or with `yaw (deg),pitch (deg),roll (deg)` in place of the quaternion, which has q_w >= 0. Numbers have
/// the digits that give back the same double; latitude and longitude resolve 1 nm.
/// @throws OutputError, and std::invalid_argument where rate_hz is not positive and finite.
void write_trajectory(const std::string& path, const earth::Trajectory&, const TruthOptions&);

/// How many whole intervals of 1/rate_hz a duration [s] holds; one that misses a whole number by its rounding
/// counts.
[[nodiscard]] std::uint64_t whole_intervals(double duration, double rate_hz);

}  // namespace gyrobudget::inline v0::files
