// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/budget/monte_carlo.h"
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/closed_loop/study.h"
#include "gyrobudget/vehicle/flight/fly.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

// Sentences that budgets and flights say beside their tables. Each is added where there is something to say.
namespace gyrobudget::inline v0::report {

/// What the scene says of where linear covariance does not hold: no heading on the pad, sensors that are cut off.
void note_scene(std::vector<std::string>& notes, const std::string& no_heading,
                std::span<const budget::OutOfRange> out_of_range);
/// Where the filters of Monte Carlo refused far more fixes than a gate does by chance.
void note_refused(std::vector<std::string>& notes, const budget::FixCount& fixes);
/// What fails in a flight, as the scene says.
void note_faults(std::vector<std::string>& notes, const flight::Plan& plan);
/// Which flights of Monte Carlo were lost, how and when. @param kind "sensors", "vehicle" or "all"
void note_lost(std::vector<std::string>& notes, std::string_view kind, const closed_loop::Flights& flights);
/// Where a planned trajectory is of a flight that ended before its time. @param duration of the trajectory [s]
void note_short_flight(std::vector<std::string>& notes, const flight::Flight& flight, double duration);

}  // namespace gyrobudget::inline v0::report
