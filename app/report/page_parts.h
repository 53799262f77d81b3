// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/report/result.h"

#include <string>
#include <string_view>

namespace gyrobudget::inline v0::report {

/// What page.js draws: allan_json and calibration_json, model curves, and every sentence, as one JSON text in which
/// no "<" occurs, so that it can stand inside a script element.
[[nodiscard]] std::string page_data(const LogResult&);

// The files of the page, embedded by embed.cmake.
extern const std::string_view kPageHtml, kPageCss, kPageJs, kChartJs;

}  // namespace gyrobudget::inline v0::report
