// SPDX-License-Identifier: MIT
// What differs from one vehicle of a kind to the next, and from day to day.
#pragma once

#include <cstdint>

#include "fly.h"

namespace gyrobudget::inline v0::flight {

/// One sigma of each; all normal and independent. 0 leaves it out.
struct Dispersion {
  double impulse = 0;              ///< of the motor's total impulse at the same burn, relative
  double burn_time = 0;            ///< at the same total impulse, relative
  double mass = 0;                 ///< at lift-off, with the same propellant, relative
  double inertia = 0;              ///< all three moments together, relative
  double axial_drag = 0;           ///< relative
  double normal_force = 0;         ///< slope, relative
  double pressure_ahead = 0;       ///< centre of pressure [m]
  double centre_of_mass = 0;       ///< along the body, and with it the centre of pressure [m]
  double thrust_misalignment = 0;  ///< of the nozzle's zero, in pitch and in yaw [rad]
  double wind = 0;                 ///< steady, east and north, beside the flight's own wind [m/s]
  double gust = 0;                 ///< peak of the flight's gust, relative

  [[nodiscard]] bool none() const;
  /// Draws reach 8.57 sigma, and none is clamped: where one could leave a quantity that is to be positive, or
  /// a mass not above the propellant's, the dispersion is refused.
  /// @throws SetupError naming the quantity, also for one that is negative or not finite.
  void check(const Vehicle& vehicle) const;
};

/// The flight as run number `run`, below 2^48, has it. Each quantity has a stream of its own, keyed by (seed,
/// run): leaving one out does not change the others. Without dispersion it is the flight given, to the last
/// bit.
/// @throws SetupError as check().
[[nodiscard]] Flight disperse(const Flight& flight, const Dispersion& dispersion, std::uint64_t seed,
                              std::uint64_t run);

}  // namespace gyrobudget::inline v0::flight
