// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/budget/agreement.h"

#include <array>
#include <string>
#include <vector>

#include "budget.h"

// What a budget and its flights say, in the words that tables, programs and the page share.
namespace gyrobudget::inline v0::report {

inline constexpr std::array kQuantities{"position", "velocity", "attitude"};
inline constexpr std::array kAxisNames{"east", "north", "up"};

/// Root sum square of the position's sigmas [m].
[[nodiscard]] double position_rss(const BudgetResult& result, const navigation::CoreMatrix& P);

/// "gyro.arw, attitude up 1.31": ratios that lie outside of the band of all.
[[nodiscard]] std::vector<std::string> far_words(const budget::Study& study, const budget::AllRatios& ratios);

/// "position up: 31.2 m where the covariance has 4.05 m", "NEES: 31.2 where a right covariance gives 9".
[[nodiscard]] std::vector<std::string> contradiction_words(const budget::Study& study);

/// "east velocity 0.82, up velocity 0.46, east position -0.34": what a direction is made of.
[[nodiscard]] std::string direction_text(const budget::MonteCarlo::Nees::LeftOut& direction);

/// "0.0004 of the total's variance at most", "has no effect in this scene".
[[nodiscard]] std::string why_left_out(const budget::Negligible& source);

/// What a reader should know beside the tables, one sentence each: those of the result and those of its study.
[[nodiscard]] std::vector<std::string> budget_notes(const BudgetResult& result);

}  // namespace gyrobudget::inline v0::report
