// SPDX-License-Identifier: MIT
// Inside navigation: how far a vehicle's motion may have gone from the straight line that bridges a gap of its IMU log.
//
// A gap of length T is bridged by rates that run straight from the sample before it to the sample after. How wrong the
// mean of such a bridge is the log itself tells: in stretches of length T around the gap, where the samples are there,
//   e = (mean of the samples) - (sample before + sample after)/2
// has a mean square s^2, for each axis of rate and of specific force. It is taken from where the log is sound within
// ten lengths of the gap to either side (1 s at least), T/4 apart, at most a hundred. Nothing is assumed of how the
// motion is correlated: vibration that averages out over T counts as little as it should, a turn that lasts longer as
// much.
//
// e is one random constant over the gap: after t it has made a velocity of variance s^2 t^2. White noise of density
// s^2 T makes s^2 T t: as much at the end of the gap, more within it, and of the position 4/3 of s^2 T^4/4. It needs
// no state, and fixes within the gap may be used.
#pragma once

#include "gyrobudget/estimation/navigation/recording.h"

#include <cstddef>
#include <vector>

namespace gyrobudget::inline v0::navigation::detail {

/// White noise that stands for motion that was not measured, body axes.
struct UnknownMotion {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< [rad/sqrt(s)]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< [m/s/sqrt(s)]
  /// As StepInput::unknown.
  [[nodiscard]] Eigen::Matrix<double, 6, 1> density() const {
    Eigen::Matrix<double, 6, 1> both;
    both << rate.cwiseAbs2(), force.cwiseAbs2();
    return both;
  }
};

/// The gaps of a log.
class Gaps {
 public:
  explicit Gaps(const ImuLog& log);

  /// That of the gap to which an interval belongs; nullptr where it holds a sample.
  [[nodiscard]] const UnknownMotion* at(std::size_t interval) const;

 private:
  struct Gap {
    std::size_t from, to;  ///< intervals; the last is not its own
    UnknownMotion motion;
  };
  std::vector<Gap> gaps_;  ///< ascending
};

}  // namespace gyrobudget::inline v0::navigation::detail
