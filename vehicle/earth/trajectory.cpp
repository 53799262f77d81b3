// SPDX-License-Identifier: MIT
#include "trajectory.h"

#include <boost/math/quadrature/gauss.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "ellipsoid.h"
#include "gravity.h"
#include "vector.h"

namespace gyrobudget::inline v0::earth {
namespace {

constexpr double kRoundOfTime = 1e-12;  // relative; k times an interval may pass the end by a rounding
constexpr double kMostIncrements = 2147483648.0;
// Above any structure's, and as many panels a second as one waits for.
constexpr double kHighestFrequency = 1e6;  // [rad/s]
constexpr double kLight = 299792458;       // [m/s]

constexpr double kShort =
    0.02;  // of a panel or a smooth piece, where 3 points do what 7 do: (0.04)^6/2e6 at twice fastest()

/// Adds the integral over one smooth panel.
template <unsigned points>
void add_panel(const Path& path, double from, double to, noise::ImuIncrement& sum) {
  using Rule = boost::math::quadrature::gauss<double, points>;
  const double middle = (from + to) / 2;
  const double half = (to - from) / 2;
  const auto add = [&](double t, double weight) {
    const Sensed s = path.sensed(t);
    vector(sum.velocity) += weight * half * s.f_ib_b;
    vector(sum.angle) += weight * half * s.w_ib_b;
  };
  for (std::size_t k = 0; k < Rule::abscissa().size(); ++k) {
    const double x = Rule::abscissa()[k];
    add(middle + half * x, Rule::weights()[k]);
    if (x != 0) add(middle - half * x, Rule::weights()[k]);
  }
}

}  // namespace

Sensed sense(const Motion& motion) {
  const Eigen::Vector3d w_ie_e(0, 0, wgs84::kEarthRate);
  const auto& [p_eb_e, v_eb_e, q_eb] = motion.pose;
  const Eigen::Quaterniond q_be = q_eb.conjugate();
  return {.f_ib_b = q_be * (motion.a_eb_e + 2 * w_ie_e.cross(v_eb_e) - normal_gravity(p_eb_e)),
          .w_ib_b = motion.w_eb_b + q_be * w_ie_e};
}

Sensed Path::sensed(double t) const { return sense(at(t)); }

Trajectory::Trajectory(std::shared_ptr<const Path> path) : path_(std::move(path)) {
  if (!path_) throw std::invalid_argument("a trajectory needs a path");
  duration_ = path_->duration();
  if (!(duration_ > 0) || !std::isfinite(duration_))
    throw std::invalid_argument(fmt::format("duration {} s of a trajectory must be positive and finite", duration_));
  const double fastest = path_->fastest();
  if (!(fastest > 0 && fastest <= kHighestFrequency))
    throw std::invalid_argument(fmt::format(
        "highest frequency {} rad/s of a path must be positive and at most {} rad/s", fastest, kHighestFrequency));
  for (const double t : {0.0, duration_}) {
    const double speed = path_->at(t).pose.v_eb_e.norm();
    if (!(speed < kLight))
      throw std::invalid_argument(fmt::format("speed {} m/s at {} s of a path must be below that of light", speed, t));
  }
  panel_ = 1 / fastest;
  breaks_ = path_->breaks();
}

void Trajectory::check_time(double t) const {
  if (!(t >= 0 && t <= duration_ * (1 + kRoundOfTime)))
    throw std::invalid_argument(fmt::format("time {} s must be within the trajectory, 0 to {} s", t, duration_));
}

TrajectoryPoint Trajectory::at(double t) const {
  check_time(t);
  t = std::min(t, duration_);
  return {.t = t, .pose = path_->at(t).pose, .sensed = path_->sensed(t)};
}

noise::ImuIncrement Trajectory::increment(double from, double to) const {
  check_time(from);
  check_time(to);
  if (to < from) throw std::invalid_argument(fmt::format("an increment from {} s to {} s runs backwards", from, to));
  to = std::min(to, duration_);
  noise::ImuIncrement sum;
  auto next_break = std::upper_bound(breaks_.begin(), breaks_.end(), from);
  while (from < to) {
    const double piece_start = next_break != breaks_.begin() ? *std::prev(next_break) : 0;
    const double piece_end = next_break != breaks_.end() ? *next_break++ : duration_;
    const double end = std::min(to, piece_end);
    const double panels = std::ceil((end - from) / panel_);
    const auto add = end - from <= kShort * std::min(panel_, piece_end - piece_start) ? add_panel<3> : add_panel<7>;
    for (double k = 0; k < panels; ++k)
      add(*path_, from + (end - from) * (k / panels), from + (end - from) * ((k + 1) / panels), sum);
    from = end;
  }
  if (!std::isfinite(vector(sum.velocity).sum() + vector(sum.angle).sum()))
    throw std::invalid_argument(
        fmt::format("what is sensed before {} s is not finite: the path is none of a body", to));
  return sum;
}

std::vector<noise::ImuIncrement> Trajectory::increments(double interval) const {
  const double count = std::floor(duration_ / interval * (1 + kRoundOfTime));
  if (!(interval > 0) || !(count < kMostIncrements))
    throw std::invalid_argument(
        fmt::format("interval {} s must be positive and give fewer than {} increments over {} s", interval,
                    kMostIncrements, duration_));
  std::vector<noise::ImuIncrement> all;
  all.reserve(static_cast<std::size_t>(count));
  for (double k = 0; k < count; ++k) all.push_back(increment(k * interval, (k + 1) * interval));
  return all;
}

}  // namespace gyrobudget::inline v0::earth
