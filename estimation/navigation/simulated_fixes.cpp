// SPDX-License-Identifier: MIT
#include "simulated_fixes.h"

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/normal.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Draws {
 public:
  Draws(int number, std::uint64_t seed, std::uint64_t run)
      : key_{seed, (std::uint64_t{'A'} << 56) | (static_cast<std::uint64_t>(number) << 45) | run} {}
  double operator()() {
    double x = 0;
    noise::fill_normal(key_, next_++, {&x, 1});
    return x;
  }
  Vector3d of(const Vector3d& sigma) {
    Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = sigma[i] * (*this)();
    return v;
  }

 private:
  noise::StreamKey key_;
  std::uint64_t next_ = 0;
};

// What an aid measures at a place and time: `error` in its own components.
Fix measured(const Aid& aid, const earth::TrajectoryPoint& truth, const Vector3d& arm, const Vector3d& error) {
  const earth::Geodetic at = earth::to_geodetic(truth.pose.p_eb_e);
  const Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
  const Matrix3d C_enu = earth::C_e_enu(at.latitude, at.longitude);
  const Matrix3d C_eb = truth.pose.q_eb.toRotationMatrix();
  const Vector3d w_eb_b = truth.sensed.w_ib_b - C_eb.transpose() * Vector3d(0, 0, earth::wgs84::kEarthRate);
  Fix fix;
  switch (aid.kind) {
    case Aid::Kind::position:
      fix.value = truth.pose.p_eb_e + C_eb * arm + C_enu * error;
      break;
    case Aid::Kind::velocity:
      fix.value = C_en.transpose() * (truth.pose.v_eb_e + C_eb * w_eb_b.cross(arm) + C_enu * error);
      break;
    case Aid::Kind::height:
      fix.value = {at.height + error[0], 0, 0};
      break;
    case Aid::Kind::attitude:
      fix.q_nb = Eigen::Quaterniond(C_en).conjugate() * truth.pose.q_eb * earth::exp_rotation(error);
      break;
    case Aid::Kind::rest:
      break;
  }
  return fix;
}

}  // namespace

std::vector<Fix> simulated_fixes(const Aid& aid, int number, const earth::Trajectory& trajectory, std::uint64_t seed,
                                 std::uint64_t run, int clock) {
  check(aid);
  std::vector<Fix> fixes;
  if (aid.kind == Aid::Kind::rest) return fixes;
  Draws draw(number, seed, run);
  const Vector3d bias = draw.of(aid.bias_sigma), arm = aid.lever_arm + draw.of(aid.lever_arm_sigma);
  double drawn = draw();
  if (clock >= 0 && clock != number) {
    Draws owner(clock, seed, run);
    constexpr int kBefore = 6;  // bias and lever arm
    for (int i = 0; i <= kBefore; ++i) drawn = owner();
  }
  const double tag = aid.time_tag_sigma * drawn;
  Vector3d wander = draw.of(aid.correlated_sigma);
  const double phi = std::exp(-1 / (aid.rate * aid.correlation_time));
  const double end = trajectory.duration();
  for (std::int64_t k = 0;; ++k) {
    const double t = static_cast<double>(k) / aid.rate;
    if (t > end) break;
    if (k > 0) wander = phi * wander + draw.of(std::sqrt(1 - phi * phi) * aid.correlated_sigma);
    const Vector3d white = draw.of(aid.sigma);
    const bool out = std::ranges::any_of(aid.outages, [t](const Span& outage) { return outage.holds(t); });
    const double measured_at = t + tag;
    if (out || !aid.valid.holds(t) || measured_at < 0 || measured_at > end) continue;
    fixes.push_back(measured(aid, trajectory.at(measured_at), arm, bias + wander + white));
    fixes.back().stamp = std::llround((t - aid.time_tag) * noise::kNanosecondsPerSecond);
  }
  return fixes;
}

}  // namespace gyrobudget::inline v0::navigation
