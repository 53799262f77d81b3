// SPDX-License-Identifier: MIT
// What a study of flights comes to in a few numbers, and which of them pass.
#pragma once

#include <optional>
#include <vector>

#include "study.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::closed_loop {

// --- Limits ---------------------------------------------------------------------------------------------------------

/// What a flight used of the limits.
struct LimitsUsed {
  double pressure = 0;          ///< highest dynamic pressure over the points [Pa]
  double pressure_at = 0;       ///< when [s]
  double mach = 0;              ///< then
  double pressure_angle = 0;    ///< highest product with the angle of attack [Pa rad]
  double deflection = 0;        ///< of the nozzle, largest in a plane [rad]
  double deflection_limit = 0;  ///< [rad]
  double limited = 0;           ///< share of the periods in which a limit bound the nozzle's command
};
[[nodiscard]] LimitsUsed limits_used(const flight::Vehicle& vehicle, const flight::FlightRecord& record);

// --- Margins --------------------------------------------------------------------------------------------------------

/// Margins that a loop is to have, both ways in gain, up to where the thrust has faded.
inline constexpr double kGainDemandDb = 6;
inline constexpr double kPhaseDemandDeg = 30;

/// 20 log10 of a factor [dB].
[[nodiscard]] double decibel(double factor);

/// Least margins along the flight for one frequency of the bending mode; infinite without a limit.
struct LeastMargins {
  double mode_factor = 1;                     ///< bending frequency over that of the vehicle's table
  double gain_up_db = 0, gain_up_at = 0;      ///< by which the gain may grow [dB], when [s]
  double gain_down_db = 0, gain_down_at = 0;  ///< by which it may shrink, positive [dB], when [s]
  double phase_deg = 0, phase_at = 0;         ///< [deg], when [s]
  bool stable = true;                         ///< at every point

  /// Stable with the margins demanded.
  [[nodiscard]] bool met() const {
    return stable && gain_up_db >= kGainDemandDb && gain_down_db >= kGainDemandDb && phase_deg >= kPhaseDemandDeg;
  }
};
/// One for each mode factor there is; none where no loop was computed.
[[nodiscard]] std::vector<LeastMargins> least_margins(const MarginsAt& margins);
/// All of them are met, and there are some.
[[nodiscard]] bool margins_met(const MarginsAt& margins);

// --- Dispersion and navigation --------------------------------------------------------------------------------------

/// Horizontal ellipse of one sigma.
struct Ellipse {
  double semi_major = 0, semi_minor = 0;  ///< [m]
  double azimuth = 0;                     ///< of the major axis, clockwise from north, 0 to pi [rad]
};
/// By the eigenvalues of the horizontal block.
/// @param covariance of downrange, crossrange (left), up [m^2]
/// @param launch_azimuth of downrange, clockwise from north [rad]
[[nodiscard]] Ellipse ellipse(const Eigen::Matrix3d& covariance, double launch_azimuth);

/// Navigation's sigma at the end, found in Monte Carlo over that of the open loop's linear covariance.
struct NavigationCheck {
  int runs = 0;                                              ///< complete flights
  Eigen::Vector3d position_ratio = Eigen::Vector3d::Zero();  ///< downrange, crossrange, up
  double position = 0, velocity = 0, attitude = 0;           ///< of root sum squares
  double low = 0, high = 0;  ///< that 99 % of right ratios of one axis lie in (navigation::sigma_ratio_band)
  [[nodiscard]] bool holds(double ratio) const { return !(ratio < low || ratio > high); }
};
inline constexpr double kRatioBand = 0.99;  ///< probability of that band
/// None without a budget or without two complete flights; a ratio to nothing is not a number.
[[nodiscard]] std::optional<NavigationCheck> navigation_check(const Study& study);

/// Whether two studies have the same nominal flight and the same flights of the vehicle alone, to the last bit, as
/// those of one plan with different sensors have.
[[nodiscard]] bool same_nominal(const Study& one, const Study& other);

}  // namespace gyrobudget::inline v0::closed_loop
