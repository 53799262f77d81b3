// SPDX-License-Identifier: MIT
// Points that earth's properties are tried on: random ones of every kind, and the corners by name.
#pragma once

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace gyrobudget::earth {

/// Uniform numbers, the same on every machine (std::uniform_real_distribution is not).
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  Eigen::Vector3d vector(double limit) {
    const double x = (*this)(-limit, limit);
    const double y = (*this)(-limit, limit);
    return {x, y, (*this)(-limit, limit)};
  }

 private:
  std::mt19937_64 engine_;
};

/// Heights from -10 km to 10^7 m; a third near the poles, the date line and the equator, corners exactly.
inline std::vector<Geodetic> many_points(int count = 20000) {
  using std::numbers::pi;
  std::vector<Geodetic> points;
  for (const double latitude : {-pi / 2, -1e-9, 0.0, 1e-300, 1e-9, pi / 4, pi / 2 - 1e-9, pi / 2})
    for (const double longitude : {-pi, -pi / 2, 0.0, 1e-12, pi / 2, pi - 1e-12, pi})
      for (const double height : {-1e4, 0.0, 1.0, 3e5, 1e7}) points.push_back({latitude, longitude, height});
  Uniform uniform(20180101);
  for (int k = 0; k < count; ++k) {
    Geodetic g{uniform(-pi / 2, pi / 2), uniform(-pi, pi),
               uniform(0, 1) < 0.5 ? uniform(-1e4, 3e5) : uniform(3e5, 1e7)};
    const double small = std::pow(10, uniform(-16, -1));
    switch (k % 9) {
      case 0:
        g.latitude = std::copysign(pi / 2 - small, g.latitude);
        break;
      case 1:
        g.latitude = std::copysign(small, g.latitude);
        break;
      case 2:
        g.longitude = std::copysign(pi - small, g.longitude);
        break;
      default:
        break;
    }
    points.push_back(g);
  }
  return points;
}

}  // namespace gyrobudget::earth
