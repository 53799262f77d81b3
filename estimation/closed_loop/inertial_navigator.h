// SPDX-License-Identifier: MIT
// What joins flight and navigation: a simulated IMU and what navigates on it, as navigator of the closed loop.
#pragma once

#include "gyrobudget/estimation/budget/simulated_navigator.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/flight/body.h"

#include <cstdint>

namespace gyrobudget::inline v0::closed_loop {

/// A flight::Navigator: the IMU's errors, alignment on the pad, strapdown or filter and its aids, all of one run of a
/// navigation scene whose timeline is the planned flight. Fixes are those of the flight as it goes, at the times that the
/// plan has. Periods of control are the IMU's samples.
class InertialNavigator {
 public:
  /// Up to ignition. @throws std::invalid_argument as SimulatedNavigator.
  InertialNavigator(const budget::SimulatedScene& scene, std::uint64_t run) : inside_(scene, run) {
    inside_.pass_pad();
  }

  void step(const noise::ImuIncrement& exact, double dt) {
    dt_ = dt;
    inside_.step(exact);
  }
  void know(const earth::Pose& truth) {
    if (dt_ > 0 && inside_.fix_due()) inside_.use_fixes(motion(truth));
    v_eb_e_ = truth.v_eb_e;
    q_eb_ = truth.q_eb;
  }
  [[nodiscard]] const earth::Pose& state() const { return inside_.state(); }
  [[nodiscard]] const noise::ImuIncrement& sensed() const { return inside_.sensed(); }
  [[nodiscard]] const budget::SimulatedNavigator& inside() const { return inside_; }

 private:
  // Rate and acceleration are means over the last period, of the truth, whatever the gyros sense of it.
  [[nodiscard]] earth::Motion motion(const earth::Pose& truth) const {
    return {.pose = truth,
            .a_eb_e = (truth.v_eb_e - v_eb_e_) / dt_,
            .w_eb_b = earth::log_rotation(q_eb_.conjugate() * truth.q_eb) / dt_};
  }

  budget::SimulatedNavigator inside_;
  Eigen::Vector3d v_eb_e_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_eb_ = Eigen::Quaterniond::Identity();
  double dt_ = 0;
};

}  // namespace gyrobudget::inline v0::closed_loop
