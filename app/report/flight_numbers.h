// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/vehicle/earth/frames.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "flight.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

// What terminal, JSON and page say of a flight, each computed once.
namespace gyrobudget::inline v0::report {

/// Margins that a loop is to have, both ways in gain, up to where the thrust has faded.
inline constexpr double kGainDemand = 6;    ///< [dB]
inline constexpr double kPhaseDemand = 30;  ///< [deg]
inline constexpr double kRatioBand = 0.99;  ///< that ratios of right sigmas lie in

/// What tells results apart, as short as it may be: the file of the sensor ("ideal" without one), its path, the file of
/// the scene, or both paths.
[[nodiscard]] std::vector<std::string> flight_names(std::span<const FlightResult>);
/// What the scene calls itself; of scenes with different names, what the vehicle is called.
[[nodiscard]] std::string flight_title(std::span<const FlightResult>);
/// "unaided strapdown", "strapdown and filter, aligned over 10 min on the pad before".
[[nodiscard]] std::string navigation_words(const closed_loop::Study&);
/// Notes of all, each once; one that is not of all with the names of those that it is of.
[[nodiscard]] std::vector<std::string> flight_notes(std::span<const FlightResult>);
/// Whether all have the same nominal flight and the same flights of the vehicle alone, to the last bit: then it, what the vehicle disperses and the margins are told
/// once.
[[nodiscard]] bool one_nominal(std::span<const FlightResult>);
/// Why there is no flight with the sensors, in place of its account.
[[nodiscard]] std::string not_flown(const closed_loop::Study&);

/// Nose and belly of a body against the launch plane. The pitch is turned first, in that plane, then the yaw out of it, so
/// that nothing is singular on the pad, where the pitch is 90 degrees.
struct LaunchAttitude {
  double pitch = 0;  ///< of the nose's projection on the launch plane above the horizon [rad]
  double yaw = 0;    ///< of the nose out of the launch plane, right positive [rad]
  double roll = 0;   ///< right side down positive [rad]
};
[[nodiscard]] LaunchAttitude launch_attitude(const Eigen::Quaterniond& q_eb, const Eigen::Matrix3d& C_launch);

/// An instant seen from the pad.
struct FromPad {
  double t = 0;                                        ///< [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< downrange, crossrange, up [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  earth::Geodetic place;
  LaunchAttitude attitude;
};
/// Differences in the launch plane's axes.
struct Difference {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d attitude = Eigen::Vector3d::Zero();  ///< rotation vector [rad]
};

/// The axes of a result, and the nominal flight at any time.
class FlightFrame {
 public:
  explicit FlightFrame(const FlightResult&);

  [[nodiscard]] FromPad from_pad(const flight::FlightPoint&) const;
  [[nodiscard]] Difference difference(const earth::Pose&, const earth::Pose& less) const;
  /// Of navigation: truth less what it tells.
  [[nodiscard]] Difference navigation_error(const flight::FlightPoint&) const;
  /// From the nominal flight at the same time; none after its end.
  [[nodiscard]] std::optional<Difference> departure(const flight::FlightPoint&) const;

 private:
  earth::LocalFrame launch_;
  const flight::FlightRecord* nominal_;
  std::optional<earth::Trajectory> path_;  // none of a flight with less than 4 points
};

/// What a flight used of the limits.
struct LimitsUsed {
  double pressure = 0, pressure_at = 0, mach = 0;  ///< highest dynamic pressure [Pa], when [s]
  double pressure_angle = 0;                       ///< highest product with the angle of attack [Pa rad]
  double deflection = 0, deflection_limit = 0;     ///< of the nozzle, largest in a plane [rad]
  double limited = 0;                              ///< share of the periods
};
[[nodiscard]] LimitsUsed limits_used(const FlightResult&, const flight::FlightRecord&);
/// The flight with the sensors of run 0; the nominal one where it could not be flown.
[[nodiscard]] const flight::FlightRecord& shown_record(const FlightResult&);

/// Least margins along the flight for one frequency of the bending mode.
struct LeastMargins {
  double mode_factor = 1;
  double gain_up = 0, gain_up_at = 0;      ///< [dB], [s]; infinite without a limit
  double gain_down = 0, gain_down_at = 0;  ///< [dB], positive
  double phase = 0, phase_at = 0;          ///< [deg]
  bool stable = true;

  [[nodiscard]] bool met() const {
    return stable && gain_up >= kGainDemand && gain_down >= kGainDemand && phase >= kPhaseDemand;
  }
};
/// One for each mode factor there is; none where no loop was computed.
[[nodiscard]] std::vector<LeastMargins> least_margins(const closed_loop::MarginsAt&);
[[nodiscard]] double decibel(double factor);

/// Horizontal ellipse of one sigma.
struct Ellipse {
  double semi_major = 0, semi_minor = 0;  ///< [m]
  double azimuth = 0;                     ///< of the major axis, clockwise from north, 0 to pi [rad]
};
/// @param covariance of downrange, crossrange, up.
[[nodiscard]] Ellipse ellipse(const Eigen::Matrix3d& covariance, double launch_azimuth);

/// Kinds of Monte Carlo flights, with their names.
struct FlightsOf {
  std::string_view cause;  ///< "sensors", "vehicle", "all"
  const closed_loop::Flights* flights;
};
[[nodiscard]] std::array<FlightsOf, 3> causes(const closed_loop::Study&);

/// Navigation's sigma of open loop and Monte Carlo at the end.
struct NavigationCheck {
  int runs = 0;
  Eigen::Vector3d position_ratio;                   ///< found over expected: downrange, crossrange, up
  double position = 0, velocity = 0, attitude = 0;  ///< of root sum squares
  double low = 0, high = 0;                         ///< 99 % of right ones, of one axis
};
/// None without a budget or without two complete flights; a ratio to nothing is not a number.
[[nodiscard]] std::optional<NavigationCheck> navigation_check(const closed_loop::Study&);

/// How many of the vehicle's numbers are of an origin.
struct OriginCount {
  std::string_view origin;  ///< "sourced", "derived", "assumed", "not stated"
  int numbers = 0;
};
[[nodiscard]] std::array<OriginCount, 4> origins(const FlightResult&);

/// A number that was put in.
struct Input {
  std::string group, name, value, unit;
};
/// Flight, control, wind, dispersion, faults and integration; what is not there is left out.
[[nodiscard]] std::vector<Input> inputs(const FlightResult&);

}  // namespace gyrobudget::inline v0::report
