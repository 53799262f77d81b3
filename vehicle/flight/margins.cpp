// SPDX-License-Identifier: MIT
#include "margins.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gyrobudget::inline v0::flight {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

double aerodynamic_stiffness(const Vehicle& v, const Condition& c, double inertia) {
  return c.dynamic_pressure * v.reference_area * v.normal_force_slope * v.pressure_ahead / inertia;
}

double mode_frequency(const Vehicle& v, const Condition& c) {
  return 2 * pi * v.bending->frequency(c.t / v.burn_time) * c.mode_factor;
}

/// Frequencies from 1 mrad/s to half the control rate, with more about resonances.
std::vector<double> grid(const Vehicle& v, const Condition& c, double highest) {
  constexpr int kPlain = 3000, kAbout = 500;
  constexpr double kLowest = 1e-3;
  std::vector<double> w;
  for (int k = 0; k <= kPlain; ++k) w.push_back(kLowest * std::pow(highest / kLowest, k / static_cast<double>(kPlain)));
  if (v.bending) {
    const double centre = mode_frequency(v, c);
    for (int k = -kAbout; k <= kAbout; ++k) {  // spread as the phase turns through the resonance
      const double at = centre * (1 + std::max(v.bending->damping, 1e-6) * std::tan(k * (pi / 2 - 0.02) / kAbout));
      if (at > kLowest && at < highest) w.push_back(at);
    }
  }
  std::sort(w.begin(), w.end());
  return w;
}

/// The root of g between a and b, where its sign differs.
template <class G>
double root(const G& g, double a, double b) {
  const bool rising = g(b) > 0;
  while (b - a > 1e-10 * b) {
    const double middle = (a + b) / 2;
    (((g(middle) > 0) == rising) ? b : a) = middle;
  }
  return (a + b) / 2;
}

}  // namespace

Complex open_loop(const Vehicle& vehicle, const AttitudeControl& control, const Condition& condition, double w) {
  const BurnState now = burn_state(vehicle, condition.t);
  const auto& o = control.options();
  const Complex s(0, w);
  const Complex fade = 1.0 - std::exp(-s * o.period);
  const Complex law = control.gain(condition.t)[0] *
                      (o.frequency * o.frequency + 2 * o.damping * o.frequency * fade / o.period) *
                      control.filter_response(condition.t, w);
  const double wa = 2 * pi * vehicle.actuator.frequency;
  const Complex nozzle = wa * wa / (s * s + 2 * vehicle.actuator.damping * wa * s + wa * wa) *
                         std::exp(-s * vehicle.actuator.delay) * fade / (s * o.period);
  const double m = aerodynamic_stiffness(vehicle, condition, now.pitch_inertia);
  Complex plant = condition.thrust * now.centre_of_mass / now.pitch_inertia / (s * s - m);
  if (vehicle.bending) {
    const double wb = mode_frequency(vehicle, condition);
    plant += vehicle.bending->slope_at_imu * vehicle.bending->gimbal_deflection * condition.thrust / now.mass /
             (s * s + 2 * vehicle.bending->damping * wb * s + wb * wb);
  }
  return law * nozzle * plant;
}

Margins margins(const Vehicle& vehicle, const AttitudeControl& control, const Condition& condition) {
  const auto loop = [&](double w) { return open_loop(vehicle, control, condition, w); };
  const auto size = [&](double w) { return std::abs(loop(w)) - 1; };
  const auto side = [&](double w) { return loop(w).imag(); };
  Margins result{.t = condition.t, .mode_factor = condition.mode_factor};
  const std::vector<double> w = grid(vehicle, condition, pi / control.options().period * (1 - 1e-9));
  Complex before = loop(w.front());
  // Below the grid L is real: its crossing there, at w = 0, counts where the vehicle is unstable.
  const double inertia = burn_state(vehicle, condition.t).pitch_inertia;
  const bool unstable = aerodynamic_stiffness(vehicle, condition, inertia) >= 0;
  if (before.real() < -1) result.gain_down = -1 / before.real();
  double turned = 0;
  for (std::size_t k = 1; k < w.size(); ++k) {
    const Complex here = loop(w[k]);
    turned += std::arg((1.0 + here) / (1.0 + before));
    if ((before.imag() > 0) != (here.imag() > 0) && std::min(before.real(), here.real()) < 0) {
      const double real = loop(root(side, w[k - 1], w[k])).real();
      if (real < -1) result.gain_down = std::max(result.gain_down, -1 / real);
      if (real < 0 && real > -1) result.gain_up = std::min(result.gain_up, -1 / real);
    }
    if ((std::abs(before) > 1) != (std::abs(here) > 1)) {
      const double at = root(size, w[k - 1], w[k]);
      result.phase = std::min(result.phase, pi - std::abs(std::arg(loop(at))));
      if (std::abs(before) > 1 && result.crossover == 0) result.crossover = at;
    }
    before = here;
  }
  result.stable = std::abs(turned - (unstable ? pi : 0)) < pi / 2;
  return result;
}

}  // namespace gyrobudget::inline v0::flight
