// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/closed_loop/study.h"
#include "gyrobudget/vehicle/flight/dispersion.h"
#include "gyrobudget/vehicle/flight/plan.h"
#include "gyrobudget/app/files/vehicle_file.h"

#include <span>
#include <string>
#include <vector>

// Closed-loop flights as people and programs want them. Positions and velocities are of the IMU, in the launch plane's
// axes at the pad: downrange, crossrange (left), up; what navigation errs by stands in east, north, up too.
namespace gyrobudget::inline v0::report {

/// One scene flown with one sensor. Where results side by side have the same nominal flight, it, what the vehicle
/// disperses and the margins are told once.
struct FlightResult {
  std::string scene;                               ///< its path
  std::string name;                                ///< as it calls itself
  std::string sensor;                              ///< path of the sensor file; empty: ideal
  std::string command;                             ///< as typed
  std::string vehicle;                             ///< path of the vehicle's file; empty: the program's own
  std::vector<files::VehicleNumber> vehicle_numbers;  ///< of that file, with where they come from
  std::vector<files::VehicleOmission> vehicle_left_out;  ///< so too
  flight::Plan plan;
  flight::Dispersion dispersion;
  closed_loop::Study study;
  std::vector<std::string> notes;  ///< beside those of the study
};

/// Tables for the terminal: where each flight ends, how far from the nominal one, navigation error by source,
/// dispersion by cause, limits and margins. Of one result at least, as the others.
[[nodiscard]] std::string flight_text(std::span<const FlightResult>);
/// Schema gyrobudget.flight/1: {"schema","version","command","scene","name","sensor",
/// "vehicle":{"file","name","origins" (how many numbers are):{"sourced","derived","assumed","not stated"},"numbers":[{"key",
/// "value","origin","reason"}],"left_out":[{"key","meaning"}]},"seed","runs","aided","aligned_over_s",
/// "ended" (complete, impact, tumbling, overload, not_finite, not_flown),"account",
/// "burnout" (end of the flight with the sensors of run 0; null where it was not flown):{"t_s","height_m","downrange_m",
/// "crossrange_m","speed_m_s","distance_m","pitch_deg"},"nominal" (alike, with "ended" and "account"),
/// "departure" (from the nominal flight at that time):{"position_m":{"downrange","crossrange","up","rss"},"velocity_m_s"
/// (alike),"attitude_deg":{…,"total"}},
/// "dispersion":{"sensors","vehicle","all"}, each null where nothing varies or {"flights","complete","lost","unaligned",
/// "position_m":{"downrange","crossrange","up","rss"},"velocity_m_s","attitude_deg","mean_position_m",
/// "ellipse":{"semi_major_m","semi_minor_m","azimuth_deg"}}, null of fewer than two complete flights,
/// "navigation_error" (null for a flight too short):{"position_m":{"east","north","up","downrange","crossrange","rss"},
/// "velocity_m_s":{"east","north","up","rss"},"attitude_deg":{"east","north","up","total"},"claimed","sources":[{"name",
/// "share","position_m","velocity_m_s","attitude_deg"}],"not_modelled":[{"what","why"}],"flown" (of run 0, signed),
/// "monte_carlo":{"runs","position_rss_ratio","velocity_rss_ratio","attitude_rss_ratio","position_ratio":{…},
/// "ratio_low","ratio_high"}},
/// "margins":{"until_s","gain_demand_db","phase_demand_deg","met","least":[{"mode_factor","gain_up_db","gain_down_db",
/// "phase_deg","stable"}],"points":{"t_s","mode_factor","gain_up_db","gain_down_db","phase_deg","stable"}},
/// "limits":{"dynamic_pressure_pa","dynamic_pressure_at_s","mach_at_it","pressure_angle_pa_rad","nozzle_deg",
/// "nozzle_limit_deg","nozzle_limited"} of the flown flight, of the nominal one where none was flown,
/// "integrator":{"method","asked","step_s","tolerance","steps","rejected","evaluations"},
/// "trajectory" (a list for each column):{"t_s","downrange_m","crossrange_m","up_m","height_m","latitude_deg",…},
/// "inputs":[{"group","name","value","unit"}],"notes"}. One sigma; bands are 99 %; a margin without a limit is null.
/// Several: {"schema":"gyrobudget.flights/1","flights":[…]}.
[[nodiscard]] std::string flight_json(std::span<const FlightResult>);
/// One HTML page that opens offline.
[[nodiscard]] std::string flight_page(std::span<const FlightResult>);

}  // namespace gyrobudget::inline v0::report
