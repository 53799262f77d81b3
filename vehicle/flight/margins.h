// SPDX-License-Identifier: MIT
#pragma once

#include <complex>
#include <limits>
#include <span>
#include <vector>

#include "control.h"
#include "vehicle.h"

namespace gyrobudget::inline v0::flight {

/// Where in a flight the loop is linearised.
struct Condition {
  double t = 0;                 ///< [s]
  double thrust = 0;            ///< less back-pressure [N]
  double dynamic_pressure = 0;  ///< [Pa]
  double mode_factor = 1;       ///< bending frequency over that of the vehicle's table
};

/// The pitch loop opened at the nozzle's command, at angular frequency w [rad/s], with its sign so that -1 is
/// the critical point turned to: the loop is stable by Nyquist's criterion for L around -1.
///   L = gain (w_n^2 + 2 z w_n (1 - e^-sT)/T) filters  (1 - e^-sT)/(sT) e^-s delay  actuator
///       [ (F arm/I)/(s^2 - m) + slope_at_imu gimbal_deflection (F/mass)/(s^2 + 2 z_b w_b s + w_b^2) ],
/// m = q S slope pressure_ahead/I. The first bracket has the gyros' mean over a period, the next the hold of
/// the command. Left out: what the sampler folds back from above half its rate, and lateral drift of the
/// vehicle, which is slower than 0.1 rad/s.
[[nodiscard]] std::complex<double> open_loop(const Vehicle& vehicle, const AttitudeControl& control,
                                             const Condition& condition, double w);

/// How far the loop is from oscillating.
struct Margins {
  double t = 0;
  double mode_factor = 1;
  double gain_up = std::numeric_limits<double>::infinity();  ///< factor the gain may grow by
  double gain_down = 0;  ///< factor the gain may shrink to: 0 for none, as without air
  double phase = std::numeric_limits<double>::infinity();  ///< least at any crossover [rad]
  double crossover = 0;  ///< lowest angular frequency where |L| falls through 1 [rad/s]
  bool stable = false;   ///< by the turns of 1 + L about 0
};
/// Crossings are found on 4000 frequencies from 1 mrad/s to half the control rate, denser about the bending
/// mode, and refined to 1e-10.
[[nodiscard]] Margins margins(const Vehicle& vehicle, const AttitudeControl& control, const Condition& condition);

}  // namespace gyrobudget::inline v0::flight
