// SPDX-License-Identifier: MIT
// The WGS84 ellipsoid: its constants, geodetic coordinates, radii of curvature.
// Sources: NGA.STND.0036 (2014), table 3.1; Torge & Mueller, Geodesy (2012), section 4.1; Groves, Principles
// of GNSS, Inertial, and Multisensor Integrated Navigation Systems (2013), sections 2.4 and 5.4.
#pragma once

#include <numbers>
#include <stdexcept>

#include <Eigen/Core>

namespace gyrobudget::inline v0::earth {

namespace wgs84 {
inline constexpr double kEquatorialRadius = 6378137;      ///< a [m]
inline constexpr double kFlattening = 1 / 298.257223563;  ///< f = (a - b)/a
inline constexpr double kGM = 3986004.418e8;              ///< gravitational constant, atmosphere included [m^3/s^2]
inline constexpr double kEarthRate = 7292115e-11;         ///< omega_ie [rad/s]
inline constexpr double kPolarRadius = kEquatorialRadius * (1 - kFlattening);       ///< b [m]
inline constexpr double kEccentricitySquared = kFlattening * (2 - kFlattening);     ///< e^2 = (a^2 - b^2)/a^2
inline constexpr double kAxisRatioSquared = (1 - kFlattening) * (1 - kFlattening);  ///< 1 - e^2 = b^2/a^2
}  // namespace wgs84

inline constexpr double kDegree = std::numbers::pi / 180;  ///< [rad]

/// A point by the ellipsoid's normal through it: latitude and longitude of that normal and the height along
/// it.
struct Geodetic {
  double latitude = 0;   ///< [rad], -pi/2 to pi/2
  double longitude = 0;  ///< [rad], east positive
  double height = 0;     ///< above the ellipsoid [m]

  /// @throws std::invalid_argument for a latitude beyond 90 degrees or a number that is not finite.
  [[nodiscard]] static Geodetic from_degrees(double latitude_deg, double longitude_deg, double height_m);
};

/// A position where the formulas of Earth's shape or field do not hold: not finite, too far away or too near to the
/// centre. A caller whose own computation may lead there, such as a navigator that diverges, catches this type.
class OutsideDomain : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Earth-centred, Earth-fixed position p_eb_e [m]: x through Greenwich, z through the north pole.
///   x = (R_E + h) cos L cos l,  y = (R_E + h) cos L sin l,  z = ((1 - e^2) R_E + h) sin L
/// Error below 2 ulp of the distance from the centre (2 nm at the surface).
[[nodiscard]] Eigen::Vector3d to_ecef(const Geodetic& position);

/// The inverse, in closed form, for every point including poles and centre (H. Vermeille, J. Geodesy 76:451,
/// 2002 and 85:105, 2011; height by projection on the normal). Position error of the way there and back is
/// below 4 nm from 1 km outside the evolute (43 km from the centre) to 10^7 m. On the axis the longitude is
/// 0; on the disc of radius a e^2 in the equatorial plane, where two normals are equally near, the latitude
/// is the northern one: the centre is at latitude 90 degrees and height -b.
/// @throws OutsideDomain where p_eb_e is not finite or is farther than 1e15 m.
[[nodiscard]] Geodetic to_geodetic(const Eigen::Vector3d& p_eb_e);

/// Outward normal of the ellipsoid, "up", at a latitude and longitude [rad], in ECEF axes.
[[nodiscard]] Eigen::Vector3d up_e(double latitude, double longitude);

/// Radius of curvature in the meridian, R_N = a (1 - e^2)/(1 - e^2 sin^2 L)^(3/2) [m], at a latitude L [rad].
[[nodiscard]] double meridian_radius(double latitude);
/// Transverse radius of curvature, R_E = a/(1 - e^2 sin^2 L)^(1/2) [m], at a latitude L [rad].
[[nodiscard]] double transverse_radius(double latitude);

}  // namespace gyrobudget::inline v0::earth
