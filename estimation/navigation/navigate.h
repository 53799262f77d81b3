// SPDX-License-Identifier: MIT
// From a scene and what was recorded to a navigation solution in one call, with what the innovations say of it.
//
//     const navigation::Navigation found = navigation::navigate(scenario, recording);
//     if (found.status == navigation::Navigation::Status::navigated) use(found.solutions);
#pragma once

#include "gyrobudget/vehicle/earth/pose.h"

#include <optional>
#include <string>
#include <vector>

#include "recording.h"
#include "scenario.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::navigation {

/// The estimate at one time, with one sigma of each error.
struct Solution {
  double time = 0;    ///< of the scene [s]
  bool lost = false;  ///< within a LostSpan
  earth::Pose state;
  Eigen::Vector3d position_sigma;  ///< east, north, up at the place [m]
  Eigen::Vector3d velocity_sigma;  ///< [m/s]
  Eigen::Vector3d attitude_sigma;  ///< about east, north, up [rad]
  std::vector<double> terms;       ///< estimates of Navigation::model.terms
  std::vector<double> term_sigmas;
  // All that the model has of bias and its slow changes, in sum.
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero(),
                  gyro_bias_sigma = Eigen::Vector3d::Zero();  ///< [rad/s]
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero(),
                  accelerometer_bias_sigma = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// What one fix of an aid told.
struct InnovationAt {
  double time = 0;      ///< at which it held [s]
  std::size_t aid = 0;  ///< number in Scenario::aids
  Innovation innovation;
};

/// The innovations of one aid in sum. NIS of one fix is chi-square of rows() where the filter's sigmas are right.
struct AidSummary {
  std::size_t aid = 0;
  int rows = 0;
  std::int64_t used = 0, gated = 0, not_finite = 0;
  std::int64_t left_out = 0;         ///< before the start or in it, after the end, in an outage, outside its validity
  double nis_mean = 0;               ///< of those used
  double nis_low = 0, nis_high = 0;  ///< 95 % of nis_mean for right sigmas: chi-square of used * rows
  double inside_95 = 0;              ///< share of those used, and gated, below the 95 % point of chi-square
  Eigen::Vector3d residual_mean = Eigen::Vector3d::Zero();  ///< of those used, in the aid's components
  Eigen::Vector3d residual_rms = Eigen::Vector3d::Zero();

  /// More than a tenth of the fixes: the filter is surer than it should be.
  [[nodiscard]] bool many_refused() const { return 10 * gated > used + gated; }
};

/// The innovations of all aids in sum.
struct NisSummary {
  double mean = 0;       ///< NIS of those used over their degrees of freedom: 1 where the filter's sigmas are right
  double inside_95 = 0;  ///< share of those used, and gated, below the 95 % point of chi-square
};

/// Solution less reference, east, north, up: truth minus estimate has the other sign.
struct ReferenceError {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero(),
                  attitude = Eigen::Vector3d::Zero();
  Eigen::Vector3d position_sigma = Eigen::Vector3d::Zero(), velocity_sigma = Eigen::Vector3d::Zero(),
                  attitude_sigma = Eigen::Vector3d::Zero();
  double nees = 0;  ///< error^T P^-1 error of what the reference has
};

/// Over the epochs at which the reference has all it measures.
struct ReferenceSummary {
  bool has_position = false, has_velocity = false, has_attitude = false;
  int dof = 0;  ///< of NEES: 3 for each
  std::vector<ReferenceError> errors;
  double position_rms = 0, velocity_rms = 0, attitude_rms = 0;  ///< lengths of the vectors [m, m/s, rad]
  double nees_mean = 0;
  double nees_low = 0, nees_high = 0;  ///< 95 % of NEES at one epoch: chi-square of dof
  double nees_inside_95 = 0;           ///< share of epochs between them
};

/// A part of a run in which the filter was lost: its position is not to be used, nor its sigmas.
struct LostSpan {
  double from = 0;         ///< last fix before that agreed [s]
  double to = 0;           ///< found again, or the end of the run [s]
  bool recovered = false;  ///< found again: by the fixes
  bool held = true;        ///< and not soon lost again
  std::string why;         ///< it is taken for lost, in words
  std::string restarted;   ///< what was started again from the fixes: "position and velocity"
};

/// How the alignment went.
struct AlignmentResult {
  double from = 0, to = 0;  ///< [s]; the same where the start is given
  earth::Pose state;
  CoreMatrix covariance = CoreMatrix::Zero();  ///< in the order of error_state.h
  std::vector<std::string> words;              ///< what a person should know of it
};

struct Navigation {
  enum class Status {
    navigated,
    recovered,               ///< lost within Navigation::lost, found again after: the rest may be used
    lost,                    ///< the fixes do not agree with the filter, at the end or again and again
    no_start,                ///< an aid that the alignment needs has no fix, or the log ends before
    heading_not_observable,  ///< by these gyros at rest: give Alignment's heading
    not_at_rest,             ///< self-alignment on a body that moves
    failed,                  ///< the solution left what can be computed
  };
  Status status = Status::navigated;
  std::string why;  ///< in words, unless navigated
  /// Whether the numbers may be used, those of lost spans excepted.
  [[nodiscard]] bool usable() const { return status == Status::navigated || status == Status::recovered; }
  std::vector<LostSpan> lost;  ///< in the order of time

