// SPDX-License-Identifier: MIT
#include "vehicle.h"

#include "gyrobudget/vehicle/flight/detail/burn.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {
namespace {

// `number` is the member's name, a literal.
void require(bool holds, std::string_view number, const char* what, double value, const char* limit, const char* unit) {
  if (!holds || !std::isfinite(value))
    throw VehicleError(number, fmt::format("{} is {} {}, but must be {}", what, value, unit, limit));
}
void positive(double value, std::string_view number, const char* what, const char* unit) {
  require(value > 0, number, what, value, "positive", unit);
}
void not_negative(double value, std::string_view number, const char* what, const char* unit) {
  require(value >= 0, number, what, value, "zero or more", unit);
}
void positive(const LookupTable& table, std::string_view number, const char* what, const char* unit) {
  positive(table.range().first, number, what, unit);
}
void finite(double value, std::string_view number, const char* what, const char* unit) {
  require(true, number, what, value, "finite", unit);
}

void check_thrust_shape(const LookupTable& shape) {
  constexpr std::string_view kNumber = "thrust_shape";
  not_negative(shape.range().first, kNumber, "least value of the thrust shape", "");
  const double first = shape.points().front().first;
  require(first == 0, kNumber, "first point of the thrust shape", first, "0", "of burn fraction");
  positive(shape.integral(1), kNumber, "mean of the thrust shape", "");
}

void check_actuator(const Actuator& a) {
  positive(a.frequency, "actuator.frequency", "frequency of the actuator", "Hz");
  positive(a.damping, "actuator.damping", "damping of the actuator", "");
  require(a.deflection_limit >= 0 && a.deflection_limit < std::numbers::pi / 4, "actuator.deflection_limit",
          "deflection limit", a.deflection_limit, "from 0 to pi/4", "rad");
  not_negative(a.rate_limit, "actuator.rate_limit", "rate limit of the nozzle", "rad/s");
  require(a.delay >= 0 && a.delay <= 1, "actuator.delay", "delay of the actuator", a.delay, "from 0 to 1", "s");
}

void check_bending(const Bending& b) {
  positive(b.frequency, "bending.frequency", "frequency of the bending mode", "Hz");
  not_negative(b.damping, "bending.damping", "damping of the bending mode", "");
  finite(b.gimbal_deflection, "bending.gimbal_deflection", "deflection of the bending mode at the gimbal", "");
  finite(b.slope_at_imu, "bending.slope_at_imu", "slope of the bending mode at the IMU", "rad/m");
}

}  // namespace

void Vehicle::check() const {
  positive(lift_off_mass, "lift_off_mass", "lift-off mass", "kg");
  require(propellant >= 0 && propellant < lift_off_mass, "propellant", "propellant", propellant,
          "zero or more and less than the lift-off mass", "kg");
  positive(burn_time, "burn_time", "burn time", "s");
  not_negative(specific_impulse, "specific_impulse", "specific impulse", "s");
  check_thrust_shape(thrust_shape);
  not_negative(exit_area, "exit_area", "exit area", "m^2");
  not_negative(reference_area, "reference_area", "reference area", "m^2");
  finite(normal_force_slope, "normal_force_slope", "normal-force slope", "1/rad");
  finite(pressure_ahead, "pressure_ahead", "distance of the centre of pressure", "m");
  positive(roll_inertia, "roll_inertia", "roll inertia", "kg m^2");
  positive(pitch_inertia, "pitch_inertia", "pitch inertia", "kg m^2");
  positive(yaw_inertia, "yaw_inertia", "yaw inertia", "kg m^2");
  finite(imu_station, "imu_station", "station of the IMU", "m");
  not_negative(roll_moment_limit, "roll_moment_limit", "limit of the roll moment", "N m");
  check_actuator(actuator);
  if (bending) check_bending(*bending);
}

BurnState burn_state(const Vehicle& vehicle, double t) {
  const detail::Burn burn(vehicle, std::numeric_limits<double>::infinity());
  const detail::Burn::Now now = burn.at(t, burn.piece(t));
  return {now.mass,
          now.thrust,
          now.centre_of_mass,
          vehicle.roll_inertia(now.used),
          vehicle.pitch_inertia(now.used),
          vehicle.yaw_inertia(now.used)};
}

