// SPDX-License-Identifier: MIT
#include "ellipsoid.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::earth {
namespace {

constexpr double kA = wgs84::kEquatorialRadius;
constexpr double kE2 = wgs84::kEccentricitySquared;
constexpr double kE4 = kE2 * kE2;
constexpr double kUnderflow = 1e-290;
constexpr double kFarthest = 1e15;  // [m]; sixth powers are taken, and nothing navigates out there

/// 1 - e^2 sin^2 L
double normal_factor(double sin_latitude) { return 1 - kE2 * sin_latitude * sin_latitude; }

/// A direction in the meridian plane: out of the axis and along it, not normalised.
struct Normal {
  double out, along;
};

/// Largest-magnitude real root u of Vermeille's resolvent, (u - r)^3 = 3 r^2 (u - r) + 2 (r^3 + s), without
/// cancellation. Inside the evolute there are three real ones, and r < 0.
double resolvent(double r, double s) {
  const double r3 = r * r * r;
  const double discriminant = s * (2 * r3 + s);
  if (discriminant >= 0) {
    const double half = r3 + s;
    const double t = std::cbrt(half + std::copysign(std::sqrt(discriminant), half));
    return r + t + (t != 0 ? r * r / t : 0);
  }
  return r + 2 * r * std::cos(std::atan2(std::sqrt(-discriminant), -(r3 + s)) / 3);
}

/// The normal of the ellipsoid through the point `out` from the axis and `along` it. The foot point's normal
/// is (k out/(k + e^2), along), where k = (R_E + h)/R_E - e^2 is a root of a quartic.
Normal normal_through(double out, double along) {
  const double p = (out / kA) * (out / kA);
  const double q = wgs84::kAxisRatioSquared * (along / kA) * (along / kA);
  const double r = (p + q - kE4) / 6;
  if (q < kUnderflow && r <= 0) {  // on the disc, which has a northern and a southern normal
    const double north = std::sqrt(std::max(0.0, kE4 - p) / wgs84::kAxisRatioSquared);
    return {std::sqrt(p), along < 0 ? -north : north};
  }
  const double u = resolvent(r, kE4 * p * q / 4);
  const double v = std::sqrt(u * u + kE4 * q);
  const double u_plus_v = u < 0 ? kE4 * q / (v - u) : u + v;
  const double w = std::max(0.0, kE2 * (u_plus_v - q) / (2 * v));
  const double k = u_plus_v / (std::sqrt(u_plus_v + w * w) + w);
  return {k * out / (k + kE2), along};
}

}  // namespace

Geodetic Geodetic::from_degrees(double latitude_deg, double longitude_deg, double height_m) {
  if (!(std::abs(latitude_deg) <= 90))
    throw std::invalid_argument(fmt::format("latitude {} deg must be from -90 to 90", latitude_deg));
  if (!std::isfinite(longitude_deg)) throw std::invalid_argument(fmt::format("longitude is {} deg", longitude_deg));
  if (!std::isfinite(height_m)) throw std::invalid_argument(fmt::format("height is {} m", height_m));
  return {latitude_deg * kDegree, longitude_deg * kDegree, height_m};
}

Eigen::Vector3d to_ecef(const Geodetic& position) {
  const double sin_latitude = std::sin(position.latitude);
  const double radius = kA / std::sqrt(normal_factor(sin_latitude));
  const double out = (radius + position.height) * std::cos(position.latitude);
  return {out * std::cos(position.longitude), out * std::sin(position.longitude),
          (wgs84::kAxisRatioSquared * radius + position.height) * sin_latitude};
}

Geodetic to_geodetic(const Eigen::Vector3d& p_eb_e) {
  const double out = std::hypot(p_eb_e.x(), p_eb_e.y());
  const double along = p_eb_e.z();
  if (!(std::hypot(out, along) <= kFarthest))
    throw OutsideDomain(fmt::format("position ({}, {}, {}) m must be within {} m of the centre", p_eb_e.x(), p_eb_e.y(),
                                    p_eb_e.z(), kFarthest));
  const Normal normal = normal_through(out, along);
  const double length = std::hypot(normal.out, normal.along);
  const double cos_latitude = normal.out / length;
  const double sin_latitude = normal.along / length;
  // Projected on the normal, the height does not feel a small error of the latitude.
  const double height = out * cos_latitude + along * sin_latitude - kA * std::sqrt(normal_factor(sin_latitude));
  return {std::atan2(normal.along, normal.out), std::atan2(p_eb_e.y(), p_eb_e.x()), height};
}

Eigen::Vector3d up_e(double latitude, double longitude) {
  return {std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude), std::sin(latitude)};
}

double meridian_radius(double latitude) {
  const double factor = normal_factor(std::sin(latitude));
  return kA * wgs84::kAxisRatioSquared / (factor * std::sqrt(factor));
}

double transverse_radius(double latitude) { return kA / std::sqrt(normal_factor(std::sin(latitude))); }

}  // namespace gyrobudget::inline v0::earth