  ErrorStateModel model;        ///< of sensors and aids
  std::vector<double> initial;  ///< sigma of each term where the alignment ends
  StateMatrix P0;               ///< covariance of all states there, in the order of error_state.h
  std::vector<SensorStates::LeftOut> left_out;
  AlignmentResult alignment;
  std::vector<Solution> solutions;
  std::vector<InnovationAt> innovations;  ///< in the order of time
  std::vector<AidSummary> aids;           ///< those that are used, by number
  std::optional<ReferenceSummary> reference;
  std::int64_t steps = 0;  ///< of the strapdown

  /// Not a number, each of it, where no fix was used, or none was tested.
  [[nodiscard]] NisSummary nis() const;
};

/// Offline: alignment, filter, solutions at k solution_interval after the alignment and at Scenario::at.
///
/// A fix is used at the instant for which it holds, stamp + time_tag: a step of the IMU in which that falls is
/// split, by the increments of its neighbours to second order in the step. So are those of solutions. Fixes at
/// one instant are used in the order of the aids. A reference that is an aid with estimated errors (mounting,
/// lever arm) is compared as that aid sees it, with these estimates; it is interpolated to the solutions: positions
/// by cubics through position and velocity where it has both, else straight; attitudes along the shortest turn.
///
/// A start that is taken from an aid is one error with that aid's bias and correlated error; its lever arm is taken off
/// with the attitude of the start. Where no fix holds just then it is interpolated, and the fix behind is used no more.
///
/// An unknown time tag enters to first order, which holds as long as the motion does not change within it. So its
/// estimate is added to the stamps and the run repeated, until it moves by less than a tenth of its sigma, five times
/// at most; where the filter was lost, the estimate is that with ten times the aids' sigmas. The sigma that the scene
/// tells of it then counts about the shifted stamps, so only tags are shifted of which the fixes tell more (half that
/// sigma is left at most): theirs is up to 1.15 times too small. The solutions have the whole tag.
///
/// Earth rate, gravity and the rest as in strapdown.h and filter.h. The same bytes for the same input.
/// What is asked is the scene's: filter, smoothing, times of solutions, reference. Scenario::smooth keeps the
/// covariance of every solution in memory, n^2 numbers of 8 bytes for n states.
///
/// What the data cannot answer is Navigation::status, with the solutions up to there; so is an estimate that leaves
/// what can be computed (Diverged, earth::OutsideDomain).
/// @throws SetupError for a scene whose numbers are out of range, numbers of aids that there are not, more than 1e7
/// solutions or fixes of rest, and smoothing of considered states; RecordingError for aids and fixes that are not one
/// for one, or do not ascend; std::invalid_argument for increments that are not finite, which imu_log() never leaves.
[[nodiscard]] Navigation navigate(const Scenario& scenario, const Recording& recording);

}  // namespace gyrobudget::inline v0::navigation
