// SPDX-License-Identifier: MIT
// From a scene to its error budget: what is flown, what is wrong, what the filter is designed for.
#pragma once

#include "gyrobudget/estimation/navigation/scenario.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <string>
#include <vector>

#include "adjoint.h"
#include "error_budget.h"
#include "monte_carlo.h"
#include "sources.h"

namespace gyrobudget::inline v0::budget {

/// An axis of a sensor that senses more than its range along the trajectory, and is cut off there: linear covariance
/// knows nothing of that and does not hold.
struct OutOfRange {
  navigation::Carrier carrier = navigation::Carrier::gyro;
  int axis = 0;      ///< of the body, 0 to 2
  double from = 0;   ///< when it first is [s]
  double peak = 0;   ///< what it would sense, at most [rad/s, m/s^2]
  double range = 0;  ///< [rad/s, m/s^2]
};

/// A scene made ready for budget, adjoint and Monte Carlo.
///
/// - Unaided and with its start given: strapdown alone.
/// - With aids: the filter of `navigate`, its gains frozen; aids give fixes at their rate but for outages.
/// - With a start taken from an aid (FromAid): the start is wrong as that fix is, in the lines of the aid's errors, and
///   the filter knows it; that fix is not used again. Sigmas given beside it are what the filter is told instead.
/// - Aligning itself on the pad (AlignmentPlan::attitude a SelfAlignment): the scene starts `duration` earlier at rest,
///   with zero-velocity updates (of a `rest` aid, else 1 mm/s of sway each second). The filter starts from a coarse
///   alignment over the same pad, by a P0 of kCoarse times its sigma, so that what it finds is its own. The true error
///   of that start is a source's mean error over the pad by the alignment's gain (budget.h), in each source's own line:
///   no line is for the alignment, but `initial.heading` where a heading is given or none is found. The filter itself
///   takes start and sensors for independent: it claims up to 1/kCoarse^2 of a sigma too little. A wider P0 mends that
///   but lets the heading of a short alignment wander beyond linear theory.
struct BudgetScene {
  static constexpr double kCoarse = 5;

  Timeline timeline;
  Eigen::Matrix3d C_enu;     ///< east, north, up at the site
  Eigen::Matrix3d C_launch;  ///< downrange, crossrange (left), up
  std::vector<Source> sources;
  std::optional<Design> design;
  InitialErrors initial;  ///< that no sensor causes: the filter's P0 may be wider
  MonteCarlo::AidErrors aids;
  bool self_alignment = false;
  std::optional<double> heading_sigma;  ///< of a heading that the alignment is given [rad]
  std::string no_heading;  ///< what the alignment says where it finds none; empty: it finds one, or needs none
  std::vector<OutOfRange> out_of_range;                     ///< gyros first
  std::vector<navigation::SensorStates::LeftOut> left_out;  ///< by linear covariance and why
};

/// What else is asked of a scene, and what else is wrong in it. Of the 83 s ascent, length/200 is 8e-6 off in position
/// and length/50 1e-4, at no less run time: below that the states of 1/f take the time (budget_benchmark).
struct BudgetQuestion {
  double step = 0;             ///< of the covariance [s]; 0: scene_length/200, at most half a radian
                               ///< of turn, and at most 1 s below an hour
  double imu_interval = 0.01;  ///< [s]
  std::vector<double> at;      ///< times of interest besides the end and those of the growth [s]
  int growth_points = 60;      ///< times at which the growth is told; 0: none
  double gravity = 0;          ///< one sigma of a vertical error of gravity [m/s^2]
  double deflection = 0;       ///< of the vertical [rad]
  bool earth_rate_compensated = true;
};

/// What a scene asks by itself: its world, and whether its strapdown knows of Earth's rate.
[[nodiscard]] BudgetQuestion question_of(const navigation::Scenario& scenario, double imu_interval);

/// @throws navigation::SetupError for what Timeline, sensor_states and check(Aid) refuse, a rest where the trajectory
/// moves, a start from an aid that has no fix at 0 s, and more than a year.
[[nodiscard]] BudgetScene budget_scene(const navigation::Scenario& scenario, const earth::Trajectory& trajectory,
                                       const BudgetQuestion& question);

/// A source that may be left out before the long computation, and what that changes.
struct Negligible {
  std::string name;
  double position = 0;  ///< root sum square of its error at the times asked for, at most [m]
  /// Its largest part in the variance of any total at these times; 0: it has no effect in this scene.
  double share = 0;
};
/// Takes out the smallest sources as long as all of them together change no total of position, velocity or attitude at
/// `times` by more than `tolerance` of it. By the adjoint, exact at these times, gains frozen. Sources that have no
/// response are always taken out; none is where one grows beyond all numbers. Times must be times of interest of the
/// timeline.
/// @throws navigation::SetupError unless 0 <= tolerance < 1.
[[nodiscard]] std::vector<Negligible> leave_out(BudgetScene& scene, const FrozenGains& gains,
                                                std::span<const double> times, double tolerance);

/// dR/dp p/R of the total's position rss R at times[i] by each source's size p: its share of the variance.
[[nodiscard]] std::vector<double> shares(const Budget& budget, std::size_t i);

/// By how much a source may be larger or smaller (a factor of its size) so that the root sum square of position over
/// the axes in `axes` (columns) at times[i] is `limit` [m]; infinite where it plays no part, 0 where the others alone
/// exceed the limit.
[[nodiscard]] double allowed_factor(const Budget& budget, std::size_t i, std::string_view source,
                                    const Eigen::Matrix<double, 3, Eigen::Dynamic>& axes, double limit);

}  // namespace gyrobudget::inline v0::budget
