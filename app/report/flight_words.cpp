// SPDX-License-Identifier: MIT
#include "flight_words.h"

#include "gyrobudget/estimation/closed_loop/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "notes.h"
#include "words.h"

namespace gyrobudget::inline v0::report {

using closed_loop::Study;

std::vector<std::string> flight_names(std::span<const FlightResult> results) {
  using Name = std::string (*)(const FlightResult&);
  constexpr std::array<Name, 4> kWays{
      [](const FlightResult& r) { return r.sensor.empty() ? "ideal" : file_name(r.sensor); },
      [](const FlightResult& r) { return r.sensor.empty() ? "ideal" : r.sensor; },
      [](const FlightResult& r) { return file_name(r.scene); },
      [](const FlightResult& r) { return r.scene + ", " + (r.sensor.empty() ? "ideal" : r.sensor); },
  };
  std::vector<std::string> names;
  for (const Name way : kWays) {
    names.clear();
    for (const auto& r : results) names.push_back(printable(way(r)));
    if (std::set(names.begin(), names.end()).size() == names.size()) break;
  }
  return names;
}

std::string flight_title(std::span<const FlightResult> results) {
  const FlightResult& first = results[0];
  const bool one = std::ranges::all_of(results, [&](const auto& r) { return r.name == first.name; });
  if (!one) return printable(first.plan.flight.vehicle.name);
  return printable(first.name.empty() ? first.scene : first.name);
}

std::string navigation_words(const Study& s) {
  std::string words = s.aided ? "strapdown and filter" : "unaided strapdown";
  if (s.pad > 0) words += ", aligned over " + duration_text(s.pad) + " on the pad before";
  return words;
}

std::vector<std::string> notes_of(const FlightResult& r) {
  const Study& s = r.study;
  std::vector<std::string> notes;
  if (s.too_short()) notes.push_back(fmt::format("the flight is too short to navigate: it {}", s.nominal.account));
  note_scene(notes, s.no_heading, s.out_of_range);
  if (s.not_compared())
    notes.push_back(fmt::format("no flights were compared, as the nominal one itself {}", s.nominal.account));
  note_faults(notes, r.plan);
  if (s.stopped) notes.push_back(fmt::format("interrupted: {} of {} flights of each kind", s.runs, s.asked));
  for (const FlightsOf& kind : causes(s)) note_lost(notes, kind.cause, *kind.flights);
  note_refused(notes, s.sensors.fixes());
  notes.insert(notes.end(), r.notes.begin(), r.notes.end());
  return notes;
}

std::vector<std::string> flight_notes(std::span<const FlightResult> results) {
  struct Note {
    std::string text, names;
    std::size_t count = 0;
  };
  const std::vector<std::string> names = flight_names(results);
  std::vector<Note> notes;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const auto& text : notes_of(results[i])) {
      auto note = std::ranges::find(notes, text, &Note::text);
      if (note == notes.end()) note = notes.insert(notes.end(), {.text = text});
      note->names += (note->count++ > 0 ? ", " : "") + names[i];
    }
  std::vector<std::string> out;
  for (const Note& n : notes)
    out.push_back(n.count >= results.size() ? printable(n.text) : n.names + ": " + printable(n.text));
  return out;
}

bool one_nominal(std::span<const FlightResult> results) {
  return std::ranges::all_of(results, [&](const FlightResult& r) { return same_nominal(r.study, results[0].study); });
}

std::string not_flown(const Study& s) {
  return s.too_short() ? "was not flown: the flight is too short to navigate"
                       : "was not flown: its alignment on the pad found no heading";
}

std::array<FlightsOf, 3> causes(const Study& s) {
  return {{{"sensors", &s.sensors}, {"vehicle", &s.vehicle}, {"all", &s.all}}};
}

std::array<OriginCount, 4> origins(const FlightResult& r) {
  using flight::Origin;
  std::array<OriginCount, 4> counts;
  const std::array<std::optional<Origin>, 4> all{Origin::sourced, Origin::derived, Origin::assumed, std::nullopt};
  for (std::size_t i = 0; i < all.size(); ++i)
    counts[i] = {files::to_string(all[i]),
                 static_cast<int>(std::ranges::count(r.vehicle_numbers, all[i], &files::VehicleNumber::origin))};
  return counts;
}

}  // namespace gyrobudget::inline v0::report
