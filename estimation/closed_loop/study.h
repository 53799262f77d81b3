// SPDX-License-Identifier: MIT
// What sensors and vehicle do to a flight in closed loop.
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
  bool aligned = true;  ///< false: its alignment on the pad found no heading, and it did not fly
  double t = 0;         ///< when it ended [s]
  std::int64_t fixes = 0,
               refused = 0;  ///< that navigation was given, and of them refused by the filter's gate
  // At the end, truth less the nominal flight at the same time: downrange, crossrange (left), up.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d attitude = Eigen::Vector3d::Zero();  ///< rotation vector [rad]
  /// Truth less what navigation told, at the end: position, velocity, attitude in axes of e.
  Eigen::Matrix<double, navigation::kCoreStates, 1> navigation =
      Eigen::Matrix<double, navigation::kCoreStates, 1>::Zero();

  [[nodiscard]] bool counts() const { return aligned && ended == flight::Ended::complete; }
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
  /// Second moment about zero of the navigation errors of the complete flights, axes of e.
  [[nodiscard]] navigation::CoreMatrix navigation_error() const;
};

/// Loop margins along the nominal flight, with the mode where it is and 10 % off (one each where the vehicle is rigid).
struct MarginsAt {
  std::vector<flight::Margins> points;
  double until = 0;  ///< thrust is above 20 % of its mean up to here [s]
};

struct Study {
  struct Options {
    int runs = 0;  ///< of each kind
    std::uint64_t seed = 1;
    bool margins = true;  ///< of the loop, along the nominal flight
    /// After each run, of all kinds, from one thread at a time: flights done, of how many; false stops.
    std::function<bool(int, int)> progress;
  };

  flight::FlightRecord nominal;               ///< perfect navigation, the vehicle as planned, the program alone
  std::optional<flight::FlightRecord> flown;  ///< with the sensors of run 0; none where it could not be aligned
  Eigen::Matrix3d C_enu, C_launch;            ///< east, north, up; downrange, crossrange, up at the pad
  double azimuth = 0;
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
  int runs = 0;          ///< done of each kind
  bool stopped = false;  ///< by progress, before all were done
  std::uint64_t seed = 1;
  std::vector<std::string> notes;  ///< for people, one sentence each
};

/// Flies the plan from the scene's site: as planned, once with its sensors, and many times. The dispersion is split:
/// sensors alone, vehicle and wind alone, both at once; run k has the same sensors and the same vehicle in each. The
/// flight's duration is cut to whole periods. Deterministic in (seed, run): the same for any number of threads.
///
/// Navigation is that of the scene (alignment, aids, filter); a scene without aids and alignment on the pad flies on the
/// strapdown alone. Errors of the world that the scene names act on the nominal flight's increments.
///
/// @throws std::invalid_argument as flight::fly and navigation::budget_scene do, and for runs < 0.
[[nodiscard]] Study study(const flight::Plan&, const flight::Dispersion&, const navigation::Scenario&,
                          const Study::Options&);

}  // namespace gyrobudget::inline v0::closed_loop
