// SPDX-License-Identifier: MIT
#include "components.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::budget {

std::string_view to_string(Component component) {
  constexpr std::array<std::string_view, kComponents.size()> kNames{"east",       "north",      "up", "downrange",
                                                                    "crossrange", "horizontal", "rss"};
  return kNames[static_cast<std::size_t>(component)];
}

Eigen::Matrix<double, 3, Eigen::Dynamic> LocalAxes::of(Component component) const {
  switch (component) {
    case Component::east:
      return C_enu.col(0);
    case Component::north:
      return C_enu.col(1);
    case Component::up:
      return C_enu.col(2);
    case Component::downrange:
      return C_launch.col(0);
    case Component::crossrange:
      return C_launch.col(1);
    case Component::horizontal:
      return C_enu.leftCols<2>();
    case Component::rss:
      break;
  }
  return C_enu;
}

double LocalAxes::position_sigma(const navigation::CoreMatrix& covariance_e, Component component) const {
  const auto axes = of(component);
  const Eigen::Matrix3d position = covariance_e.block<3, 3>(navigation::kPosition, navigation::kPosition);
  return std::sqrt(std::max(0.0, (axes.transpose() * position * axes).trace()));
}

}  // namespace gyrobudget::inline v0::budget
