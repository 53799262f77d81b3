// SPDX-License-Identifier: MIT
// The actuator in closed form over an interval with a constant command.
#pragma once

#include "gyrobudget/vehicle/flight/vehicle.h"

#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace gyrobudget::inline v0::flight::detail {

/// x = (d - command, d'), x' = A x, A = [0 1; -w^2 -2zw].
class ActuatorStep {
 public:
  ActuatorStep() = default;
  ActuatorStep(const Actuator& actuator, double h) : h_(h) {
    const double w = 2 * std::numbers::pi * actuator.frequency;
    const double damping = actuator.damping * w;
    const Eigen::Matrix2d a{{0, 1}, {-w * w, -2 * damping}};
    const Eigen::Matrix2d inverse{{-2 * damping / (w * w), -1 / (w * w)}, {1, 0}};
    const auto [cosine, sine] = exponentials(w, actuator.damping, h);
    transition_ = cosine * Eigen::Matrix2d::Identity() + sine * (a + damping * Eigen::Matrix2d::Identity());
    const Eigen::Matrix2d integral = inverse * (transition_ - Eigen::Matrix2d::Identity());
    const Eigen::Matrix2d moment = inverse * (h * transition_ - integral);
    slope_ = (12 * moment.row(0) - 6 * h * integral.row(0)) / (h * h * h);
    offset_ = integral.row(0) / h - slope_ * (h / 2);
  }

  [[nodiscard]] double h() const { return h_; }
  [[nodiscard]] Eigen::Vector2d advance(const Eigen::Vector2d& x) const { return transition_ * x; }
  /// The straight line offset + slope t whose integrals with 1 and t over the step are those of the true
  /// motion, however fast it is.
  [[nodiscard]] double offset(const Eigen::Vector2d& x) const { return offset_.dot(x); }
  [[nodiscard]] double slope(const Eigen::Vector2d& x) const { return slope_.dot(x); }

 private:
  /// exp(-z w h) times cos(w_d h) and sin(w_d h)/w_d, or their hyperbolic or critical kin.
  static std::pair<double, double> exponentials(double w, double z, double h) {
    const double discriminant = 1 - z * z;
    if (std::abs(discriminant) < 1e-12) return {std::exp(-z * w * h), h * std::exp(-z * w * h)};
    const double wd = w * std::sqrt(std::abs(discriminant));
    if (discriminant > 0) {
      const double decay = std::exp(-z * w * h);
      return {decay * std::cos(wd * h), decay * std::sin(wd * h) / wd};
    }
    const double slow = std::exp((wd - z * w) * h), fast = std::exp((-wd - z * w) * h);
    return {(slow + fast) / 2, (slow - fast) / (2 * wd)};
  }

  double h_ = 0;
  Eigen::Matrix2d transition_;
  Eigen::RowVector2d offset_, slope_;
};

}  // namespace gyrobudget::inline v0::flight::detail
