// SPDX-License-Identifier: MIT
#include "control.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

void check_positive(double value, const char* what, const char* unit) {
  if (!(value > 0) || !std::isfinite(value))
    throw SetupError(fmt::format("{} is {} {}, but must be positive", what, value, unit));
}

}  // namespace

AttitudeControl::AttitudeControl(const Vehicle& vehicle, const earth::Geodetic& site, const Options& options)
    : vehicle_(vehicle),
      options_(options),
      q_el_(Quaterniond(earth::C_e_ned(site.latitude, site.longitude)) * earth::exp_rotation({0, 0, options.azimuth})) {
  vehicle.check();
  check_positive(options.frequency, "frequency of the attitude loop", "rad/s");
  check_positive(options.damping, "damping of the attitude loop", "");
  check_positive(options.period, "control period", "s");
  check_positive(options.least_thrust, "least thrust of the schedule", "of the mean");
  if (options.notches.size() > kNotches)
    throw SetupError(
        fmt::format("{} notches were asked for, but at most {} are kept", options.notches.size(), kNotches));
  for (const Notch& notch : options.notches) {
    check_positive(notch.frequency.range().first, "frequency of a notch", "Hz");
    check_positive(notch.width, "width of a notch", "");
    if (notch.frequency.range().second >= 0.5 / options.period)
      throw SetupError(fmt::format("a notch at {} Hz must be below half the control rate, {} Hz",
                                   notch.frequency.range().second, 0.5 / options.period));
  }
  for (auto& pair : memory_) pair.fill(Vector2d::Zero());
}

Quaterniond AttitudeControl::reference(double t) const {
  return q_el_ * earth::exp_rotation({0, options_.pitch(t), 0});
}

Vector2d AttitudeControl::gain(const BurnState& now) const {
  const double mean = vehicle_.mean_thrust();
  if (!(mean > 0) || !(now.centre_of_mass > 0)) return Vector2d::Zero();
  const double moment = std::max(now.vacuum_thrust, options_.least_thrust * mean) * now.centre_of_mass;
  return {now.pitch_inertia / moment, now.yaw_inertia / moment};
}

Command AttitudeControl::command(const Seen& seen, const Quaterniond& q_eb_wanted) {
  const Quaterniond to_reference = seen.pose.q_eb.conjugate() * q_eb_wanted;
  const Vector3d error = earth::log_rotation(to_reference);
  const Vector3d earth_rate = seen.pose.q_eb.conjugate() * Vector3d(0, 0, earth::wgs84::kEarthRate);
  Vector3d rate = seen.w_ib_b - earth_rate;
  if (options_.feedback == RateFeedback::rate_error)
    rate -= to_reference * Vector3d(0, options_.pitch.at(seen.t).first, 0);
  const double w = options_.frequency;
  const Vector3d wanted = w * w * error - 2 * options_.damping * w * rate;
  const BurnState now = burn_state(vehicle_, seen.t);
  const Vector2d nozzle = filtered(gain(now).cwiseProduct(wanted.tail<2>()), seen.t);
  return {nozzle[0], nozzle[1], now.roll_inertia * wanted.x()};
}

AttitudeControl::Coefficients AttitudeControl::coefficients(const Notch& notch, double t) const {
  const double w = 2 * std::numbers::pi * notch.frequency(t / vehicle_.burn_time);
  const double k = 1 / std::tan(w * options_.period / 2);
  const double over = 1 / (k * k + 2 * notch.width * k + 1);
  return {(k * k + 2 * notch.depth * k + 1) * over, 2 * (1 - k * k) * over, (k * k - 2 * notch.depth * k + 1) * over,
          2 * (1 - k * k) * over, (k * k - 2 * notch.width * k + 1) * over};
}

Vector2d AttitudeControl::filtered(const Vector2d& input, double t) {
  Vector2d x = input;
  for (std::size_t k = 0; k < options_.notches.size(); ++k) {
    const Coefficients c = coefficients(options_.notches[k], t);
    auto& [first, second] = memory_[k];
    const Vector2d y = c.b0 * x + first;
    first = c.b1 * x - c.a1 * y + second;
    second = c.b2 * x - c.a2 * y;
    x = y;
  }
  return x;
}

std::complex<double> AttitudeControl::filter_response(double t, double w) const {
  const std::complex<double> back = std::polar(1.0, -w * options_.period);
  std::complex<double> response = 1;
  for (const Notch& notch : options_.notches) {
    const Coefficients c = coefficients(notch, t);
    response *= (c.b0 + back * (c.b1 + back * c.b2)) / (1.0 + back * (c.a1 + back * c.a2));
  }
  return response;
}

}  // namespace gyrobudget::inline v0::flight
