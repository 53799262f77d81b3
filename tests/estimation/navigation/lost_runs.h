// SPDX-License-Identifier: MIT
// Vehicles that lose their fixes, or begin in a wrong place: what a navigator makes of it, run by run.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

#include <string>
#include <vector>

namespace gyrobudget::lost {

struct Drive {
  std::string name;
  double speed, turn_acceleration, turn_period;  ///< of S-turns [m/s, m/s^2, s]
};
inline const Drive kCar{"car", 20, 2, 40}, kRover{"rover", 1.5, 0.3, 30}, kDrone{"drone", 8, 3, 20};

struct Case {
  Drive drive = kCar;
  double outage_from = 60, outage = 0;  ///< without fixes [s]
  double after = 60;                    ///< with fixes again [s]
  double start_error = 0;               ///< of the position, not told to the filter [m]
  double told = 1;                      ///< sigmas of the IMU that the filter is told, over the true ones
  bool recovery = true;
  int runs = 100;
};

struct Run {
  navigation::Navigation found;
  /// When the position was last off by more than 6 sigmas of it and of a fix together for five seconds on end, in
  /// solutions that may be used and are not flagged: lost, and nobody is told [s]; below 0: never.
  double unsaid_at = -1;
  /// From the first fix after the outage, or from the start, until it is off by no more than that for good [s];
  /// infinite: never.
  double found_after = 0;
};

/// GNSS of 2 m and 5 cm/s once a second, a MEMS IMU of the tests at 50 Hz. Deterministic in the run's number.
[[nodiscard]] std::vector<Run> drive(const Case& c);

/// Share of the epochs from `from` [s] on at which the mean NEES of the runs (9 states) is in its 95 % band; of runs
/// that may be used.
[[nodiscard]] double nees_inside(const std::vector<Run>& runs, double from);

}  // namespace gyrobudget::lost
