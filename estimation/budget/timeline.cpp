// SPDX-License-Identifier: MIT
#include "timeline.h"

#include "gyrobudget/estimation/navigation/detail/check.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::budget {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::detail::require;

const Vector3d kEarthRate{0, 0, earth::wgs84::kEarthRate};
constexpr double kAtRest = 1e-3;    // [m/s]
constexpr double kMostSteps = 1e6;  // 600 bytes each in the adjoint

}  // namespace

Timeline::Timeline(earth::Trajectory trajectory, std::vector<navigation::PlannedFix> fixes, const Options& options)
    : trajectory_(std::move(trajectory)), fixes_(std::move(fixes)), pad_(options.pad), report_(options.report) {
  require(options.step > 0 && std::isfinite(options.step), "covariance step [s]", options.step, "above 0");
  require(options.pad >= 0 && std::isfinite(options.pad), "time on the pad [s]", options.pad, "0 or more");
  if (pad_ > 0)
    require(trajectory_.at(0).pose.v_eb_e.norm() <= kAtRest, "speed at the start [m/s], after a time on the pad",
            trajectory_.at(0).pose.v_eb_e.norm(), fmt::format("at most {}", kAtRest));
  const auto inside = [&](double t) { return t >= start() && t <= end(); };
  for (const double t : report_) require(inside(t), "time of interest [s]", t, "within the scene");
  for (const auto& fix : fixes_) require(inside(fix.time), "time of a fix [s]", fix.time, "within the scene");
  std::stable_sort(fixes_.begin(), fixes_.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  report_.push_back(end());
  std::sort(report_.begin(), report_.end());
  report_.erase(std::unique(report_.begin(), report_.end()), report_.end());
  cut(options);
}

void Timeline::cut(const Options& options) {
  require((end() - start()) / options.step <= kMostSteps, "covariance step [s]", options.step,
          fmt::format("at least {:g} of the scene's {:g} s", 1 / kMostSteps, end() - start()));
  struct Cut {
    double time;
    bool needed;
  };
  std::vector<Cut> cuts{{start(), true}, {0, true}};
  for (const double t : report_) cuts.push_back({t, true});
  for (const auto& fix : fixes_) cuts.push_back({fix.time, true});
  for (const double t : trajectory_.breaks()) cuts.push_back({t, false});
  std::ranges::sort(cuts, {}, &Cut::time);
  double from = start();
  for (const auto& [to, needed] : cuts) {
    // Breaks as dense as the knots of sampled data are none that matter: a step has the means over itself.
    if (to - from < (needed ? kSameTime : options.step / 2)) continue;
    const auto parts = static_cast<int>(std::ceil((to - from) / options.step * (1 - 1e-12)));
    for (int i = 0; i < parts; ++i)
      steps_.push_back(make_step(from + (to - from) * i / parts, from + (to - from) * (i + 1) / parts));
    from = to;
  }
}

Timeline::Step Timeline::make_step(double from, double to) const {
  Step step{from, to, {}};
  step.input.dt = to - from;
  step.input.t = (from + to) / 2 - start();
  const double middle = std::max(0.0, (from + to) / 2);
  const earth::TrajectoryPoint point = trajectory_.at(middle);
  step.input.p_eb_e = point.pose.p_eb_e;
  step.input.C_eb = point.pose.q_eb.toRotationMatrix();
  if (to <= 0) {  // at rest, whatever the trajectory's first instant does
    step.input.w_ib_b = step.input.C_eb.transpose() * kEarthRate;
    step.input.f_ib_b = -(step.input.C_eb.transpose() * earth::normal_gravity(point.pose.p_eb_e));
  } else {
    const noise::ImuIncrement imu = trajectory_.increment(from, to);
    step.input.w_ib_b = earth::vector(imu.angle) / (to - from);
    step.input.f_ib_b = earth::vector(imu.velocity) / (to - from);
  }
  return step;
}

earth::Motion Timeline::at(double time) const {
  const auto [t, pose, sensed] = trajectory_.at(std::max(0.0, time));
  earth::Motion motion{.pose = pose};
  if (time < 0 || (time == 0 && pad_ > 0)) {
    motion.pose.v_eb_e.setZero();
    return motion;
  }
  const Matrix3d C = pose.q_eb.toRotationMatrix();
  motion.w_eb_b = sensed.w_ib_b - C.transpose() * kEarthRate;
  motion.a_eb_e = C * sensed.f_ib_b + earth::normal_gravity(pose.p_eb_e) - 2 * kEarthRate.cross(pose.v_eb_e);
  return motion;
}

}  // namespace gyrobudget::inline v0::budget
