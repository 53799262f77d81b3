// SPDX-License-Identifier: MIT
// Mass and thrust over time in closed form: propellant used is the integral of the thrust's shape, so no mass
// is integrated numerically.
#pragma once

#include "gyrobudget/vehicle/flight/vehicle.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace gyrobudget::inline v0::flight::detail {

class Burn {
 public:
  Burn(const Vehicle& vehicle, double cut_at)
      : v_(vehicle),
        end_(std::min(cut_at, vehicle.burn_time)),
        rate_(1 / (vehicle.burn_time * vehicle.thrust_shape.integral(1))),
        thrust_(vehicle.specific_impulse * kStandardGravity * vehicle.propellant) {}

  /// A stretch of time over which all is smooth.
  struct Piece {
    std::size_t shape;
    bool burning;
  };
  struct Now {
    double used;            ///< propellant fraction
    double used_rate;       ///< [1/s]
    double mass;            ///< [kg]
    double thrust;          ///< in vacuum [N]
    double centre_of_mass;  ///< station [m]
    double cm_velocity;     ///< its derivatives by time [m/s], [m/s^2]
    double cm_acceleration;
  };

  [[nodiscard]] Piece piece(double t) const {
    return {v_.thrust_shape.piece(std::min(t, end_) / v_.burn_time), t >= 0 && t < end_};
  }
  [[nodiscard]] Now at(double t, const Piece& piece) const {
    const double fraction = std::clamp(t, 0.0, end_) / v_.burn_time;
    const LookupTable::Jet shape = v_.thrust_shape.at(fraction, piece.shape);
    const double flow = piece.burning ? shape.value * rate_ : 0;  // of the propellant fraction [1/s]
    const double flow_rate = piece.burning ? shape.first * rate_ / v_.burn_time : 0;
    const double used = v_.thrust_shape.integral(fraction, piece.shape) * rate_ * v_.burn_time;
    const LookupTable::Jet cm = v_.centre_of_mass.at(std::min(used, 1 - 1e-15));
    return {used,
            flow,
            v_.lift_off_mass - v_.propellant * used,
            thrust_ * flow,
            cm.value,
            cm.first * flow,
            cm.second * flow * flow + cm.first * flow_rate};
  }
  /// Instants at which thrust, or its derivative, jumps: ascending.
  [[nodiscard]] std::vector<double> breaks() const {
    std::vector<double> times{0};
    for (const auto& point : v_.thrust_shape.points()) {
      const double t = point.first * v_.burn_time;
      if (t > 0 && t < end_) times.push_back(t);
    }
    times.push_back(end_);
    return times;
  }
  [[nodiscard]] double end() const { return end_; }

 private:
  const Vehicle& v_;
  double end_;
  double rate_;    ///< propellant fraction per second where the shape is 1
  double thrust_;  ///< per propellant fraction and second [N s]
};

}  // namespace gyrobudget::inline v0::flight::detail
