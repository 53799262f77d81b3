// SPDX-License-Identifier: MIT
// What joins flight and navigation: a simulated IMU and what navigates on it, as navigator of the closed loop.
#pragma once

#include "gyrobudget/earth/ellipsoid.h"
#include "gyrobudget/flight/body.h"
#include "gyrobudget/navigation/simulated_navigator.h"

#include <cstdint>

namespace gyrobudget::inline v0::closed_loop {

/// A flight::Navigator: the IMU's errors, alignment on the pad, strapdown or filter and its aids, all of one run of a
/// navigation scene whose timeline is the planned flight. Fixes are those of the flight as it goes, at the times that the
/// plan has. Periods of control are the IMU's samples.
class InertialNavigator {
 public:
  /// Up to ignition. @throws std::invalid_argument as SimulatedNavigator.
  InertialNavigator(const navigation::SimulatedScene& scene, std::uint64_t run) : inside_(scene, run) {
    inside_.pass_pad();
  }

  void step(const earth::ImuIncrement& exact, double dt) {
    exact_ = exact;
    dt_ = dt;
    inside_.step(exact);
  }
  void know(const flight::Body::Pose& truth) {
    if (dt_ > 0 && inside_.fix_due()) inside_.use_fixes(instant(truth));
    v_eb_e_ = truth.v_eb_e;
  }
  [[nodiscard]] const navigation::NavigationState& state() const { return inside_.state(); }
  [[nodiscard]] const earth::ImuIncrement& sensed() const { return inside_.sensed(); }
  [[nodiscard]] const navigation::SimulatedNavigator& inside() const { return inside_; }

 private:
  // Rate and acceleration are means over the last period.
  [[nodiscard]] navigation::Timeline::Instant instant(const flight::Body::Pose& truth) const {
    const Eigen::Vector3d w_ie_b = truth.q_eb.conjugate() * Eigen::Vector3d(0, 0, earth::wgs84::kEarthRate);
    return {{truth.p_eb_e, truth.v_eb_e, truth.q_eb},
            exact_.angle / dt_ - w_ie_b,
            (truth.v_eb_e - v_eb_e_) / dt_};
  }

  navigation::SimulatedNavigator inside_;
  earth::ImuIncrement exact_{};
  Eigen::Vector3d v_eb_e_ = Eigen::Vector3d::Zero();
  double dt_ = 0;
};

}  // namespace gyrobudget::inline v0::closed_loop
