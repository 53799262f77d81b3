// SPDX-License-Identifier: MIT
// The two parts a closed loop needs beside the vehicle: who tells where it is, and who says what to do.
#pragma once

#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <array>
#include <complex>
#include <concepts>
#include <vector>

#include "body.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::flight {

/// What a controller is told: navigation's pose of the IMU and the mean angular rate that the gyros measured
/// over the last period.
struct Seen {
  double t;  ///< after ignition [s]
  earth::Pose pose;
  Eigen::Vector3d w_ib_b;  ///< [rad/s]
};

/// Turns what is seen into a command, once a control period.
template <class C>
concept Controller = requires(C& controller, const Seen& seen) {
  { controller.command(seen) } -> std::convertible_to<Command>;
};

/// Turns exact increments of the IMU into a pose; errors of the sensors are its own affair.
///   void know(const earth::Pose& truth)           where it has it, it is told the truth before state()
///   const noise::ImuIncrement& sensed() const     where it has it, rates come from this, else exact ones
template <class N>
concept Navigator = requires(N& navigator, const N& asked, const noise::ImuIncrement& increment, double dt) {
  navigator.step(increment, dt);
  { asked.state() } -> std::convertible_to<earth::Pose>;
};

/// Tells the truth.
class PerfectNavigator {
 public:
  void step(const noise::ImuIncrement& /*exact*/, double /*dt*/) {}
  void know(const earth::Pose& truth) { truth_ = truth; }
  [[nodiscard]] const earth::Pose& state() const { return truth_; }

 private:
  earth::Pose truth_;
};

/// A filter that takes out a band, (s^2 + 2 depth s w + w^2)/(s^2 + 2 width s w + w^2), by the bilinear
/// transform with w kept in its place. At w it passes depth/width.
struct Notch {
  LookupTable frequency;  ///< over burn fraction [Hz]
  double depth = 0.05;
  double width = 0.5;
};

/// Which rate the damping acts on.
enum class RateFeedback {
  rate,        ///< the body's rate: lags a turning program by 2 damping/frequency seconds
  rate_error,  ///< against the program's: no lag while it turns evenly
};

struct AttitudeControlOptions {
  /// Pitch above the site's horizon over time [rad]; yaw and roll against the launch plane are zero.
  LookupTable pitch = LookupTable::linear({{8, 90 * earth::kDegree}, {83, 50 * earth::kDegree}});
  double azimuth = 90 * earth::kDegree;  ///< of the launch plane
  double frequency = 2.5;                ///< of the closed attitude loop [rad/s]
  double damping = 0.7;
  RateFeedback feedback = RateFeedback::rate_error;
  double least_thrust = 0.2;   ///< of the mean: gains are scheduled by no less
  std::vector<Notch> notches;  ///< at most 4
  double period = 0.01;        ///< of control [s]
};

/// Follows a program of attitude: acceleration wanted = w^2 error - 2 z w (rate - program's rate); nozzle =
/// that times inertia/(thrust arm), filtered. It knows the vehicle's tables, so its gains follow the nominal
/// thrust in vacuum, and not what a disturbed vehicle does. Rolls with the same frequency and damping.
///
/// Below least_thrust of the mean its gains no longer follow the thrust: the loop slows down as the thrust
/// fades. That is the last 1.6 s of the VLM-1, whose phase margin is still 30 degrees half a second before
/// burnout; after it attitude is kept by inertia. Up to there, over the flight (margins.h, nominal mode and
/// +-10 %): rigid 15.1 to 15.8 dB up, 9.0 dB down or more, 47 to 48 degrees; with the bending mode and one
/// notch on it 10.4 to 12.5 dB, 9.0 dB, 43 to 45 degrees. An IMU behind the mode's belly (slope_at_imu > 0)
/// makes the same loop unstable where the mode is 10 % below its notch.
class AttitudeControl {
 public:
  using Options = AttitudeControlOptions;

  /// @throws SetupError for a vehicle that fails its check, a frequency, damping, period or
  /// least_thrust that is not positive, too many notches, or a notch above half the control rate.
  AttitudeControl(const Vehicle& vehicle, const earth::Geodetic& site, const Options& options);

  [[nodiscard]] Command command(const Seen& seen) { return command(seen, reference(seen.t)); }
  /// Towards another attitude than the program's, which is to turn with the program's rate.
  [[nodiscard]] Command command(const Seen& seen, const Eigen::Quaterniond& q_eb_wanted);
  [[nodiscard]] Eigen::Quaterniond reference(double t) const;  ///< q_eb of the program
  [[nodiscard]] const Options& options() const { return options_; }
  /// Response of the filters at time t to angular frequency w [rad/s].
  [[nodiscard]] std::complex<double> filter_response(double t, double w) const;
  /// Nozzle deflection per angular acceleration wanted, in pitch and yaw [s^2].
  [[nodiscard]] Eigen::Vector2d gain(double t) const { return gain(burn_state(vehicle_, t)); }
  [[nodiscard]] const Vehicle& vehicle() const { return vehicle_; }  ///< as this control believes it to be

 private:
  static constexpr std::size_t kNotches = 4;
  struct Coefficients {
    double b0, b1, b2, a1, a2;
  };
  [[nodiscard]] Eigen::Vector2d gain(const BurnState& now) const;
  [[nodiscard]] Coefficients coefficients(const Notch& notch, double t) const;
  [[nodiscard]] Eigen::Vector2d filtered(const Eigen::Vector2d& input, double t);

  Vehicle vehicle_;
  Options options_;
  Eigen::Quaterniond q_el_;  ///< of downrange, right, down
  std::array<std::array<Eigen::Vector2d, 2>, kNotches> memory_;
};

}  // namespace gyrobudget::inline v0::flight
