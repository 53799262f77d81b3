// SPDX-License-Identifier: MIT
// Slow, independent integrations; Boost.Odeint is heavy, so they stand in a file of their own.
#pragma once

#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace odes {

/// Integral from 0 to t of a body's rates, 2 (sin t, cos 1.3 t, sin(0.7 t + 1)) rad/s.
Eigen::Vector3d tumbling_angle(double t);
/// Its attitude after t seconds from identity, to 1e-13 rad.
Eigen::Quaterniond tumbled(double t);
/// Position and velocity in inertial axes after t seconds of free fall in the normal field, to 1e-6 m.
std::pair<Eigen::Vector3d, Eigen::Vector3d> orbit(const Eigen::Vector3d& p, const Eigen::Vector3d& v, double t);

}  // namespace odes
