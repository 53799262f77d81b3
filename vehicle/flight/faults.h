// SPDX-License-Identifier: MIT
// What may be wrong between a navigator and the controller that listens to it.
#pragma once

#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstddef>
#include <optional>
#include <vector>

#include "control.h"

namespace gyrobudget::inline v0::flight {

struct NavigatorFaults {
  std::optional<int> dead_gyro;  ///< body axis, 0 to 2, that senses no turn ...
  double dead_gyro_at = 0;       ///< ... from here on [s]
  double delay = 0;              ///< position, velocity and attitude are told so much later [s]
};

/// How many periods the delay is, rounded.
/// @throws SetupError for an axis that there is not, a time that is not a number, a delay below 0 or
/// above 1e6 periods.
[[nodiscard]] std::size_t check(const NavigatorFaults& faults, double period);

namespace detail {

/// What fly() puts between navigator and controller: a navigator with faults. The one inside must outlive it. Without
/// faults it is as the one inside. Allocates in the beginning only.
template <Navigator N>
class Faulty {
 public:
  /// @throws SetupError as check().
  Faulty(N& inside, const NavigatorFaults& faults, double period)
      : inside_(inside), faults_(faults), late_(check(faults, period) + 1) {}

  void step(const noise::ImuIncrement& exact, double dt) {
    noise::ImuIncrement damaged = exact;
    if (faults_.dead_gyro && t_ >= faults_.dead_gyro_at)
      damaged.angle[static_cast<std::size_t>(*faults_.dead_gyro)] = 0;
    inside_.step(damaged, dt);
    if constexpr (!requires { inside_.sensed(); }) sensed_ = damaged;
    t_ += dt;
    told_ = false;
  }
  void know(const earth::Pose& truth) {
    if constexpr (requires { inside_.know(truth); }) inside_.know(truth);
    tell();
  }
  [[nodiscard]] const earth::Pose& state() const { return now_; }
  [[nodiscard]] const noise::ImuIncrement& sensed() const {
    if constexpr (requires { inside_.sensed(); })
      return inside_.sensed();
    else
      return sensed_;
  }

 private:
  // Once a period: what was told a delay ago, and in the beginning the first.
  void tell() {
    if (told_) return;
    told_ = true;
    const earth::Pose present = inside_.state();
    if (count_ == 0) late_.assign(late_.size(), present);
    late_[count_ % late_.size()] = present;
    ++count_;
    now_ = late_[count_ % late_.size()];
  }

  N& inside_;
  NavigatorFaults faults_;
  std::vector<earth::Pose> late_;
  earth::Pose now_;
  std::size_t count_ = 0;
  noise::ImuIncrement sensed_;
  double t_ = 0;
  bool told_ = false;
};

}  // namespace detail

}  // namespace gyrobudget::inline v0::flight
