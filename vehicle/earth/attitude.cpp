// SPDX-License-Identifier: MIT
#include "attitude.h"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <Eigen/SVD>

namespace gyrobudget::inline v0::earth {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d M;
  M << 0, -v.z(), v.y(),  //
      v.z(), 0, -v.x(),   //
      -v.y(), v.x(), 0;
  return M;
}

Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& phi) {
  const double half = phi.stableNorm() / 2;
  // sin(x)/x is 1 to rounding below 1e-8; its quotient is fine from there on.
  const double scale = half < 1e-8 ? 0.5 : std::sin(half) / half / 2;
  Eigen::Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = scale * phi;
  return q;
}

Eigen::Vector3d log_rotation(const Eigen::Quaterniond& q) {
  const double sine = q.vec().stableNorm();  // of half the angle
  if (sine == 0) return Eigen::Vector3d::Zero();
  const double angle = 2 * std::atan2(sine, std::abs(q.w()));
  return std::copysign(angle / sine, q.w()) * q.vec();
}

Eigen::Quaterniond from_euler(const Euler& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return AngleAxisd(angles.yaw, Vector3d::UnitZ()) * AngleAxisd(angles.pitch, Vector3d::UnitY()) *
         AngleAxisd(angles.roll, Vector3d::UnitX());
}

Euler to_euler(const Eigen::Quaterniond& q_ab) {
  // With half angles, (w - y, z + x) = (cos p - sin p) (cos, sin)(yaw + roll) and (w + y, z - x) = (cos p +
  // sin p) (cos, sin)(yaw - roll). Quotients of these keep all digits where the asin of a sine near 1 loses
  // half of them.
  const double minus = std::hypot(q_ab.w() - q_ab.y(), q_ab.z() + q_ab.x());  // |cos(p/2) - sin(p/2)|
  const double plus = std::hypot(q_ab.w() + q_ab.y(), q_ab.z() - q_ab.x());   // |cos(p/2) + sin(p/2)|
  using std::numbers::pi;
  constexpr double kLock = 1e-10 / 2;
  Euler e;
  e.pitch = std::atan2(plus * plus - minus * minus, 2 * plus * minus);
  const double sum = std::atan2(q_ab.z() + q_ab.x(), q_ab.w() - q_ab.y());         // (yaw + roll)/2
  const double difference = std::atan2(q_ab.z() - q_ab.x(), q_ab.w() + q_ab.y());  // (yaw - roll)/2
  if (minus < kLock * plus) {
    e.roll = std::remainder(-2 * difference, 2 * pi);
  } else if (plus < kLock * minus) {
    e.roll = std::remainder(2 * sum, 2 * pi);
  } else {
    e.yaw = std::remainder(sum + difference, 2 * pi);
    e.roll = std::remainder(sum - difference, 2 * pi);
  }
  return e;
}

Eigen::Matrix3d orthonormalised(const Eigen::Matrix3d& C) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d s = svd.singularValues();
  if (!(s(2) > 1e-8 * s(0)) || !(R.col(0).cross(R.col(1)).dot(R.col(2)) > 0))
    throw std::invalid_argument(fmt::format("no rotation is near a matrix of singular values {}, {}, {}{}", s(0), s(1),
                                            s(2), s(2) > 1e-8 * s(0) ? " that mirrors" : ""));
  return R;
}

}  // namespace gyrobudget::inline v0::earth
