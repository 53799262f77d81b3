// SPDX-License-Identifier: MIT
// What joins flight and navigation: a simulated IMU and what navigates on it, as navigator of the closed loop.
#pragma once

#include "gyrobudget/estimation/budget/simulated_navigator.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/flight/body.h"

#include <cstdint>
#include <limits>
#include <utility>

namespace gyrobudget::inline v0::closed_loop {

/// A flight::Navigator: the IMU's errors, alignment on the pad, strapdown or filter and its aids, all of one run of a
/// navigation scene whose timeline is the planned flight. Fixes are those of the flight as it goes, at the times that
/// the plan has. Periods of control are the IMU's samples.
///
/// Where the estimate leaves what can be computed (navigation::Diverged, earth::OutsideDomain), it tells numbers that
/// are none from there on, and the flight ends as flight::Ended::not_finite.
class InertialNavigator {
 public:
  /// Up to ignition. @throws std::invalid_argument as budget::SimulatedNavigator.
  InertialNavigator(budget::SimulatedScene scene, std::uint64_t run) : inside_(std::move(scene), run) {
    as_long_as_it_can([&] { inside_.pass_pad(); });
  }

  void step(const noise::ImuIncrement& exact, double dt) {
    dt_ = dt;
    as_long_as_it_can([&] { inside_.step(exact); });
  }
  void know(const earth::Pose& truth) {
    if (dt_ > 0 && inside_.fix_due()) as_long_as_it_can([&] { inside_.use_fixes(motion(truth)); });
    v_eb_e_ = truth.v_eb_e;
    q_eb_ = truth.q_eb;
  }
  [[nodiscard]] const earth::Pose& state() const { return diverged_ ? kNoState : inside_.state(); }
  [[nodiscard]] const noise::ImuIncrement& sensed() const { return inside_.sensed(); }
  [[nodiscard]] const budget::SimulatedNavigator& inside() const { return inside_; }
  [[nodiscard]] bool diverged() const { return diverged_; }

 private:
  template <class Work>
  void as_long_as_it_can(const Work& work) {
    if (diverged_) return;
    try {
      work();
    } catch (const navigation::Diverged&) {
      diverged_ = true;
    } catch (const earth::OutsideDomain&) {
      diverged_ = true;
    }
  }

  // Rate and acceleration are means over the last period, of the truth, whatever the gyros sense of it.
  [[nodiscard]] earth::Motion motion(const earth::Pose& truth) const {
    return {.pose = truth,
            .a_eb_e = (truth.v_eb_e - v_eb_e_) / dt_,
            .w_eb_b = earth::log_rotation(q_eb_.conjugate() * truth.q_eb) / dt_};
  }

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  static inline const earth::Pose kNoState{.p_eb_e = Eigen::Vector3d::Constant(kNone),
                                           .v_eb_e = Eigen::Vector3d::Constant(kNone),
                                           .q_eb = Eigen::Quaterniond(kNone, 0, 0, 0)};

  budget::SimulatedNavigator inside_;
  Eigen::Vector3d v_eb_e_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_eb_ = Eigen::Quaterniond::Identity();
  double dt_ = 0;
  bool diverged_ = false;
};

}  // namespace gyrobudget::inline v0::closed_loop
