// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "control.h"
#include "fly.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::flight {

/// A place and velocity to be at.
struct Waypoint {
  double t;                ///< [s]
  Eigen::Vector3d p_eb_e;  ///< of the IMU [m]
  Eigen::Vector3d v_eb_e;  ///< [m/s]
};
/// Those of a recorded flight, as it was in truth: a nominal one is the reference of the others.
[[nodiscard]] std::vector<Waypoint> waypoints(const FlightRecord& record);

struct GuidanceOptions {
  double frequency = 0.2;  ///< of the closed guidance loop [rad/s]: far below that of attitude
  double damping = 1;
  double angle_limit = 5 * earth::kDegree;  ///< the nose leaves the program by no more [rad]
};

/// Follows a trajectory, not an attitude alone: the nose leaves its program by the angle at which the nominal
/// thrust gives the acceleration
///   a = w^2 (p_ref - p) + 2 z w (v_ref - v)
/// across the nose. Along it nothing can be had from a solid motor: what thrust and drag do there stays.
/// Positions are interpolated by Hermite's cubics between waypoints, to 1e-3 m at 10 Hz.
///
///   flight::TrajectoryControl control(attitude_control, flight::waypoints(nominal), {});
class TrajectoryControl {
 public:
  using Options = GuidanceOptions;

  /// @throws SetupError for fewer than two waypoints, times not ascending, a frequency, damping or
  /// limit that is not positive.
  TrajectoryControl(const AttitudeControl& attitude, std::vector<Waypoint> waypoints, const Options& options);

  [[nodiscard]] Command command(const Seen& seen);
  /// Where to be at t; beyond the waypoints, where the outermost velocity leads.
  [[nodiscard]] Waypoint reference(double t) const;

 private:
  AttitudeControl attitude_;
  std::vector<Waypoint> waypoints_;
  Options options_;
};

}  // namespace gyrobudget::inline v0::flight
