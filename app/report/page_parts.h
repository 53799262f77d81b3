// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "accuracy.h"
#include "budget.h"
#include "flight.h"
#include "navigation.h"
#include "paper.h"
#include "result.h"

// What pages are put together from: shell.html around a body, which may start with head.html, plot.js before the page's
// own script.
namespace gyrobudget::inline v0::report {

/// A JSON text in which every "<" is an escape: it could close the script element the data stand in, and is the same
/// text to every JSON reader.
[[nodiscard]] std::string without_markup(const std::string& json);

/// What page.js draws: allan_json and calibration_json, model curves, and every sentence, as one JSON text without
/// "<". With `runs`, of which the result is side_by_side, the combined coefficients too.
[[nodiscard]] std::string page_data(const LogResult&, const RunsResult* runs = nullptr);
/// What paper.js draws: page_data of the four records, with the exact curves and the readings by eye, the rows of
/// paper_json as "paper", and the figures in time as "drifts" and "traces".
[[nodiscard]] std::string paper_data(const Paper&);

/// What accuracy.js draws: accuracy_json as "accuracy", and counts of the estimates and p-values in bins.
[[nodiscard]] std::string accuracy_data(const AccuracyStudy&);
/// What sweep.js draws: sweep_json as "sweep".
[[nodiscard]] std::string sweep_data(const SweepStudy&);
/// What navigation.js draws: navigation_json as "navigation", errors, sigmas, biases and innovations over time, and the
/// track.
[[nodiscard]] std::string navigation_data(const NavigationResult&);
/// What budget.js draws: budget_json of each sensor, ellipses, the cloud of Monte Carlo and what the filter claims.
[[nodiscard]] std::string budget_data(const std::vector<BudgetResult>&);
/// What flight.js draws: flight_json of each sensor with fewer points, the nominal flight, sigmas over time, and where
/// the flights of Monte Carlo ended.
[[nodiscard]] std::string flight_data(std::span<const FlightResult>);

// The files of the pages, embedded by embed.cmake.
extern const std::string_view kShellHtml, kHeadHtml, kPageCss, kPlotJs, kChartJs;
extern const std::string_view kPageHtml, kPageJs;              ///< datasheet
extern const std::string_view kPaperHtml, kPaperJs;            ///< paper
extern const std::string_view kAccuracyHtml, kAccuracyJs;      ///< accuracy
extern const std::string_view kSweepHtml, kSweepJs;            ///< accuracy --sweep
extern const std::string_view kNavigationHtml, kNavigationJs;  ///< navigate
extern const std::string_view kBudgetHtml, kBudgetJs;          ///< budget
extern const std::string_view kFlightHtml, kFlightJs;          ///< fly

}  // namespace gyrobudget::inline v0::report
