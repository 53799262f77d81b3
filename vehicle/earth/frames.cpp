// SPDX-License-Identifier: MIT
#include "frames.h"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::earth {
namespace {

constexpr double kPolarCap = 1e-9;  // [rad]

Eigen::Vector3d cross_earth_rate(const Eigen::Vector3d& p) {
  return {-wgs84::kEarthRate * p.y(), wgs84::kEarthRate * p.x(), 0};
}

}  // namespace

Eigen::Matrix3d C_e_enu(double latitude, double longitude) {
  const double sin_latitude = std::sin(latitude);
  const double cos_latitude = std::cos(latitude);
  const double sin_longitude = std::sin(longitude);
  const double cos_longitude = std::cos(longitude);
  Eigen::Matrix3d C;
  C << -sin_longitude, -sin_latitude * cos_longitude, cos_latitude * cos_longitude,  //
      cos_longitude, -sin_latitude * sin_longitude, cos_latitude * sin_longitude,    //
      0, cos_latitude, sin_latitude;
  return C;
}

Eigen::Matrix3d C_e_ned(double latitude, double longitude) {
  const Eigen::Matrix3d C = C_e_enu(latitude, longitude);
  Eigen::Matrix3d ned;
  ned << C.col(1), C.col(0), -C.col(2);
  return ned;
}

Eigen::Vector3d earth_rate_ned(double latitude) {
  return {wgs84::kEarthRate * std::cos(latitude), 0, -wgs84::kEarthRate * std::sin(latitude)};
}

Eigen::Vector3d transport_rate_ned(const Geodetic& position, const Eigen::Vector3d& v_eb_n) {
  if (!(std::abs(position.latitude) <= std::numbers::pi / 2 - kPolarCap))
    throw std::invalid_argument(
        fmt::format("north, east, down has no finite rate at latitude {} rad; it must be {} rad off the poles",
                    position.latitude, kPolarCap));
  const double east_rate = v_eb_n.y() / (transverse_radius(position.latitude) + position.height);
  return {east_rate, -v_eb_n.x() / (meridian_radius(position.latitude) + position.height),
          -east_rate * std::tan(position.latitude)};
}

Eigen::Matrix3d Inertial::C_ie(double t) const {
  const double c = std::cos(angle(t));
  const double s = std::sin(angle(t));
  Eigen::Matrix3d C;
  C << c, -s, 0,  //
      s, c, 0,    //
      0, 0, 1;
  return C;
}

Moving Inertial::from_ecef(const Moving& moving, double t) const {
  const Eigen::Matrix3d C = C_ie(t);
  return {C * moving.p, C * (moving.v + cross_earth_rate(moving.p))};
}

Moving Inertial::to_ecef(const Moving& moving, double t) const {
  const Eigen::Matrix3d C_ei = C_ie(t).transpose();
  const Eigen::Vector3d p = C_ei * moving.p;
  return {p, C_ei * moving.v - cross_earth_rate(p)};
}

LocalFrame::LocalFrame(const Geodetic& origin, const Eigen::Matrix3d& C_el)
    : origin_(origin), p_el_e_(earth::to_ecef(origin)), C_el_(C_el) {}

LocalFrame LocalFrame::east_north_up(const Geodetic& origin) {
  return {origin, C_e_enu(origin.latitude, origin.longitude)};
}

LocalFrame LocalFrame::north_east_down(const Geodetic& origin) {
  return {origin, C_e_ned(origin.latitude, origin.longitude)};
}

LocalFrame LocalFrame::launch_plane(const Geodetic& origin, double azimuth) {
  if (!std::isfinite(azimuth)) throw std::invalid_argument(fmt::format("launch azimuth is {} rad", azimuth));
  const double s = std::sin(azimuth);
  const double c = std::cos(azimuth);
  Eigen::Matrix3d C_enu_l;
  C_enu_l << s, -c, 0,  //
      c, s, 0,          //
      0, 0, 1;
  return {origin, C_e_enu(origin.latitude, origin.longitude) * C_enu_l};
}

Eigen::Vector3d LocalFrame::from_ecef(const Eigen::Vector3d& p_eb_e) const {
  return C_el_.transpose() * (p_eb_e - p_el_e_);
}

Eigen::Vector3d LocalFrame::to_ecef(const Eigen::Vector3d& p_lb_l) const { return p_el_e_ + C_el_ * p_lb_l; }

}  // namespace gyrobudget::inline v0::earth
