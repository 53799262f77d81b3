// SPDX-License-Identifier: MIT
#include "flight_frame.h"

#include "gyrobudget/vehicle/earth/attitude.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::closed_loop {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using flight::FlightPoint;

LaunchAttitude launch_attitude(const Eigen::Quaterniond& q_eb, const Matrix3d& C_launch) {
  // To downrange, right, down. With C_y(pitch) C_z(yaw) C_x(roll) the second row is (sin y, cos y cos r, -cos y sin r),
  // and the first column (cos p cos y, sin y, -sin p cos y).
  const Matrix3d C_lb = Vector3d(1, -1, -1).asDiagonal() * C_launch.transpose() * q_eb.toRotationMatrix();
  return {std::atan2(-C_lb(2, 0), C_lb(0, 0)), std::asin(std::clamp(C_lb(1, 0), -1.0, 1.0)),
          std::atan2(-C_lb(1, 2), C_lb(1, 1))};
}

FlightFrame::FlightFrame(const flight::Plan& plan, const flight::FlightRecord& nominal)
    : launch_(earth::LocalFrame::launch_plane(plan.flight.world.site, plan.control.azimuth)),
      end_(nominal.end.t),
      at_end_(nominal.end.truth) {
  constexpr std::size_t kPointsOfASpline = 4;
  if (nominal.points.size() > kPointsOfASpline) path_ = flight::trajectory(nominal);
}

FromPad FlightFrame::from_pad(const FlightPoint& point) const {
  return {point.t, launch_.from_ecef(point.truth.p_eb_e), launch_.C_el().transpose() * point.truth.v_eb_e,
          earth::to_geodetic(point.truth.p_eb_e), launch_attitude(point.truth.q_eb, launch_.C_el())};
}

Difference FlightFrame::difference(const earth::Pose& pose, const earth::Pose& less) const {
  const auto local = [&](const Vector3d& e) -> Vector3d { return launch_.C_el().transpose() * e; };
  return {local(pose.p_eb_e - less.p_eb_e), local(pose.v_eb_e - less.v_eb_e),
          local(earth::log_rotation((pose.q_eb * less.q_eb.conjugate()).normalized()))};
}

Difference FlightFrame::navigation_error(const FlightPoint& point) const { return difference(point.truth, point.seen); }

std::optional<Difference> FlightFrame::departure(const FlightPoint& point) const {
  constexpr double kSameTime = 1e-9;  // [s]
  if (std::abs(point.t - end_) < kSameTime) return difference(point.truth, at_end_);
  if (!path_ || point.t > end_) return std::nullopt;
  return difference(point.truth, path_->at(point.t).pose);
}

}  // namespace gyrobudget::inline v0::closed_loop
