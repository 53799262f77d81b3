// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "lookup_table.h"

namespace gyrobudget::inline v0::flight {

using noise::kStandardGravity;  // g0 of specific impulses

/// Thrust-vector actuator of each plane: d'' = w^2 (command - d) - 2 z w d'. The limits bound the command on
/// its way to it, in size and in change per control period, so that the actuator itself stays linear and can
/// be integrated exactly; d overshoots the limit as its damping has it (4.6 % at 0.7).
struct Actuator {
  double frequency = 4;                          ///< w/(2 pi) [Hz]
  double damping = 0.7;                          ///< z
  double deflection_limit = 3 * earth::kDegree;  ///< [rad]
  double rate_limit = 15 * earth::kDegree;       ///< [rad/s]
  double delay = 0;                              ///< from the control's word to the actuator [s]
};

/// First bending mode, alike in both planes: e'' + 2 z w e' + w^2 e = F_gimbal gimbal_deflection/m, where
/// F_gimbal is the nozzle's lateral force and m the vehicle's mass as generalised mass. The IMU is turned by
/// slope_at_imu e against the rigid body; what the mode shifts it by is left out.
struct Bending {
  LookupTable frequency = LookupTable::linear({{0, 6}, {1, 8}});  ///< over burn fraction [Hz]
  double damping = 0.005;
  double gimbal_deflection = 2;
  /// [rad/m]; positive where a force that pitches the body up turns the IMU up with the mode, as near the
  /// gimbal; ahead of the belly of the mode it turns it down.
  double slope_at_imu = -0.47;
};

/// A number that a flight, its vehicle or who steers it is set up with is out of its range, or several numbers cannot
/// be together. The message has the value, the limit and the unit. Mistakes in the calling program are plain
/// std::invalid_argument.
class SetupError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// What Vehicle::check found.
struct VehicleError : SetupError {
  VehicleError(std::string_view member, const std::string& message) : SetupError(message), number(member) {}
  std::string_view number;  ///< name of the member, "propellant" or "actuator.delay"
};

/// A stage in powered flight. Stations are along the body's x axis, forward from the gimbal. Burn fraction is
/// time over burn_time; propellant fraction is propellant used over propellant.
struct Vehicle {
  std::string name;
  double lift_off_mass = 0;        ///< [kg]
  double propellant = 0;           ///< of this stage [kg]
  double burn_time = 0;            ///< [s]
  double specific_impulse = 0;     ///< in vacuum [s]
  LookupTable thrust_shape = 1;    ///< over burn fraction; only its shape counts, its mean over 0 to 1 is set to 1
  double exit_area = 0;            ///< [m^2]
  double reference_area = 0;       ///< of the aerodynamic coefficients [m^2]
  LookupTable axial_drag = 0;      ///< coefficient by Mach number
  double normal_force_slope = 0;   ///< [1/rad]
  double pressure_ahead = 0;       ///< centre of pressure ahead of centre of mass [m]
  LookupTable centre_of_mass = 0;  ///< station over propellant fraction: the gimbal's arm [m]
  LookupTable roll_inertia = 1;    ///< principal moments over propellant fraction [kg m^2]
  LookupTable pitch_inertia = 1;
  LookupTable yaw_inertia = 1;
  double imu_station = 0;  ///< [m]
  Actuator actuator;
  double roll_moment_limit = 0;    ///< of the roll control [N m]
  std::optional<Bending> bending;  ///< none: the body is rigid and no bending is integrated

  /// Mean thrust in vacuum, specific_impulse g0 propellant/burn_time [N].
  [[nodiscard]] double mean_thrust() const { return specific_impulse * kStandardGravity * propellant / burn_time; }
  /// @throws VehicleError naming the first number that cannot be, with its limit and unit.
  void check() const;
};

/// What depends on burn fraction alone.
struct BurnState {
  double mass;                                      ///< [kg]
  double vacuum_thrust;                             ///< [N]
  double centre_of_mass;                            ///< station [m]
  double roll_inertia, pitch_inertia, yaw_inertia;  ///< [kg m^2]
};
/// At a time t [s] after ignition; before it as at 0, after burn_time as at its end but without thrust.
[[nodiscard]] BurnState burn_state(const Vehicle& vehicle, double t);

/// Where a number comes from.
enum class Origin {
  sourced,  ///< published
  derived,  ///< follows from published ones
  assumed,  ///< chosen; the reason says by what
};
struct Provenance {
  std::string_view number;  ///< name of the member
  Origin origin;
  std::string_view reason;
};

/// First stage of the Brazilian VLM-1, rigid. Where each number comes from: vlm1_provenance().
[[nodiscard]] Vehicle vlm1();
/// The same with 27 t, 280 s and an exit of 0.30 m^2, chosen so that a planar point mass is 29.2 km from the
/// pad at 83 s, the scale of the flight in the paper. These three are not to be taken for data.
[[nodiscard]] Vehicle vlm1_paper();
/// One entry for each member of Vehicle that holds a number, in their order.
[[nodiscard]] std::span<const Provenance> vlm1_provenance();

}  // namespace gyrobudget::inline v0::flight
