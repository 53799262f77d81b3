// SPDX-License-Identifier: MIT
// From what an IMU delivers to position, velocity and attitude.
// Sources: Savage, Strapdown Analytics (2000), chapter 7; Groves (2013), chapter 5; Blanes, Casas, Oteo &
// Ros, The Magnus expansion and some of its applications, Physics Reports 470:151 (2009), section 5.
#pragma once

#include "gyrobudget/vehicle/earth/trajectory.h"

#include <array>

#include "errors.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {

/// Integrates increments of an IMU in Earth-centred, Earth-fixed axes: no latitude, no Euler angle and so
/// no place or attitude that is special, with normal gravity. A step takes place in inertial axes,
///   C' = C [w_ib_b x],  v' = C f_ib_b + g(p),  p' = v,
/// and turns back with Earth exactly. Within it, rates and specific forces are the polynomial through the
/// last `order` increments, and attitude, velocity and position follow together from one exponential of its
/// Magnus series, so that coning, sculling and scrolling are one formula. Rates and forces that are
/// constant in body axes are integrated exactly, at any angle. Gravitation is evaluated once a step, in its
/// middle: its error grows with dt^2 and is 1e-11 m/s^2 at 0.1 s and 300 m/s.
///
/// The first `order` - 1 steps are redone as the history fills, each with the polynomial through all of it,
/// unless the state was set meanwhile. An interval more than 4 times longer or shorter than the last begins
/// a new history. Where a step turns by more than 1 rad it is taken with order 1, for what is fixed in
/// space then turns too fast in body axes for any polynomial. A jump in rate or force costs its size times
/// dt^2/12, once, at any order.
///
/// **Which order.** Error against run time (tests/bench/strapdown_benchmark, 1000 s at 300 m/s, S-turns of 0.5 g, 1
/// degree of coning and 0.2 g of sculling at 5 Hz; error of position in metres, nanoseconds a step on one core of an
/// EPYC):
///   order                    1         2         3         4         5         6         7         8
///   100 Hz              1.1e+5    2.2e+3    3.2e+3       312       158        30       7.8       2.7
///   200 Hz              2.8e+4       140       209       5.0       2.8      0.13     0.043     0.003
///   400 Hz              7.1e+3       8.8        13     0.079     0.046    5.1e-4    1.8e-4    4.1e-6
///   nanoseconds            135       157       159       219       224       255       262       268
/// Each pair of orders gains two powers of the step on slow coning and sculling. What an order leaves of faster ones,
/// as a share of what order 1 leaves, by their frequency over the sample rate (the same for coning and sculling up to
/// 1/3):
///   order                    1         2         3         4         5         6         7         8
///   1/10                     1     0.077     0.099     0.039     0.011     0.012    0.0010    0.0029
///   1/5                      1      0.28      0.21      0.37      0.20     0.095      0.28      0.23
///   1/4                      1      0.42      0.17      0.60      0.66      0.30      0.36      0.98
///   1/3                      1      0.65      0.12      0.63       1.5       2.3       2.7       2.1
///   worst, up to 1/2         1        <1        <1        <1       1.5       2.9       5.4       9.6
/// The default, 4, is the highest order that never does worse than order 1, whatever vibrates. Orders 5 to 8 are for
/// sensors whose band ends below a fifth of the sample rate: order 8 leaves less than a tenth of what order 4 does at a
/// tenth of that rate, and a thousandth at a fortieth, for a fifth more run time. Above a quarter of the rate these
/// orders make drift out of vibration.
///
/// The vertical channel is unstable by nature: an error in height grows e-fold every sqrt(R/2g) = 570 s.
///
///   navigation::Strapdown strapdown({p_eb_e, v_eb_e, q_eb});
///   for (const noise::ImuIncrement& increment : imu) strapdown.step(increment, 0.005);
///   const earth::Geodetic place = earth::to_geodetic(strapdown.state().p_eb_e);
class Strapdown {
 public:
  static constexpr int kHighestOrder = 8;

  struct Options {
    /// Number of increments, the present one included, whose polynomial stands for rate and specific force
    /// within a step: 1 to kHighestOrder.
    int order = 4;
    /// False leaves Earth's rate out of the attitude, as a source of error to be studied: 0.347 degrees in
    /// 83 s.
    bool earth_rate_in_attitude = true;
  };

  /// @throws SetupError for an order out of range; std::invalid_argument for a velocity that is not finite or a
  /// quaternion whose norm is off 1 by more than 1e-6; earth::OutsideDomain for a position nearer to Earth's centre
  /// than 1000 km or not finite.
  explicit Strapdown(const earth::Pose& state, const Options& options);
  explicit Strapdown(const earth::Pose& state) : Strapdown(state, Options{}) {}

  /// Advances by one interval of dt seconds, which may differ from step to step. dt = 0 changes nothing.
  /// Allocates nothing.
  /// @throws std::invalid_argument where dt is negative or not finite or an increment is not finite;
  /// earth::OutsideDomain where the position leaves the domain of earth::normal_gravitation. The state is then the one
  /// before.
  void step(const noise::ImuIncrement& imu, double dt);

  [[nodiscard]] const earth::Pose& state() const { return now_.state; }
  /// Replaces the state, as after a filter's correction; the history of increments is kept.
  /// @throws as the constructor.
  void set_state(const earth::Pose& state);

  /// Mean of C_eb f_ib_b over the last step [m/s^2], in the axes of e at its start; zero before the first.
  [[nodiscard]] const Eigen::Vector3d& last_specific_force_e() const { return specific_force_e_; }

 private:
  using Rates = Eigen::Matrix<double, 6, 1>;  ///< angular rate, specific force
  template <typename T>
  using History = std::array<T, kHighestOrder>;

  struct Increment {
    Rates sum;
    double dt;
  };
  /// The state with what its last digits leave over.
  struct Sum {
    earth::Pose state;
    Eigen::Vector3d p_rest = Eigen::Vector3d::Zero();
    Eigen::Vector4d q_rest = Eigen::Vector4d::Zero();
    Eigen::Vector3d gravitation;  ///< amid the last step, in ECEF axes
  };
  struct Polynomial;

  void remember(const Increment& increment);
  void advance(Sum& sum, const Increment& increment, const Polynomial& polynomial);
  void redo();

  Options options_;
  Sum now_;
  Eigen::Vector3d specific_force_e_ = Eigen::Vector3d::Zero();
  int known_ = 0;                 ///< increments in the history
  History<Rates> differences_{};  ///< divided, of the integral of the rates over the last intervals
  History<double> intervals_{};   ///< the last first
  // While the history fills:
  bool may_redo_ = false;
  Sum start_;                   ///< where it begins
  History<Increment> first_{};  ///< the first first
};

}  // namespace gyrobudget::inline v0::navigation
