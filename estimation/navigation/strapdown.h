// SPDX-License-Identifier: MIT
// From what an IMU delivers to position, velocity and attitude.
// Sources: Savage, Strapdown Analytics (2000), chapter 7; Groves (2013), chapter 5; Blanes, Casas, Oteo & Ros,
// The Magnus expansion and some of its applications, Physics Reports 470:151 (2009), section 5.
#pragma once

#include "gyrobudget/earth/trajectory.h"

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {

/// Where a body is, how it moves and how it is turned, against the turning Earth.
struct NavigationState {
  Eigen::Vector3d p_eb_e;   ///< [m]
  Eigen::Vector3d v_eb_e;   ///< [m/s]
  Eigen::Quaterniond q_eb;  ///< unit
};

class Strapdown {
 public:
  static constexpr int kHighestOrder = 8;

  struct Options {
    /// Number of increments, the present one included, whose polynomial stands for rate and specific force
    /// within a step: 1 to kHighestOrder.
    int order = 4;
    /// False leaves Earth's rate out of the attitude, as a source of error to be studied.
    bool earth_rate_in_attitude = true;
  };

  /// @throws std::invalid_argument for an order out of range, a number that is not finite, a quaternion whose
  /// norm is off 1 by more than 1e-6, or a position nearer to Earth's centre than 1000 km.
  explicit Strapdown(const NavigationState&, const Options&);
  explicit Strapdown(const NavigationState& state) : Strapdown(state, Options{}) {}

  /// Advances by one interval of dt seconds, which may differ from step to step. dt = 0 changes nothing.
  /// @throws std::invalid_argument where dt is negative or not finite, an increment is not finite, and where the
  /// position leaves the domain of earth::normal_gravitation; the state is then the one before.
  void step(const earth::ImuIncrement&, double dt);

  [[nodiscard]] const NavigationState& state() const { return state_; }
  /// Replaces the state, as after a filter's correction; the history of increments is kept.
  /// @throws as the constructor.
  void set_state(const NavigationState&);

  /// Mean of C_eb f_ib_b over the last step [m/s^2], in the axes of e at its start; zero before the first.
  [[nodiscard]] const Eigen::Vector3d& last_specific_force_e() const { return specific_force_e_; }

 private:
  using Rates = Eigen::Matrix<double, 6, 1>;  ///< angular rate, specific force

  void remember(const earth::ImuIncrement&, double dt);

  Options options_;
  NavigationState state_;
  Eigen::Vector3d p_rest_ = Eigen::Vector3d::Zero();  ///< of p_eb_e, below its last digit
  Eigen::Vector3d gravitation_;                       ///< of the last step, in ECEF axes
  Eigen::Vector3d specific_force_e_ = Eigen::Vector3d::Zero();
  std::array<Rates, kHighestOrder> differences_;   ///< divided, of the means over the last intervals
  std::array<double, kHighestOrder> intervals_{};  ///< the last first
  int known_ = 0;                                  ///< increments in the history
};

}  // namespace gyrobudget::inline v0::navigation
