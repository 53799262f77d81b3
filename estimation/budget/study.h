// SPDX-License-Identifier: MIT
// The error budget of a scene in one call: what each source of error costs in position, velocity and attitude, what may
// be left out and by how much that is wrong, how large a source may be for a wanted accuracy, and whether flights of
// the whole chain bear the linear covariance out.
//
//     const budget::Study study = budget::study(scenario, earth::ascent({}), {.runs = 500});
//     for (std::size_t i = 0; i < study.budget.lines.size(); ++i)
//       use(study.budget.lines[i].name, study.axes.position_sigma(study.line(i), budget::Component::rss));
//
// Independent sources add up: P = sum_i P_i, each P_i carried along the scene by P+ = F P F^T + Q with the filter's
// gains frozen. The parts of it are scene.h (a scene made ready, what may be left out, how far a source may grow),
// error_budget.h (covariance by source, with the recursion), adjoint.h (the same as integrals), monte_carlo.h and
// scene_runs.h (flights of the whole chain and of one source), and agreement.h (what these say of the covariance).
#pragma once

#include "gyrobudget/estimation/navigation/scenario.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "alignment_time.h"
#include "components.h"
#include "error_budget.h"
#include "monte_carlo.h"
#include "scene.h"

namespace gyrobudget::inline v0::budget {

/// What is asked of a budget beside the scene itself.
struct Options {
  std::optional<double> at;  ///< time that is asked about, 0 to the scene's end [s]; none: the end
  /// Sources are left out that together change no total of position, velocity or attitude at `at` by more than this
  /// share of it (leave_out); none: every source is kept, those without any effect too.
  std::optional<double> tolerance = 1e-3;
  double step = 0;             ///< of the covariance [s]; 0: by the scene's length (BudgetQuestion)
  double imu_interval = 0.01;  ///< between samples of the IMU [s]
  bool exact = false;          ///< each source also by integrals over its structure function (adjoint.h)

  /// A position that is not to be exceeded.
  struct Limit {
    Component component = Component::rss;
    double position = 0;  ///< one sigma, above 0 [m]
  };
  std::optional<Limit> limit;

  int runs = 0;              ///< of Monte Carlo; 0: none
  bool each_source = false;  ///< and so many runs of each source alone; nothing where `runs` is 0
  std::uint64_t seed = 1;    ///< of the random numbers of Monte Carlo
  /// After each run, from one thread at a time: runs done so far and runs in all, those of the sources too; false
  /// stops.
  std::function<bool(std::int64_t done, std::int64_t all)> progress;
};

/// What was found. Covariances are of true errors of position [m], velocity [m/s] and attitude (rotation vector [rad])
/// in the axes of e, in the order of error_state.h; `axes` turns them into those of people.
struct Study {
  double at = 0;             ///< time that was asked about [s]
  std::size_t at_index = 0;  ///< of it in budget.times
  /// At the scene's site; of a scene without one, at the place that is reached, for on a cruise over a quarter of Earth
  /// the start's "up" says little.
  LocalAxes axes;
  bool aided = false;                ///< a filter uses fixes, with frozen gains; else the strapdown is alone
  double pad = 0;                    ///< alignment of the scene by itself before its start [s]
  double tolerance = 0;              ///< share of each total that was left out at most
  Budget budget;                     ///< without what was left out
  std::vector<Negligible> left_out;  ///< smallest first
  std::vector<navigation::SensorStates::LeftOut> not_modelled;  ///< what linear covariance knows nothing of, and why
  int flicker_states = 0;  ///< Gauss-Markov states that stand for 1/f noise, of the axis that has most

  // --- Where linear covariance does not hold ---
  /// What the alignment on the pad says where it finds no heading; empty: it finds one, or needs none.
  std::string no_heading;
  std::vector<OutOfRange> out_of_range;  ///< axes of sensors that are cut off
  /// The largest sigma of attitude about a local axis in the whole scene, where it is above kLinearAttitude.
  struct LargeAttitude {
    int axis = 0;      ///< 0 east, 1 north, 2 up
    double sigma = 0;  ///< [rad]
    double time = 0;   ///< [s]
  };
  std::optional<LargeAttitude> large_attitude;

