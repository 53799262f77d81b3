// SPDX-License-Identifier: MIT
// What sensors and vehicle do to a flight in closed loop, in one call:
//
//     const closed_loop::Study study = closed_loop::study(plan, dispersion, scenario, {.runs = 200});
//     const auto check = closed_loop::navigation_check(study);  // summary.h
#pragma once

#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/estimation/navigation/scenario.h"
#include "gyrobudget/vehicle/flight/dispersion.h"
#include "gyrobudget/vehicle/flight/margins.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::closed_loop {

/// One flight of many.
struct Outcome {
  flight::Ended ended = flight::Ended::complete;
  bool aligned = true;     ///< false: its alignment on the pad found no heading, and it did not fly
  double t = 0;            ///< when it ended [s]
  budget::FixCount fixes;  ///< that navigation was given
  // At the end, truth less the nominal flight at the same time: downrange, crossrange (left), up.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d attitude = Eigen::Vector3d::Zero();  ///< rotation vector [rad]
  /// Truth less what navigation told, at the end: position, velocity, attitude in axes of e.
  Eigen::Matrix<double, navigation::kCoreStates, 1> navigation =
      Eigen::Matrix<double, navigation::kCoreStates, 1>::Zero();

  [[nodiscard]] bool counts() const { return aligned && ended == flight::Ended::complete; }
  [[nodiscard]] bool lost() const { return aligned && ended != flight::Ended::complete; }
};

/// Flights of one kind, in the order of their runs.
struct Flights {
  std::vector<Outcome> outcomes;

  [[nodiscard]] int complete() const;
  [[nodiscard]] int lost() const;       ///< ended before their time
  [[nodiscard]] int unaligned() const;  ///< never flown
  /// Mean and covariance about it of a member of Outcome over the complete flights; zero for fewer than two.
  struct Spread {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    [[nodiscard]] Eigen::Vector3d sigma() const { return covariance.diagonal().cwiseSqrt(); }
  };
  [[nodiscard]] Spread spread(Eigen::Vector3d Outcome::*member) const;
  [[nodiscard]] budget::FixCount fixes() const;  ///< of all of them
  /// Second moment about zero of the navigation errors of the complete flights, axes of e.
  [[nodiscard]] navigation::CoreMatrix navigation_error() const;
};

/// Loop margins along the nominal flight, with the mode where it is and 10 % off (one each where the vehicle is rigid).
struct MarginsAt {
  std::vector<flight::Margins> points;
  double until = 0;  ///< thrust is above 20 % of its mean up to here [s]
};

/// What is asked of a study beside plan, dispersion and scene.
struct Options {
  int runs = 0;            ///< of Monte Carlo, of each kind; 0: none
  std::uint64_t seed = 1;  ///< of its random numbers
  bool margins = true;     ///< of the loop, along the nominal flight
  /// Points of the flown record a second, as nearly as whole periods of control allow [Hz]; none: as the flight has it
  /// (flight::Flight::record_every).
  std::optional<double> record_rate;
  /// After each run, of all kinds, from one thread at a time: flights done, and in all; false stops.
  std::function<bool(int done, int all)> progress;
};

/// What was found.
struct Study {
  flight::FlightRecord nominal;               ///< perfect navigation, the vehicle as planned, the program alone
  std::optional<flight::FlightRecord> flown;  ///< with the sensors of run 0; none where it could not be aligned
  Eigen::Matrix3d C_enu, C_launch;            ///< east, north, up; downrange, crossrange, up at the pad
  double azimuth = 0;  ///< of the launch plane, clockwise from north [rad]
  MarginsAt margins;
  /// Of the nominal flight in open loop, by linear covariance; none for a flight too short to navigate.
  std::optional<budget::Budget> budget;
  std::vector<navigation::SensorStates::LeftOut> left_out;  ///< of it
  bool aided = false;
  double pad = 0;  ///< alignment before ignition [s]
  // Monte Carlo, empty where no runs were asked for or there is nothing to vary.
  Flights sensors;       ///< sensors as they may be, the vehicle as planned
  Flights vehicle;       ///< the vehicle as it may be, perfect navigation
  Flights all;           ///< both
  int asked = 0;         ///< runs of each kind that were asked for
  int runs = 0;          ///< done of each kind
  bool stopped = false;  ///< by progress, before all were done
  std::uint64_t seed = 1;

  // --- Where linear covariance does not hold ---
  std::string no_heading;  ///< what the alignment says where it finds none; empty: it finds one, or needs none
  std::vector<budget::OutOfRange> out_of_range;  ///< axes of sensors that are cut off

  /// The flight lasts too short to navigate (flight::makes_a_trajectory), so that nothing is known of navigation.
  [[nodiscard]] bool too_short() const { return !budget; }
  /// Runs were asked for, and none was flown, as the nominal flight is not complete itself.
  [[nodiscard]] bool not_compared() const;
  /// Both the nominal flight and that with the sensors of run 0 are complete.
  [[nodiscard]] bool flew_to_the_end() const;
  /// The flight with the sensors of run 0; the nominal one where it could not be flown.
  [[nodiscard]] const flight::FlightRecord& shown() const { return flown ? *flown : nominal; }
};

/// Flies the plan from the scene's site: as planned, once with its sensors, and many times. The dispersion is split:
/// sensors alone, vehicle and wind alone, both at once; run k has the same sensors and the same vehicle in each. The
/// flight's duration is cut to whole periods. Deterministic in (seed, run): the same for any number of threads.
///
/// Navigation is that of the scene (alignment, aids, filter); a scene without aids and alignment on the pad flies on the
/// strapdown alone. Errors of the world that the scene names act on the nominal flight's increments.
///
/// @throws flight::SetupError as flight::fly does; navigation::SetupError as budget::budget_scene does and for runs below
/// 0; navigation::Diverged where the open loop's covariance grows beyond all numbers. What Options::progress throws passes
/// through. A navigator that diverges in flight ends that flight as flight::Ended::not_finite.
[[nodiscard]] Study study(const flight::Plan& plan, const flight::Dispersion& dispersion,
                          const navigation::Scenario& scenario, const Options& options = {});

}  // namespace gyrobudget::inline v0::closed_loop
