// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "ellipsoid.h"
#include "trajectory.h"

namespace gyrobudget::inline v0::earth {

/// A trajectory through samples of any vehicle, by splines with continuous second derivatives (cubic,
/// not-a-knot ends; de Boor, A Practical Guide to Splines, 2001, chapter IV): of p_eb_e, and of the
/// quaternion's four components, normalised. It passes through every sample; between them, for samples h
/// apart of a smooth motion, position and attitude err as h^4 and acceleration as h^2. Noise in positions of
/// 1 mm at 100 Hz is 10 m/s^2 of specific force: smooth before. Time 0 of the trajectory is times[0].
///
/// @param times ascending [s]
/// @param p_eb_e one position for each time [m]
/// @param q_eb one attitude for each time, unit; either sign
/// @throws std::invalid_argument for fewer than 4 samples, spans of different length, times not ascending,
/// numbers that are not finite, norms off 1 by more than 1e-6, or a turn of more than 90 degrees between
/// samples.
[[nodiscard]] Trajectory through_samples(std::span<const double> times, std::span<const Eigen::Vector3d> p_eb_e,
                                         std::span<const Eigen::Quaterniond> q_eb);

/// The same from geodetic positions and attitudes against north, east, down at each.
[[nodiscard]] Trajectory through_samples(std::span<const double> times, std::span<const Geodetic> positions,
                                         std::span<const Eigen::Quaterniond> q_nb);

}  // namespace gyrobudget::inline v0::earth
