// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/navigation/consistency.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "budget.h"

// What flights say of a covariance, for tables, programs and the page.
namespace gyrobudget::inline v0::report {

/// Sigma found and sigma of the covariance, axis by axis.
struct Agreement {
  struct Axis {
    double linear = 0, found = 0;  ///< [m, m/s, rad]
    double of_three = 0;           ///< root sum square of linear over the three axes of the quantity
    /// It has a hundredth or more of the total's variance there, by covariance or as found. With less it changes the
    /// total's sigma by 0.5 % at most, a tenth of what a thousand runs can see.
    bool matters = false;
    /// Linear is above what second order may add (navigation::second_order): the ratio is that of chi-square.
    bool first_order = false;
    [[nodiscard]] double ratio() const { return found / linear; }
  };
  std::array<Axis, navigation::kCoreStates> axes;  ///< position, velocity, attitude, each east, north, up
  double runs = 0;
  bool random = true;  ///< false: an error that is the same in every run

  /// Its ratio is that of chi-square where the covariance is right.
  [[nodiscard]] bool compares(const Axis& axis) const { return random && axis.matters && axis.first_order; }
};
inline constexpr std::array kQuantities{"position", "velocity", "attitude"};
inline constexpr std::array kAxisNames{"east", "north", "up"};
inline constexpr double kBandOfOne = 0.99;  ///< probability of a band

[[nodiscard]] Agreement agreement(const BudgetResult&, const navigation::CoreMatrix& linear,
                                  const navigation::CoreMatrix& found, double runs);
/// Of the total. @pre there was Monte Carlo.
[[nodiscard]] Agreement total_agreement(const BudgetResult&);
/// Of each line flown alone.
[[nodiscard]] std::vector<std::optional<Agreement>> source_agreements(const BudgetResult&);

/// All ratios that may be compared, of the sources and the total.
struct AllRatios {
  int compared = 0;
  int outside = 0;               ///< of the 99 % band of each; a hundredth of `compared` by chance
  navigation::Band band;         ///< of 99 % for each
  navigation::Band together;     ///< holds all of them with 99 % or more (Bonferroni)
  std::vector<std::string> far;  ///< "gyro.arw, attitude up": those outside of it
};
[[nodiscard]] AllRatios all_ratios(const BudgetResult&);

/// Where the flights contradict the covariance of the total by more than chance (1 % in all) and by more than a tenth:
/// "position up: 31.2 m where the covariance has 4.05 m".
[[nodiscard]] std::vector<std::string> contradictions(const BudgetResult&);

/// "east velocity 0.82, up velocity 0.46, east position -0.34": what a direction is made of.
[[nodiscard]] std::string direction_text(const budget::MonteCarlo::Nees::LeftOut&);

}  // namespace gyrobudget::inline v0::report
