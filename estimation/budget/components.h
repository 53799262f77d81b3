// SPDX-License-Identifier: MIT
// Along which axes a position is asked for.
#pragma once

#include "gyrobudget/estimation/navigation/covariance.h"

#include <array>
#include <string_view>

#include <Eigen/Core>

namespace gyrobudget::inline v0::budget {

/// An axis of position, or several of them: horizontal is east and north, rss all three.
enum class Component { east, north, up, downrange, crossrange, horizontal, rss };
inline constexpr std::array kComponents{Component::east,      Component::north,      Component::up,
                                        Component::downrange, Component::crossrange, Component::horizontal,
                                        Component::rss};

/// "east", "north", "up", "downrange", "crossrange", "horizontal", "rss".
[[nodiscard]] std::string_view to_string(Component component);

/// The axes in which errors are told, each as columns in the axes of e.
struct LocalAxes {
  Eigen::Matrix3d C_enu = Eigen::Matrix3d::Identity();     ///< east, north, up
  Eigen::Matrix3d C_launch = Eigen::Matrix3d::Identity();  ///< downrange, crossrange (left of it), up

  /// The axes of a component, as unit columns in the axes of e: one, two or three of them.
  [[nodiscard]] Eigen::Matrix<double, 3, Eigen::Dynamic> of(Component component) const;
  /// Root sum square of one sigma of position along the axes a_i of a component, sqrt(sum a_i^T P_pp a_i) [m].
  /// @param covariance_e of position, velocity and attitude in axes of e (error_state.h)
  [[nodiscard]] double position_sigma(const navigation::CoreMatrix& covariance_e, Component component) const;
};

}  // namespace gyrobudget::inline v0::budget
