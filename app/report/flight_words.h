// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/closed_loop/study.h"

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "flight.h"

// What terminal, JSON and page say of a flight, in words that they share; numbers are those of closed_loop.
namespace gyrobudget::inline v0::report {

/// What tells results apart, as short as it may be: the file of the sensor ("ideal" without one), its path, the file of
/// the scene, or both paths.
[[nodiscard]] std::vector<std::string> flight_names(std::span<const FlightResult>);
/// What the scene calls itself; of scenes with different names, what the vehicle is called.
[[nodiscard]] std::string flight_title(std::span<const FlightResult>);
/// "unaided strapdown", "strapdown and filter, aligned over 10 min on the pad before".
[[nodiscard]] std::string navigation_words(const closed_loop::Study&);
/// What a reader should know beside the tables, one sentence each: those of the study and those of the result.
[[nodiscard]] std::vector<std::string> notes_of(const FlightResult& result);
/// Notes of all, each once; one that is not of all with the names of those that it is of.
[[nodiscard]] std::vector<std::string> flight_notes(std::span<const FlightResult>);
/// Whether all have the same nominal flight (closed_loop::same_nominal): then it, what the vehicle disperses and the
/// margins are told once.
[[nodiscard]] bool one_nominal(std::span<const FlightResult>);
/// Why there is no flight with the sensors, in place of its account.
[[nodiscard]] std::string not_flown(const closed_loop::Study&);

/// Kinds of Monte Carlo flights, with their names.
struct FlightsOf {
  std::string_view cause;  ///< "sensors", "vehicle", "all"
  const closed_loop::Flights* flights;
};
[[nodiscard]] std::array<FlightsOf, 3> causes(const closed_loop::Study&);

/// How many of the vehicle's numbers are of an origin.
struct OriginCount {
  std::string_view origin;  ///< "sourced", "derived", "assumed", "not stated"
  int numbers = 0;
};
[[nodiscard]] std::array<OriginCount, 4> origins(const FlightResult&);

/// A number that was put in.
struct Input {
  std::string group, name, value, unit;
};
/// Flight, control, wind, dispersion, faults and integration; what is not there is left out.
[[nodiscard]] std::vector<Input> inputs(const FlightResult&);

}  // namespace gyrobudget::inline v0::report
