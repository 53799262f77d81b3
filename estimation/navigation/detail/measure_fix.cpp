// SPDX-License-Identifier: MIT
#include "measure_fix.h"

#include "gyrobudget/vehicle/earth/frames.h"

#include <algorithm>
#include <stdexcept>

#include "fix_track.h"

namespace gyrobudget::inline v0::navigation::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Measurement measure_fix(const Aid& aid, int number, const Fix& fix, const Estimate& estimate, const Vector3d& sigma) {
  const Vector3d& p = estimate.motion.pose.p_eb_e;
  const earth::Geodetic at = earth::to_geodetic(p);
  const Matrix3d C_enu = earth::C_e_enu(at.latitude, at.longitude);
  switch (aid.kind) {
    case Aid::Kind::position:
      return measure(PositionFix{fix.value, sigma, C_enu, aid.lever_arm, number}, estimate);
    case Aid::Kind::velocity:
    case Aid::Kind::rest:
      return measure(VelocityFix{to_ecef_axes(fix.value, p), sigma, C_enu, aid.lever_arm, number}, estimate);
    case Aid::Kind::height:
      return measure(HeightFix{fix.value[0], sigma[0], number}, estimate);
    case Aid::Kind::attitude:
      return measure(AttitudeFix{to_ecef_axes(fix.q_nb, p), sigma, number}, estimate);
  }
  throw std::invalid_argument("an aid of no known kind");
}

bool in_use(const Aid& aid, double t) {
  return aid.valid.holds(t) && std::ranges::none_of(aid.outages, [&](const Span& outage) { return outage.holds(t); });
}

}  // namespace gyrobudget::inline v0::navigation::detail
