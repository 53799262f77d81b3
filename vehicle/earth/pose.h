// SPDX-License-Identifier: MIT
// Where a body is, how it moves and how it is turned: one type for truth, navigation and flight.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::earth {

/// Position, velocity and attitude against the turning Earth.
struct Pose {
  Eigen::Vector3d p_eb_e;   ///< [m]
  Eigen::Vector3d v_eb_e;   ///< dp_eb_e/dt [m/s]
  Eigen::Quaterniond q_eb;  ///< of unit norm
};

/// A pose and how it changes.
struct Motion {
  Pose pose;
  Eigen::Vector3d a_eb_e = Eigen::Vector3d::Zero();  ///< dv_eb_e/dt [m/s^2]
  Eigen::Vector3d w_eb_b = Eigen::Vector3d::Zero();  ///< [rad/s]
};

}  // namespace gyrobudget::inline v0::earth
