// SPDX-License-Identifier: MIT
// What the flights of a study say of its covariance: ratios of the sigmas that were found to those of the covariance,
// axis by axis, and where the two contradict each other by more than chance.
//
// Of n runs, a right sigma is found with a ratio whose square is chi-square with n degrees of freedom, over n
// (navigation::sigma_ratio_band). A ratio is compared only where it can be that: where the axis matters, where the
// covariance has more than what second order may add, and where the error is drawn anew in each run.
#pragma once

#include "gyrobudget/estimation/navigation/consistency.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "study.h"

namespace gyrobudget::inline v0::budget {

/// Sigma found and sigma of the covariance, axis by axis.
struct Agreement {
  struct Axis {
    double linear = 0, found = 0;  ///< [m, m/s, rad]
    double of_three = 0;           ///< root sum square of linear over the three axes of the quantity
    /// It has a hundredth or more of the total's variance there, by covariance or as found. With less it changes the
    /// total's sigma by 0.5 % at most, a tenth of what a thousand runs can see.
    bool matters = false;
    /// Linear is above what second order may add (second_order): the ratio is that of chi-square.
    bool first_order = false;
    [[nodiscard]] double ratio() const { return found / linear; }
  };
  std::array<Axis, navigation::kCoreStates> axes;  ///< position, velocity, attitude, each east, north, up
  double runs = 0;
  bool random = true;  ///< false: an error that is the same in every run

  /// Its ratio is that of chi-square where the covariance is right.
  [[nodiscard]] bool compares(const Axis& axis) const { return random && axis.matters && axis.first_order; }
};
inline constexpr double kBandOfOne = 0.99;  ///< probability of a band

/// Of a covariance and what `runs` runs found in its place, against the total of the study.
/// @pre there is Monte Carlo, as for all that follows.
[[nodiscard]] Agreement agreement(const Study& study, const navigation::CoreMatrix& linear,
                                  const navigation::CoreMatrix& found, double runs);
/// Of the total.
[[nodiscard]] Agreement total_agreement(const Study& study);
/// Of each line flown alone; none of a line that was not, and an empty list where none was asked for.
[[nodiscard]] std::vector<std::optional<Agreement>> source_agreements(const Study& study);

/// All ratios that may be compared, of the sources and the total.
struct AllRatios {
  int compared = 0;
  int outside = 0;            ///< of the 99 % band of each; a hundredth of `compared` by chance
  navigation::Band band;      ///< of 99 % for each
  navigation::Band together;  ///< holds all of them with 99 % or more (Bonferroni)
  struct Far {
    std::optional<std::size_t> line;  ///< of budget.lines; none: the total
    std::size_t axis = 0;             ///< in Agreement::axes
    double ratio = 0;
  };
  std::vector<Far> far;  ///< those outside of `together`
};
[[nodiscard]] AllRatios all_ratios(const Study& study);

/// An axis on which the flights contradict the covariance of the total, or NEES.
struct Contradiction {
  std::optional<std::size_t> axis;  ///< in Agreement::axes; none: NEES
  double found = 0;                 ///< [m, m/s, rad; NEES: its mean]
  double expected = 0;              ///< by the covariance, so too; of NEES its degrees of freedom
};
/// Where the flights contradict the covariance of the total by more than chance (1 % in all) and by more than a tenth.
[[nodiscard]] std::vector<Contradiction> contradictions(const Study& study);

/// 99 % band of the ratio of one right sigma, and of the mean NEES of a right covariance (as of one degree of freedom
/// where no direction counts).
[[nodiscard]] navigation::Band ratio_band(const Study& study);
[[nodiscard]] navigation::Band nees_band(const Study& study);

}  // namespace gyrobudget::inline v0::budget