  /// The sources of budget.lines at `at` by integrals, without states for what varies slowly; where they were asked
  /// for.
  std::optional<std::vector<navigation::CoreMatrix>> exact;

  /// How the limit that was asked for is met, by all sources, those left out too.
  struct Limit {
    Component component = Component::rss;
    double limit = 0;                        ///< [m]
    double found = 0;                        ///< root sum square of one sigma along the component's axes [m]
    std::vector<double> factors;             ///< by which each of budget.lines may grow alone (allowed_factor)
    std::optional<AlignmentTime> alignment;  ///< that would meet it, of a scene that aligns itself
    /// A number that is none meets no limit.
    [[nodiscard]] bool met() const { return found <= limit; }
  };
  std::optional<Limit> limit;

  /// Runs of Monte Carlo of the whole scene.
  struct Runs {
    int asked = 0;
    int flown = 0;      ///< to the end
    int unaligned = 0;  ///< that found no heading on the pad, and count for nothing
    FixCount fixes;
  };
  Runs runs;
  bool stopped = false;                   ///< Monte Carlo, by progress, before all its runs were done
  std::optional<std::size_t> stopped_at;  ///< the line of budget.lines whose own runs were stopped
  /// The whole chain, not linearised, at `at`; where it was asked for and a run got there.
  struct Flown {
    int runs = 0;
    std::uint64_t seed = 0;
    navigation::CoreMatrix covariance = navigation::CoreMatrix::Zero();  ///< second moment of the errors about zero
    MonteCarlo::Nees nees;                                               ///< against the total of all sources
    std::vector<Eigen::Vector3d> points;  ///< position errors of each run, east, north, up [m]
    Saturated saturated;
    struct Alone {
      int runs = 0;
      navigation::CoreMatrix covariance = navigation::CoreMatrix::Zero();
    };
    /// One for each of budget.lines, where they were asked for; none for what no flight has (fly_alone), and from
    /// stopped_at on.
    std::vector<std::optional<Alone>> sources;
  };
  std::optional<Flown> monte_carlo;

  [[nodiscard]] const navigation::CoreMatrix& total() const { return budget.total[at_index]; }
  /// @pre i < budget.lines.size()
  [[nodiscard]] const navigation::CoreMatrix& line(std::size_t i) const { return budget.lines[i].covariance[at_index]; }
  /// What the filter believes. @pre there is one: budget.claimed is not empty
  [[nodiscard]] const navigation::CoreMatrix& claimed() const { return budget.claimed[at_index]; }
};

/// Beyond this sigma of attitude the second order, which grows with its square, is not small beside the first [rad].
inline constexpr double kLinearAttitude = 5 * earth::kDegree;

/// The error budget of `scenario` along `trajectory`, as error_budget() has it, with what Options ask for.
/// Deterministic in Options::seed: the same bytes for any number of threads.
///
/// The linear part is exact to first order in the errors; `exact` and Monte Carlo tell how far that holds. Monte Carlo
/// finds a sigma to about 1/sqrt(2 runs) of itself. A scene takes milliseconds to seconds, a run 1 to 3 us a sample of
/// the IMU, and `alignment` of a limit a second or two.
///
/// @throws navigation::SetupError for options out of range, an `at` outside the scene, and as budget_scene(),
/// leave_out() and monte_carlo(); navigation::Diverged where errors grow beyond all numbers, as the vertical channel's
/// do within hours. What Options::progress throws passes through.
[[nodiscard]] Study study(const navigation::Scenario& scenario, const earth::Trajectory& trajectory,
                          const Options& options = {});

}  // namespace gyrobudget::inline v0::budget
