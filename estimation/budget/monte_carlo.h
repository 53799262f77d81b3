// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/estimation/navigation/filter.h"
#include "gyrobudget/noise/imu.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "error_budget.h"
#include "sources.h"

namespace gyrobudget::inline v0::budget {

/// Samples that an IMU cut off at its range, by body axis x, y, z.
struct Saturated {
  std::array<std::uint64_t, 3> gyro = {}, accelerometer = {};
  Saturated& operator+=(const Saturated& more);
  [[nodiscard]] std::uint64_t sum() const;
};

/// Fixes that filters were given, and how many of them their gates refused, which linear covariance knows nothing of.
struct FixCount {
  std::int64_t given = 0;
  std::int64_t refused = 0;
  FixCount& operator+=(const FixCount& more);
  /// Of all that were given; 0 of none.
  [[nodiscard]] double refused_share() const;
  /// More than a thousandth, far above any gate's share of right fixes: something is wrong that the filters are not
  /// designed for, and the covariance does not hold.
  [[nodiscard]] bool beyond_chance() const;
};

/// The whole chain, not linearised, flown many times: a simulated IMU (noise::Imu, 1/f as it is) on the exact
/// increments of the trajectory, a start that is wrong as it may be, fixes with their errors, strapdown and, where
/// there is a design, the filter.
struct MonteCarlo {
  struct Options {
    int runs = 100;
    std::uint64_t seed = 1;
    double imu_interval = 0.01;  ///< [s]
    noise::Imu::Options imu;     ///< epoch, vibration, and which sources are on
    /// The attitude at the start is that of a coarse alignment over the pad (alignment.h), after which the filter
    /// goes through the pad from its P0; InitialErrors' level does not count.
    bool self_alignment = false;
    /// Sigma of a heading from outside, of which the alignment is told [rad]. InitialErrors' heading is how wrong it
    /// is; where none is given, that does not count either.
    std::optional<double> heading_sigma;
    /// White noise is on the fixes of this aid alone, on none for -1; not given: on all.
    std::optional<int> noisy_aid;
    navigation::Filter::Options filter;
    /// Errors of the world as sources.h makes them (gravity_error, deflection_of_the_vertical): vectors fixed in
    /// other axes than the body's, each of a size drawn once a run.
    std::vector<Source> world;
    /// After each run, from one thread at a time: runs done so far; false stops.
    std::function<bool(int done)> progress;
  };
  /// What is wrong with aids beyond white noise: terms of Carrier::aid.
  struct AidErrors {
    navigation::ErrorStateModel model;
    navigation::StateMatrix initial;
    std::vector<navigation::PlannedFix> starts;  ///< fixes that the scene's start is taken from
  };

  std::vector<double> times;  ///< the timeline's times of interest [s]
  int runs = 0;               ///< done; fewer than asked where progress stopped it, or some found no heading
  int unaligned = 0;          ///< runs whose alignment on the pad found no heading: they have no errors
  /// [run][time] truth minus estimate of position [m], velocity [m/s] and attitude (rotation vector [rad]), axes of e.
  std::vector<std::vector<Eigen::Matrix<double, navigation::kCoreStates, 1>>> errors;
  Saturated saturated;  ///< all runs
  FixCount fixes;       ///< of all runs

  /// Second moment about zero of the errors at times[i], axes of e: sum e e^T/runs.
  /// @throws std::invalid_argument where there are no runs, and std::out_of_range for an i beyond `times`.
  [[nodiscard]] navigation::CoreMatrix covariance(std::size_t i) const;

  struct Nees {
    double mean = 0;  ///< over the runs
    int dof = 0;      ///< directions that count
    struct LeftOut {
      Eigen::Matrix<double, navigation::kCoreStates, 1>
          weights;        ///< of p, v, psi in local axes, each in units of its sigma
      double linear = 0;  ///< sigma of the sum by P, in these units
      double found = 0;   ///< root mean square of the runs
    };
    std::vector<LeftOut> left_out;  ///< directions without error of first order, smallest first
  };
  /// Mean NEES (consistency.h) against a covariance of first order at times[i], in the axes of a local frame:
  /// over the directions whose variance is above second_order(P) of sigma^2.
  /// @throws as covariance.
  [[nodiscard]] Nees nees(std::size_t i, const navigation::CoreMatrix& P, const Eigen::Matrix3d& C_el) const;
};

/// Variance, in units of sigma^2, that the first order leaves out beside what P holds: ten times the trace of
/// its attitude block [rad^2], as an attitude error psi turns vectors by psi^2/2 beyond the first order and the
/// terms met in tests come to 2 psi^2 at most; at least 1e-12. No more than 0.01: where that does not
/// suffice, a tenth of a sigma is at stake and NEES has to show it.
[[nodiscard]] double second_order(const navigation::CoreMatrix& P);

/// Deterministic in (seed, run): the same for any number of threads and of runs beside it.
/// Fixes, times of interest and the end are moved to the nearest end of an IMU sample, with the truth of that instant;
/// an end of the trajectory between two, to the last (less than an interval away).
/// Time: 1 to 3 us a sample and run, mostly the filter's covariance (Filter::Options::covariance_interval).
/// @throws navigation::SetupError for runs < 1, an interval that is not positive or longer than the trajectory, and
/// what Imu, Filter and Covariance refuse.
[[nodiscard]] MonteCarlo monte_carlo(const Timeline& timeline, const noise::SensorModel& sensor,
                                     const InitialErrors& initial, const Eigen::Matrix3d& C_el,
                                     const std::optional<Design>& design, const MonteCarlo::AidErrors& aids,
                                     const MonteCarlo::Options& options);

}  // namespace gyrobudget::inline v0::budget
