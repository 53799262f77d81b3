// SPDX-License-Identifier: MIT
// Frames and what turns between them. A name tells its frames: C_ab takes coordinates in b to coordinates in
// a, p_eb_e is the position of b from e in the axes of e, w_ie_n the rate of e against i in the axes of n.
//   i  inertial, origin at Earth's centre, axes those of e at the epoch but for its angle (ECI)
//   e  Earth-centred, Earth-fixed (ECEF)
//   n  north, east, down at the place of the body (NED)
//   l  fixed at a site: east, north, up; north, east, down; or downrange, crossrange, up
//   b  body: forward, right, down
// Sources: Groves (2013), chapters 2 and 5; Titterton & Weston, Strapdown Inertial Navigation Technology
// (2004), 3.
#pragma once

#include "ellipsoid.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::earth {

/// C_en of north, east, down at a latitude and longitude [rad]. At a pole the longitude still tells the axes apart.
[[nodiscard]] Eigen::Matrix3d C_e_ned(double latitude, double longitude);
/// C_el of east, north, up at a latitude and longitude [rad].
[[nodiscard]] Eigen::Matrix3d C_e_enu(double latitude, double longitude);

/// Earth's rate in north, east, down: omega (cos L, 0, -sin L) [rad/s].
[[nodiscard]] Eigen::Vector3d earth_rate_ned(double latitude);
/// w_en_n, by which north, east, down turns as the body moves (Groves 5.44) [rad/s]:
///   (v_E/(R_E + h), -v_N/(R_N + h), -v_E tan L/(R_E + h)).
/// @throws std::invalid_argument within 1e-9 rad (6 mm) of a pole, where that frame spins without bound.
[[nodiscard]] Eigen::Vector3d transport_rate_ned(const Geodetic& position, const Eigen::Vector3d& v_eb_n);

/// Position and velocity against one frame, in its axes.
struct Moving {
  Eigen::Vector3d p;  ///< [m]
  Eigen::Vector3d v;  ///< [m/s]
};

/// ECI by the angle from its x axis to Greenwich, angle_at_epoch + omega t. Precession, nutation, polar
/// motion and variations of the day are left out: 1e-7 of Earth's rate over a day.
class Inertial {
 public:
  explicit Inertial(double angle_at_epoch = 0) : angle_at_epoch_(angle_at_epoch) {}
  [[nodiscard]] double angle(double t) const { return angle_at_epoch_ + wgs84::kEarthRate * t; }
  [[nodiscard]] Eigen::Matrix3d C_ie(double t) const;
  /// At a time t [s] after the epoch: from p_eb_e, v_eb_e to p_ib_i, v_ib_i = C_ie (v_eb_e + w_ie x p_eb_e).
  [[nodiscard]] Moving from_ecef(const Moving& moving, double t) const;
  /// From p_ib_i, v_ib_i to p_eb_e, v_eb_e.
  [[nodiscard]] Moving to_ecef(const Moving& moving, double t) const;

 private:
  double angle_at_epoch_;
};

/// A Cartesian frame fixed to Earth at a site.
///
///   const auto pad = LocalFrame::launch_plane(alcantara().position, 90 * kDegree);
///   const Eigen::Vector3d downrange_crossrange_up = pad.from_ecef(p_eb_e);
class LocalFrame {
 public:
  [[nodiscard]] static LocalFrame east_north_up(const Geodetic& origin);
  [[nodiscard]] static LocalFrame north_east_down(const Geodetic& origin);
  /// Downrange along `azimuth` (clockwise from north), crossrange to its left, up: for azimuth 90 degrees it
  /// is east, north, up. @throws std::invalid_argument where the azimuth is not finite.
  [[nodiscard]] static LocalFrame launch_plane(const Geodetic& origin, double azimuth);

  [[nodiscard]] const Geodetic& origin() const { return origin_; }
  [[nodiscard]] const Eigen::Vector3d& p_el_e() const { return p_el_e_; }
  [[nodiscard]] const Eigen::Matrix3d& C_el() const { return C_el_; }

  /// p_lb_l = C_le (p_eb_e - p_el_e). Velocities and other free vectors take C_el() alone.
  [[nodiscard]] Eigen::Vector3d from_ecef(const Eigen::Vector3d& p_eb_e) const;
  /// p_eb_e = p_el_e + C_el p_lb_l.
  [[nodiscard]] Eigen::Vector3d to_ecef(const Eigen::Vector3d& p_lb_l) const;

 private:
  LocalFrame(const Geodetic& origin, const Eigen::Matrix3d& C_el);

  Geodetic origin_;
  Eigen::Vector3d p_el_e_;
  Eigen::Matrix3d C_el_;
};

}  // namespace gyrobudget::inline v0::earth
