// SPDX-License-Identifier: MIT
// A flight seen from its pad, and against its nominal flight.
#pragma once

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/trajectory.h"
#include "gyrobudget/vehicle/flight/fly.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::closed_loop {

/// Nose and belly of a body against the launch plane. The pitch is turned first, in that plane, then the yaw out of it,
/// so that nothing is singular on the pad, where the pitch is 90 degrees.
struct LaunchAttitude {
  double pitch = 0;  ///< of the nose's projection on the launch plane above the horizon [rad]
  double yaw = 0;    ///< of the nose out of the launch plane, right positive [rad]
  double roll = 0;   ///< right side down positive [rad]
};
/// With C_lb the turn from the body to downrange, right, down, C_lb = C_y(pitch) C_z(yaw) C_x(roll).
/// @param C_launch downrange, crossrange (left), up as columns in the axes of e
[[nodiscard]] LaunchAttitude launch_attitude(const Eigen::Quaterniond& q_eb, const Eigen::Matrix3d& C_launch);

/// An instant seen from the pad.
struct FromPad {
  double t = 0;                                        ///< [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< downrange, crossrange (left), up [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  earth::Geodetic place;
  LaunchAttitude attitude;
};

/// Differences in the launch plane's axes: downrange, crossrange (left), up.
struct Difference {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d attitude = Eigen::Vector3d::Zero();  ///< rotation vector [rad]
};

/// The launch plane's axes at the pad, and the nominal flight at any time. It keeps a copy of what it needs.
class FlightFrame {
 public:
  /// @param plan the pad and the azimuth of the launch plane
  /// @param nominal that the plan's flight is compared with (Study::nominal)
  FlightFrame(const flight::Plan& plan, const flight::FlightRecord& nominal);

  [[nodiscard]] FromPad from_pad(const flight::FlightPoint& point) const;
  [[nodiscard]] Difference difference(const earth::Pose& pose, const earth::Pose& less) const;
  /// Of navigation: truth less what it tells.
  [[nodiscard]] Difference navigation_error(const flight::FlightPoint& point) const;
  /// From the nominal flight at the same time; none after its end, nor of a nominal flight of fewer than 5 points but
  /// at its end.
  [[nodiscard]] std::optional<Difference> departure(const flight::FlightPoint& point) const;

 private:
  earth::LocalFrame launch_;
  double end_;  ///< of the nominal flight [s]
  earth::Pose at_end_;
  std::optional<earth::Trajectory> path_;
};

}  // namespace gyrobudget::inline v0::closed_loop
