// SPDX-License-Identifier: MIT
#pragma once

#include "control.h"
#include "fly.h"

namespace gyrobudget::inline v0::flight {

/// The flight of the vehicle's mass with its nose exactly on the program, nozzle straight: no attitude,
/// actuator, bending, control or navigation is computed. Air, wind, back-pressure, the turning Earth and
/// a thrust cut are those of fly(). Runge-Kutta of order 4; steps of at most `step` s end at the thrust's
/// points, kinks of the air between its layers cost a millimetre. Points are those of the centre of mass,
/// `seen` as in truth.
/// Against fly() it saves nearly all the time and errs by what the attitude loop lets happen
/// (tests/bench/flight_benchmark parts).
/// @throws SetupError as fly() does, and for a step that is not positive.
[[nodiscard]] FlightRecord fly_point_mass(const Flight& flight, const AttitudeControl& program, double step = 0.1);

}  // namespace gyrobudget::inline v0::flight
