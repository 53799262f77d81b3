// SPDX-License-Identifier: MIT
// Attitude. Quaternions are Hamilton's, q_ab turns coordinates in b to coordinates in a as C_ab does; in
// files w comes first. A rotation vector is the axis times the angle; as an increment it acts on the right:
// q_nb(t + dt) = q_nb(t) exp(integral of w_nb_b, where its direction is fixed).
// Sources: Titterton & Weston, Strapdown Inertial Navigation Technology (2004), sections 3.6 and 11.2; Groves
// (2013), section 2.2; Savage, Strapdown Analytics (2000), section 3.2.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::earth {

/// [v x], so that skew(v) u = v x u.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// The unit quaternion (cos(p/2), sin(p/2)/p phi), p = |phi|, to rounding for every finite phi, 0 included.
[[nodiscard]] Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& phi);
/// The rotation vector of a unit quaternion, |phi| <= pi, to rounding from 0 to pi inclusive: half the angle
/// by atan2 of both parts. q and -q give the same.
[[nodiscard]] Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q);

/// Yaw, pitch, roll [rad] about z, then the new y, then the new x (forward-right-down axes).
struct Euler {
  double yaw = 0;    ///< -pi to pi
  double pitch = 0;  ///< -pi/2 to pi/2, nose up positive
  double roll = 0;   ///< -pi to pi, right side down positive
};

/// q_ab of C_ab = C_z(yaw) C_y(pitch) C_x(roll), where a has its x axis at yaw 0 and its z axis down.
[[nodiscard]] Eigen::Quaterniond from_euler(const Euler& angles);
/// The inverse, to 2e-15 (yaw and roll: over cos pitch). At pitch +-90 degrees these are one angle: within
/// 1e-10 rad of it yaw is set to 0 and roll holds their sum or difference, as on the launch pad; that moves
/// the attitude by 2e-10 rad.
[[nodiscard]] Euler to_euler(const Eigen::Quaterniond& q_ab);

/// The rotation nearest to a matrix in the Frobenius norm: the orthogonal factor of its polar decomposition.
/// @throws std::invalid_argument where the determinant is not positive or the matrix is singular to 1e-8.
[[nodiscard]] Eigen::Matrix3d orthonormalised(const Eigen::Matrix3d& C);

}  // namespace gyrobudget::inline v0::earth
