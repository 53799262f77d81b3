// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/navigation/budget.h"
#include "gyrobudget/navigation/budget_sources.h"
#include "gyrobudget/navigation/consistency.h"
#include "gyrobudget/navigation/filter.h"
#include "gyrobudget/noise/imu.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace gyrobudget::inline v0::navigation {

/// The whole chain, not linearised, flown many times: a simulated IMU (noise::Imu, 1/f as it is) on the exact increments
/// of the trajectory, a start that is wrong as it may be, fixes with their errors, strapdown and, where there is a
/// design, the filter.
struct MonteCarlo {
  struct Options {
    int runs = 100;
    std::uint64_t seed = 1;
    double imu_interval = 0.01;  ///< [s]
    noise::Imu::Options imu;     ///< epoch, vibration, and which sources are on
    bool initial_errors = true, fix_noise = true;
    /// The attitude at the start is that of a coarse alignment over the pad (alignment.h), after which the filter
    /// goes through the pad from its P0; InitialErrors' level and heading do not count.
    bool self_alignment = false;
    std::optional<double> heading_sigma;  ///< of a heading from outside that the alignment is given [rad]
    Filter::Options filter;
    /// Errors of the world as budget_sources.h makes them (gravity_error, deflection_of_the_vertical): vectors fixed in
    /// other axes than the body's, each of a size drawn once a run.
    std::vector<Source> world;
    /// After each run, from one thread at a time: runs done so far; false stops.
    std::function<bool(int)> progress;
  };
  /// What is wrong with aids beyond white noise: terms of Carrier::aid.
  struct AidErrors {
    ErrorStateModel model;
    StateMatrix initial;
    std::vector<PlannedFix> starts;  ///< fixes that the scene's start is taken from
  };

  std::vector<double> times;
  int runs = 0;       ///< done; fewer than asked where progress stopped it, or some found no heading
  int unaligned = 0;  ///< runs whose alignment on the pad found no heading: they have no errors
  /// [run][time] truth minus estimate of position, velocity and attitude, axes of e.
  std::vector<std::vector<Eigen::Matrix<double, kCoreStates, 1>>> errors;
  std::uint64_t saturated = 0;  ///< samples out of an axis' range, all runs

  /// Second moment about zero of the errors at times[i], axes of e.
  [[nodiscard]] CoreMatrix covariance(std::size_t i) const;
  /// Mean NEES against a covariance at times[i].
  [[nodiscard]] double mean_nees(std::size_t i, const CoreMatrix& P) const;
};

/// Deterministic in (seed, run): the same for any number of threads and of runs beside it.
/// Fixes, times of interest and the end are moved to the nearest end of an IMU sample, with the truth of that instant;
/// an end of the trajectory between two, to the last (less than an interval away).
/// @throws std::invalid_argument for runs < 1, an interval that is not positive or longer than the trajectory, and
/// what Imu, Filter and Covariance refuse.
[[nodiscard]] MonteCarlo monte_carlo(const Timeline&, const noise::SensorModel&, const InitialErrors&,
                                     const Eigen::Matrix3d& C_el, const std::optional<Design>&,
                                     const MonteCarlo::AidErrors&, const MonteCarlo::Options&);

}  // namespace gyrobudget::inline v0::navigation
