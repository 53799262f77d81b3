// SPDX-License-Identifier: MIT
// Truth as a value: where a vehicle is, how it is turned, and what an ideal IMU fixed to it senses.
// Sources: Groves (2013), chapters 2 and 5; Titterton & Weston (2004), chapter 3; Savage, Strapdown Analytics
// (2000).
#pragma once

#include "gyrobudget/noise/increment.h"

#include <memory>
#include <vector>

#include "pose.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::earth {

/// What an ideal IMU senses at an instant.
struct Sensed {
  Eigen::Vector3d f_ib_b;  ///< specific force [m/s^2]
  Eigen::Vector3d w_ib_b;  ///< angular rate [rad/s]
};

/// What an IMU senses on that motion, on the rotating Earth with normal gravity:
///   f_ib_b = C_be (a_eb_e + 2 w_ie x v_eb_e - g(p_eb_e)),  w_ib_b = w_eb_b + C_be w_ie.
[[nodiscard]] Sensed sense(const Motion& motion);

/// A motion as a function of time. Those of paths.h and sampled.h suit most; derive from this for another.
class Path {
 public:
  Path() = default;
  Path(const Path&) = delete;
  Path& operator=(const Path&) = delete;
  virtual ~Path() = default;

  /// Valid from 0 to duration() [s].
  [[nodiscard]] virtual double duration() const = 0;
  [[nodiscard]] virtual Motion at(double t) const = 0;
  /// sense(at(t)), or the same known more directly.
  [[nodiscard]] virtual Sensed sensed(double t) const;
  /// Where acceleration or angular rate, or a derivative of one, jumps; ascending.
  [[nodiscard]] virtual std::vector<double> breaks() const { return {}; }
  /// Highest angular frequency of what is sensed between the breaks [rad/s], positive: it sets the
  /// quadrature.
  [[nodiscard]] virtual double fastest() const = 0;
};

/// The pose at one time and what is sensed then.
struct TrajectoryPoint {
  double t;  ///< [s]
  Pose pose;
  Sensed sensed;
};

/// A path with its IMU. Cheap to copy, immutable, and safe to read from many threads.
///
///   const earth::Trajectory flight = earth::ascent({});      // 83 s from Alcantara
///   const auto at_burnout = flight.at(flight.duration());
///   const auto imu = flight.increments(0.01);                // 100 Hz
class Trajectory {
 public:
  /// @throws std::invalid_argument for no path, a duration that is not positive, a highest frequency that is not, or is
  /// above 1e6 rad/s, and a speed at start or end that light does not have.
  explicit Trajectory(std::shared_ptr<const Path> path);

  [[nodiscard]] double duration() const { return duration_; }  ///< [s]; it starts at 0
  /// Times inside at which what is sensed, or its derivative, jumps; ascending.
  [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }

  /// @throws std::invalid_argument for a time outside 0 to duration().
  [[nodiscard]] TrajectoryPoint at(double t) const;

  /// Integrals from `from` to `to` by Gauss-Legendre quadrature, 7 points a panel (3 where it is below
  /// 0.02/fastest() and 1/50 of the way between breaks), panels ending at breaks and no longer than
  /// 1/fastest(). A sinusoid of twice that frequency is integrated to 2e-15 of its amplitude times the
  /// interval. Sensed sums over intervals are those over their union, to rounding.
  /// @throws std::invalid_argument where from, to are outside the trajectory or to < from, or the sum is not finite.
  [[nodiscard]] noise::ImuIncrement increment(double from, double to) const;

  /// All whole intervals from time 0: increments k has [k interval, (k + 1) interval]; a rest shorter than an
  /// interval is left out. 48 bytes each; increment() itself serves streams.
  /// @throws std::invalid_argument for an interval that is not positive or holds more than 2^31 of them.
  [[nodiscard]] std::vector<noise::ImuIncrement> increments(double interval) const;

 private:
  void check_time(double t) const;

  std::shared_ptr<const Path> path_;
  double duration_ = 0;
  double panel_ = 0;
  std::vector<double> breaks_;
};

}  // namespace gyrobudget::inline v0::earth
