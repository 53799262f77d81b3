// SPDX-License-Identifier: MIT
// Trajectories in closed form. Defaults make each of them usable as `stand({})`; all angles are in radians.
// Each throws std::invalid_argument for an option that is not finite, a duration that is not positive, or a
// negative frequency, naming it.
#pragma once

#include "attitude.h"
#include "site.h"
#include "trajectory.h"

namespace gyrobudget::inline v0::earth {

/// Oscillation on top of a motion, in its body axes; zero is none.
struct Vibration {
  /// Classical coning: the body is turned by q_c = (cos a/2, 0, sin(a/2) cos wt, sin(a/2) sin wt), so its x
  /// axis runs on a cone of half-angle a, and it turns at (-2 sin^2(a/2) w, -w sin a sin wt, w sin a cos wt).
  double coning_angle = 0;
  double coning_frequency = 0;  ///< [Hz]
  /// Sculling: roll by angle sin wt while the body is shaken along y with -acceleration sin wt; a strapdown
  /// without correction finds angle acceleration/2 of false acceleration along z.
  double sculling_angle = 0;
  double sculling_acceleration = 0;  ///< peak [m/s^2]
  double sculling_frequency = 0;     ///< [Hz]
};

/// A body at a point that is fixed to Earth: at rest, spinning, coning, or all of these.
/// q_nb(t) = q_nb exp(spin t) q_vibration(t).
struct Stand {
  Geodetic position = alcantara().position;
  Eigen::Quaterniond q_nb = Eigen::Quaterniond::Identity();  ///< at time 0 without vibration; unit
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();            ///< w_nb_b, constant in body axes [rad/s]
  Vibration vibration;
  double duration = 3600;  ///< [s]
};
[[nodiscard]] Trajectory stand(const Stand& options);

/// Level flight at constant ellipsoidal height along a great circle of ellipsoid normals, over poles as over
/// any other point, with S-turns about it. Heading follows the track, bank is that of a coordinated turn,
/// atan(lateral acceleration/9.80665), and down is the ellipsoid's normal.
struct Cruise {
  Geodetic start = Geodetic{alcantara().position.latitude, alcantara().position.longitude, 10000};
  double azimuth = 90 * kDegree;  ///< of the centre line at the start
  double speed = 250;            ///< [m/s] along the centre line at the start; constant to 1 % by the ellipsoid's shape
  double turn_acceleration = 0;  ///< peak lateral acceleration of the S-turns [m/s^2]
  double turn_period = 60;       ///< of a whole S [s]
  Vibration vibration;
  double duration = 3600;  ///< [s]
};
[[nodiscard]] Trajectory cruise(const Cruise& options);

/// Straight up from a site with constant acceleration against Earth, nose up and belly towards the azimuth.
struct Climb {
  Geodetic site = alcantara().position;
  double azimuth = 90 * kDegree;  ///< of the belly, to which the nose would pitch over
  double acceleration = 10;       ///< [m/s^2]
  Vibration vibration;
  double duration = 60;  ///< [s]
};
[[nodiscard]] Trajectory climb(const Climb& options);

/// Powered ascent in the launch plane. Pitch from the site's horizon is 90 degrees, from pitch_over_at on
/// linear in time to pitch_end at the end; yaw and roll against the launch plane are zero. Specific force
/// along the body's x axis is linear from force_start to force_end, then linear to zero over the last
/// tail_off seconds. What is sensed is exact; position and velocity are integrated from rest
/// (Runge-Kutta-Fehlberg 7(8), error below 20 um over the defaults), two steps a second, which are kept: it
/// lasts at most kLongestAscent.
/// Defaults: 83 s from Alcantara to the east.
struct Ascent {
  Geodetic site = alcantara().position;
  double azimuth = 90 * kDegree;
  double pitch_over_at = 8;         ///< [s]
  double pitch_end = 50 * kDegree;  ///< above the site's horizon
  double force_start = 13;          ///< [m/s^2]
  double force_end = 19;            ///< [m/s^2], when the tail-off begins
  double tail_off = 6;              ///< [s]
  double duration = 83;             ///< [s]
};
inline constexpr double kLongestAscent = 86400;  ///< [s]
/// Throws also where pitch-over or tail-off lie outside the duration, or that beyond kLongestAscent.
[[nodiscard]] Trajectory ascent(const Ascent& options);

}  // namespace gyrobudget::inline v0::earth
