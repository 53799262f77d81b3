// SPDX-License-Identifier: MIT
// Air and wind.
// Source: U.S. Standard Atmosphere, 1976 (NOAA-S/T 76-1562), sections 1.2 and 1.3, tables 2 to 4.
#pragma once

#include <array>

#include "lookup_table.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::flight {

/// Air at a height.
struct Air {
  double pressure = 0;        ///< [Pa]
  double density = 0;         ///< [kg/m^3]
  double speed_of_sound = 0;  ///< [m/s]; 0 where there is no air
  double temperature = 0;     ///< molecular-scale [K]: kinetic below 80 km, up to 0.05 % above it to 86 km
};

/// U.S. Standard Atmosphere 1976 from 5 km below sea level to its top at 84.852 km of geopotential height
/// (86 km), and nothing above: zero pressure and density, a step from 0.37 Pa. Each layer has a linear
/// temperature in geopotential height H = r0 h/(r0 + h), r0 = 6356766 m, so its density is smooth inside
/// and has a kink at the layer's ends, where an integrator has to stop. Below the range: as at its end.
namespace standard_atmosphere {

inline constexpr int kLayers = 7;
/// Lower ends of the layers and the top, in height above the ellipsoid, taken for that above the sea [m].
[[nodiscard]] const std::array<double, kLayers + 1>& bounds();
/// The layer of a height, kLayers above the top.
[[nodiscard]] int layer(double height);
/// Air at `height` [m] by the formula of `layer`, also a little beyond the layer's ends.
[[nodiscard]] Air at(double height, int layer);
[[nodiscard]] inline Air at(double height) { return at(height, layer(height)); }

}  // namespace standard_atmosphere

/// One gust between two heights, (1 - cos)/2 across them.
struct Gust {
  double height = 0;                               ///< of its peak [m]
  double half_width = 0;                           ///< [m]; 0 is no gust
  Eigen::Vector3d peak = Eigen::Vector3d::Zero();  ///< [m/s], east, north, up at the launch site
};

/// Velocity of the air against Earth in the axes east, north, up of the launch site, which stay fixed to
/// Earth (so poles are no special places; 12 km downrange they lean by 0.1 degrees).
struct Wind {
  Eigen::Vector3d steady = Eigen::Vector3d::Zero();  ///< at every height [m/s]
  LookupTable east = 0;                              ///< shear: more, by height [m], of [m/s]
  LookupTable north = 0;
  Gust gust;

  [[nodiscard]] Eigen::Vector3d at(double height) const;
  /// Whether there is none at any height.
  [[nodiscard]] bool calm() const;
};

}  // namespace gyrobudget::inline v0::flight
