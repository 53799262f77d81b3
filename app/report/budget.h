// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/budget/alignment_time.h"
#include "gyrobudget/estimation/budget/scene.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// An error budget as people and programs want it. Local axes are east, north, up at the site, or where the
// scene has none at the place reached; downrange and crossrange
// (left of it) lie in the launch plane's frame; attitude errors are rotation vectors in east, north, up.
namespace gyrobudget::inline v0::report {

/// The budget of one scene with one sensor.
struct BudgetResult {
  std::string scene;   ///< its path
  std::string name;    ///< as it calls itself
  std::string sensor;  ///< path of the sensor file; empty: ideal
  std::string command;
  double at = 0;             ///< time of the table [s]
  std::size_t at_index = 0;  ///< in budget.times
  budget::Budget budget;
  Eigen::Matrix3d C_enu = Eigen::Matrix3d::Identity(), C_launch = Eigen::Matrix3d::Identity();
  bool aided = false;
  double pad = 0;  ///< self-alignment before the scene [s]
  double tolerance = 0;
  std::vector<budget::Negligible> left_out;
  std::vector<navigation::SensorStates::LeftOut> not_modelled;
  bool interrupted = false;  ///< Monte Carlo, before all its runs were done
  std::vector<std::string> notes;
  int flicker_states = 0;  ///< Gauss-Markov states an axis for 1/f noise

  /// The same lines without states for 1/f, at `at`.
  std::optional<std::vector<navigation::CoreMatrix>> exact;
  /// The whole chain, not linearised.
  struct MonteCarlo {
    int runs = 0;
    std::uint64_t seed = 0;
    navigation::CoreMatrix covariance;    ///< at `at`
    budget::MonteCarlo::Nees nees;        ///< against the total
    std::vector<Eigen::Vector3d> points;  ///< position errors of each run, east, north, up [m]
    budget::Saturated saturated;
    struct Alone {
      int runs = 0;
      navigation::CoreMatrix covariance;  ///< at `at`
    };
    /// Each line of the budget flown alone, where asked for; none for what no flight has (scene_runs.h).
    std::vector<std::optional<Alone>> sources;
  };
  std::optional<MonteCarlo> monte_carlo;

  /// "crossrange < 10 m": what each source may grow to.
  struct Limit {
    std::string text;
    std::string component;                           ///< east, north, up, downrange, crossrange, horizontal, rss
    double limit = 0;                                ///< [m]
    double found = 0;                                ///< [m]
    std::vector<double> factors;                     ///< for each line, of its size
    std::optional<budget::AlignmentTime> alignment;  ///< where the scene aligns itself
  };
  std::optional<Limit> limit;
};

/// Position of one sigma along a component of the table: east, north, up, downrange, crossrange, horizontal, rss.
/// @throws std::invalid_argument for another name.
[[nodiscard]] double position_sigma(const BudgetResult&, const navigation::CoreMatrix&, std::string_view component);
/// Its axes as columns, in ECEF.
[[nodiscard]] Eigen::Matrix<double, 3, Eigen::Dynamic> component_axes(const BudgetResult&, std::string_view component);

/// Tables for the terminal; several results side by side below the first's.
[[nodiscard]] std::string budget_text(const std::vector<BudgetResult>&);
/// The fields are described by schema/budget-1.schema.json, and those of several sensors by schema/budgets-1.schema.json;
/// both are installed with the program. A ratio is null where its axis has below a hundredth of the total's variance, or
/// less than second order may add. Bands are 99 %.
[[nodiscard]] std::string budget_json(const std::vector<BudgetResult>&);
/// One HTML page that opens offline.
[[nodiscard]] std::string budget_page(const std::vector<BudgetResult>&);

}  // namespace gyrobudget::inline v0::report