Vehicle vlm1() {
  constexpr double kDiameter = 1.45;
  Vehicle v;
  v.name = "VLM-1, first stage";
  v.lift_off_mass = 28000;
  v.propellant = 12000;
  v.burn_time = 83;
  v.specific_impulse = 277;
  v.thrust_shape =
      LookupTable::linear({{0, 1.05}, {0.02, 1.10}, {0.25, 1.22}, {0.5, 1.12}, {0.75, 0.92}, {0.93, 0.75}, {1, 0}});
  v.exit_area = 0.35;
  v.reference_area = std::numbers::pi / 4 * kDiameter * kDiameter;
  v.axial_drag = LookupTable::smooth(
      {{0, 0.30}, {0.8, 0.33}, {0.95, 0.42}, {1.05, 0.55}, {1.2, 0.55}, {1.5, 0.48}, {2, 0.40}, {3, 0.32}, {5, 0.25}});
  v.normal_force_slope = 2.8;
  v.pressure_ahead = 3;
  v.centre_of_mass = LookupTable::linear({{0, 7}, {1, 10}});
  v.roll_inertia = LookupTable::linear({{0, 7.1e3}, {1, 4.2e3}});
  v.pitch_inertia = LookupTable::linear({{0, 4.2e5}, {1, 2.0e5}});
  v.yaw_inertia = v.pitch_inertia;
  v.imu_station = 16;
  v.actuator.delay = 0.01;
  v.roll_moment_limit = 2000;
  return v;
}

Vehicle vlm1_paper() {
  Vehicle v = vlm1();
  v.name = "VLM-1, first stage, chosen to match the paper's scale";
  v.lift_off_mass = 27000;
  v.specific_impulse = 280;
  v.exit_area = 0.30;
  return v;
}

std::span<const Provenance> vlm1_provenance() {
  using enum Origin;
  static constexpr std::array kTable{
      Provenance{"lift_off_mass", sourced, "published for the VLM-1"},
      Provenance{"propellant", sourced, "S50 motor, 13 t loaded"},
      Provenance{"burn_time", sourced, "the paper's flight; 84 s on the test stand"},
      Provenance{"specific_impulse", sourced, "S50 motor, in vacuum; with the two above a mean of 393 kN"},
      Provenance{"thrust_shape", assumed, "a solid motor's usual shape; the dominant unknown"},
      Provenance{"exit_area", assumed, "size of the nozzle against the stage's diameter"},
      Provenance{"reference_area", derived, "cross-section of the published diameter, 1.45 m"},
      Provenance{"axial_drag", assumed, "slender bodies of this kind, power on"},
      Provenance{"normal_force_slope", assumed, "slender-body theory, 2 of the nose, more of the flare"},
      Provenance{"pressure_ahead", assumed, "no fins: unstable, as the nose carries the normal force"},
      Provenance{"centre_of_mass", assumed, "arm of the gimbal, from the stages' lengths"},
      Provenance{"roll_inertia", derived, "from masses and diameter, the grain as a cylinder: rests on assumptions"},
      Provenance{"pitch_inertia", derived, "from masses and lengths of the stages: rests on assumptions"},
      Provenance{"yaw_inertia", derived, "as pitch"},
      Provenance{"imu_station", assumed, "in the bay above the upper stages of a vehicle of 19.6 m"},
      Provenance{"actuator", assumed,
                 "3 degrees, 15 degrees/s, 4 Hz, 0.7: usual of flexible nozzles; 10 ms to compute"},
      Provenance{"roll_moment_limit", assumed, "two pairs of small thrusters at the skin"},
      Provenance{"bending", assumed, "free-free beam: 6 to 8 Hz, 0.5 %, 2 at the gimbal, -0.47 rad/m at a forward IMU"},
  };
  return kTable;
}

}  // namespace gyrobudget::inline v0::flight
