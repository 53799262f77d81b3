// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <cmath>

#include <Eigen/Core>

namespace gyrobudget::inline v0::flight::detail {

struct Height {
  double above_ellipsoid;  ///< [m]
  Eigen::Vector3d up;      ///< normal of the ellipsoid, in the axes of p
};

/// Of a point in ECEF or ECI axes, without angles: B. R. Bowring, The accuracy of geodetic latitude and
/// height equations, Survey Review 28:202 (1985), one step. Error below 1 um from 10 km below the ellipsoid
/// to 1000 km above it; poles included, the centre not.
inline Height height_of(const Eigen::Vector3d& p) {
  using namespace earth::wgs84;
  constexpr double second = kEccentricitySquared / kAxisRatioSquared;  // e'^2
  const double rho = std::sqrt(p.x() * p.x() + p.y() * p.y());
  const double r = std::sqrt(rho * rho + p.z() * p.z());
  double sine = kPolarRadius * p.z() * (1 + second * kPolarRadius / r);  // of the parametric latitude
  double cosine = kEquatorialRadius * rho;
  const double norm = std::sqrt(sine * sine + cosine * cosine);
  sine /= norm;
  cosine /= norm;
  double s = p.z() + second * kPolarRadius * sine * sine * sine;
  double c = rho - kEccentricitySquared * kEquatorialRadius * cosine * cosine * cosine;
  const double length = std::sqrt(s * s + c * c);
  s /= length;
  c /= length;
  const double height = rho * c + p.z() * s - kEquatorialRadius * std::sqrt(1 - kEccentricitySquared * s * s);
  const double per_rho = rho > 0 ? c / rho : 0;
  return {height, {p.x() * per_rho, p.y() * per_rho, s}};
}

}  // namespace gyrobudget::inline v0::flight::detail
