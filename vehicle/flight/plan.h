// SPDX-License-Identifier: MIT
// A flight with who steers it: what a scene says, and how to fly it.
#pragma once

#include <optional>
#include <span>

#include "control.h"
#include "faults.h"
#include "fly.h"
#include "guidance.h"

namespace gyrobudget::inline v0::flight {

/// What flies as it is planned, and how it is steered. The controller believes this vehicle, whatever flies.
struct Plan {
  Flight flight;
  AttitudeControlOptions control;           ///< its period is the flight's
  std::optional<GuidanceOptions> guidance;  ///< none: the program of attitude alone
  NavigatorFaults navigator_faults;
};

/// With perfect navigation, without faults, by the program of attitude alone: the flight that guidance follows. Its
/// points are as dense as trajectory() needs them: 20 Hz, or of a vehicle that bends every period.
/// @throws SetupError as fly() and AttitudeControl do.
[[nodiscard]] FlightRecord fly_nominal(const Plan& plan);

/// Flies `flown`, which may differ from the plan's flight, under the plan's control. Guidance, where the plan has
/// it, follows `reference`, the waypoints of the nominal flight.
/// @throws SetupError as fly(), AttitudeControl and TrajectoryControl do.
template <Navigator N>
[[nodiscard]] FlightRecord fly(const Plan& plan, const Flight& flown, std::span<const Waypoint> reference,
                               N& navigator) {
  AttitudeControlOptions options = plan.control;
  options.period = flown.period;
  AttitudeControl attitude(plan.flight.vehicle, plan.flight.world.site, options);
  detail::Faulty<N> told(navigator, plan.navigator_faults, flown.period);
  if (!plan.guidance) return fly(flown, attitude, told);
  TrajectoryControl control(attitude, {reference.begin(), reference.end()}, *plan.guidance);
  return fly(flown, control, told);
}

/// Whether a record lasts long enough, a second, and has enough points for trajectory().
[[nodiscard]] bool makes_a_trajectory(const FlightRecord& record);

/// The truth of a record as a trajectory of the IMU, for what works along one: a spline through its points
/// (earth::through_samples), good to what that says of samples so far apart.
/// @throws std::invalid_argument for fewer than 4 points.
[[nodiscard]] earth::Trajectory trajectory(const FlightRecord& record);

}  // namespace gyrobudget::inline v0::flight
