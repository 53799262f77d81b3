// SPDX-License-Identifier: MIT
// What a wrong attitude does to a flight, to first order: the closed form beside the flights themselves.
#pragma once

#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::closed_loop {

/// How a flight answers to a small turn of its attitude against the one that it should have.
///
/// With psi(t) the rotation vector by which the nose is commanded off (e axes), f the specific force, V the speed, x
/// the nose, P the projector across it and L = q S C_Na/V the lateral force per lateral velocity, departures grow by
///   dp' = dv,   dv' = phi x f + (1 + h/l) (L/m) P (phi x v - dv),
///   P phi (1 - k V) = P psi - k x x dv,   k = h L/(I w^2 T/T_vac).
/// phi is what is flown: the attitude loop has no integral part (frequency w, moment of inertia I), so it gives way to
/// the moment that air exerts on the lever h between centre of pressure and centre of mass; to hold it, the nozzle, l
/// behind the centre of mass, pushes h/l times the air's force to the same side. Changes of drag, of air with height,
/// of gravity with place and the loop's own transients are left out: against flights of the VLM-1, 2.5 % of a distance
/// and
/// 5.5 % across it, where nothing saturates.
class TiltResponse {
 public:
  /// Along the plan's nominal flight, whose record it keeps. @throws std::invalid_argument as fly_nominal().
  explicit TiltResponse(const flight::Plan& plan);

  using Tilt = std::function<Eigen::Vector3d(double t)>;
  /// Departure at the end in e axes [m]; psi in rad, e axes.
  [[nodiscard]] Eigen::Vector3d position(const Tilt& psi) const;
  /// The nominal flight less one that has its nose on the program and its nozzle straight (fly_point_mass).
  [[nodiscard]] Eigen::Vector3d position_of_standing_error() const;
  /// Covariance of the departure in e axes, by white noise, random walk of the rate from zero at the start, and
  /// turn-on bias of the gyros, each axis on its own; what else the model holds is passed over. The loop flies what
  /// navigation takes for its program.
  [[nodiscard]] Eigen::Matrix3d covariance(const noise::ErrorModel& gyro) const;
  /// Points are 10 periods apart.
  [[nodiscard]] const flight::FlightRecord& nominal() const { return nominal_; }
  /// Of the axis of pitch, to the right, e axes, at a time of the flight.
  [[nodiscard]] Eigen::Vector3d pitch_axis(double t) const { return point(t).C.col(1); }

 private:
  struct Point {
    Eigen::Matrix3d C;     ///< C_eb
    Eigen::Vector3d v, f;  ///< [m/s, m/s^2], e axes; f is the mean up to the next point
    double lateral;        ///< L/m [1/s]
    double trim;           ///< h/l
    double yielding;       ///< k [s/m]
    [[nodiscard]] Eigen::Vector3d across(const Eigen::Vector3d& u) const { return u - C.col(0).dot(u) * C.col(0); }
  };
  [[nodiscard]] const Point& point(double t) const;
  [[nodiscard]] Eigen::Vector3d answer(const Tilt& psi, std::size_t from = 0) const;

  flight::FlightRecord nominal_;
  std::vector<Point> points_;
  double step_ = 0;
};

}  // namespace gyrobudget::inline v0::closed_loop
