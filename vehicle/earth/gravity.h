// SPDX-License-Identifier: MIT
// Normal gravity of WGS84: the field of a rotating equipotential ellipsoid, in closed form for the loop.
// gravitation is the pull of the mass alone; gravity is what a plumb line shows, the centrifugal term
// included. An accelerometer at rest on Earth senses f = -gravity; in inertial axes p'' = f + gravitation.
// Sources: Heiskanen & Moritz, Physical Geodesy (1967), sections 2-7 to 2-9; Torge & Mueller, Geodesy (2012),
// 4.2.
#pragma once

#include "ellipsoid.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::earth {

/// Normal gravitation at p_eb_e, in ECEF axes [m/s^2], by the zonal series of the ellipsoid to degree 12:
///   grad V = -GM/r^2 { [1 - sum J_n (a/r)^n P'_(n+1)(s)] r^ + [sum J_n (a/r)^n P'_n(s)] z^ },  s = z/r,
///   J_2k = (-1)^(k+1) 3 e^(2k)/((2k+1)(2k+3)) (1 - k + 5 k J_2/e^2).
/// No angle is taken, so poles and date line are points like others. Error below 1e-14 m/s^2 beside rounding
/// (about 4e-15 m/s^2) from 10 km below the ellipsoid outwards; it grows as (a/r)^14 below that.
/// @throws OutsideDomain nearer to the centre than 1000 km, or where p_eb_e is not finite.
[[nodiscard]] Eigen::Vector3d normal_gravitation(const Eigen::Vector3d& p_eb_e);

/// Normal gravity in ECEF axes: normal_gravitation + omega^2 (x, y, 0).
[[nodiscard]] Eigen::Vector3d normal_gravity(const Eigen::Vector3d& p_eb_e);

/// omega_ie^2 (x, y, 0), the centrifugal acceleration of a point that turns with Earth [m/s^2].
[[nodiscard]] Eigen::Vector3d centrifugal(const Eigen::Vector3d& p_eb_e);

/// d(normal gravity)/d(p_eb_e) [1/s^2] from the point mass, J2 and the centrifugal term, symmetric. What is
/// left out (J4 on) is below 1e-4 of GM/r^3 from the ellipsoid outwards.
/// @throws as normal_gravitation.
[[nodiscard]] Eigen::Matrix3d normal_gravity_gradient(const Eigen::Vector3d& p_eb_e);

/// Somigliana's formula: magnitude of normal gravity on the ellipsoid itself at a latitude L [rad], [m/s^2],
///   gamma = gamma_e (1 + k sin^2 L)/(1 - e^2 sin^2 L)^(1/2),  k = b gamma_p/(a gamma_e) - 1.
[[nodiscard]] double somigliana(double latitude);

/// J_n of the normal field, n even from 2 to 12. @throws std::invalid_argument for another n.
[[nodiscard]] double normal_zonal(int n);

}  // namespace gyrobudget::inline v0::earth
