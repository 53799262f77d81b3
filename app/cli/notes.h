// SPDX-License-Identifier: MIT
// What several verbs say beside their results.
#pragma once

#include "gyrobudget/estimation/closed_loop/study.h"

#include <cstdint>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::cli {

/// Where the filters of Monte Carlo refused far more fixes than a gate does by chance.
void note_refused(std::vector<std::string>& notes, std::int64_t fixes, std::int64_t refused);
/// What fails in a flight, as the scene says.
void note_faults(std::vector<std::string>& notes, const flight::Plan&);
/// Which flights of Monte Carlo were lost, how and when.
void note_lost(std::vector<std::string>& notes, const std::string& kind, const closed_loop::Flights&);

}  // namespace gyrobudget::inline v0::cli
