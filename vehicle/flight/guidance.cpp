// SPDX-License-Identifier: MIT
#include "guidance.h"

#include "gyrobudget/vehicle/earth/attitude.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::flight {

using Eigen::Vector3d;

std::vector<Waypoint> waypoints(const FlightRecord& record) {
  std::vector<Waypoint> result;
  for (const FlightPoint& p : record.points)
    if (result.empty() || p.t > result.back().t) result.push_back({p.t, p.truth.p_eb_e, p.truth.v_eb_e});
  return result;
}

TrajectoryControl::TrajectoryControl(const AttitudeControl& attitude, std::vector<Waypoint> waypoints,
                                     const Options& options)
    : attitude_(attitude), waypoints_(std::move(waypoints)), options_(options) {
  if (waypoints_.size() < 2)
    throw SetupError(
        fmt::format("a trajectory of {} waypoints cannot be followed: give at least 2", waypoints_.size()));
  for (std::size_t k = 1; k < waypoints_.size(); ++k)
    if (!(waypoints_[k].t > waypoints_[k - 1].t))
      throw SetupError(
          fmt::format("times of waypoints must ascend, but {} s follows {} s", waypoints_[k].t, waypoints_[k - 1].t));
  if (!(options.frequency > 0) || !(options.damping > 0) || !(options.angle_limit > 0))
    throw SetupError(
        fmt::format("guidance needs a frequency ({} rad/s), a damping ({}) and an angle ({} rad) that are positive",
                    options.frequency, options.damping, options.angle_limit));
}

Waypoint TrajectoryControl::reference(double t) const {
  const Waypoint &first = waypoints_.front(), &last = waypoints_.back();
  if (t <= first.t) return {t, first.p_eb_e + (t - first.t) * first.v_eb_e, first.v_eb_e};
  if (t >= last.t) return {t, last.p_eb_e + (t - last.t) * last.v_eb_e, last.v_eb_e};
  const auto next = std::upper_bound(waypoints_.begin(), waypoints_.end(), t,
                                     [](double time, const Waypoint& w) { return time < w.t; });
  const Waypoint &a = *(next - 1), &b = *next;
  const double h = b.t - a.t, x = (t - a.t) / h;
  const Vector3d way = (b.p_eb_e - a.p_eb_e) / h;
  const Vector3d second = 3 * way - 2 * a.v_eb_e - b.v_eb_e, third = a.v_eb_e + b.v_eb_e - 2 * way;
  return {t, a.p_eb_e + h * x * (a.v_eb_e + x * (second + x * third)), a.v_eb_e + x * (2 * second + 3 * x * third)};
}

Command TrajectoryControl::command(const Seen& seen) {
  const Waypoint wanted = reference(seen.t);
  const Eigen::Quaterniond program = attitude_.reference(seen.t);
  const BurnState now = burn_state(attitude_.vehicle(), seen.t);
  const double push =
      std::max(now.vacuum_thrust, attitude_.options().least_thrust * attitude_.vehicle().mean_thrust()) / now.mass;
  const double w = options_.frequency;
  const Vector3d acceleration =
      w * w * (wanted.p_eb_e - seen.pose.p_eb_e) + 2 * options_.damping * w * (wanted.v_eb_e - seen.pose.v_eb_e);
  const Vector3d nose = program * Vector3d::UnitX();
  Vector3d turn = push > 0 ? Vector3d(nose.cross(acceleration) / push) : Vector3d(Vector3d::Zero());
  if (turn.norm() > options_.angle_limit) turn *= options_.angle_limit / turn.norm();
  return attitude_.command(seen, earth::exp_rotation(turn) * program);
}

}  // namespace gyrobudget::inline v0::flight
