// SPDX-License-Identifier: MIT
// Closed-loop flights for the terminal.
#include "gyrobudget/estimation/closed_loop/flight_frame.h"
#include "gyrobudget/estimation/closed_loop/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "flight_words.h"
#include "layout.h"
#include "sensor_words.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using closed_loop::FlightFrame;
using closed_loop::Flights;
using closed_loop::FromPad;
using closed_loop::Outcome;
using closed_loop::Study;
using Eigen::Vector3d;
using navigation::CoreMatrix;

using earth::kDegree;
constexpr double kKilo = 1000;

// A table whose first columns are text and all others numbers.
TextTable numbers_table(const std::vector<std::string>& heads, std::size_t text_columns = 1) {
  std::vector<Align> columns(heads.size(), Align::right);
  std::fill_n(columns.begin(), text_columns, Align::left);
  TextTable table(columns);
  table.row(heads);
  return table;
}

void append(std::vector<std::string>& row, const Vector3d& v, int digits) {
  for (int i = 0; i < 3; ++i) row.push_back(number(v[i], digits));
}

std::string decibels(double x) { return std::isinf(x) ? "no limit" : fmt::format("{:.1f}", x); }

// The results whose nominal flight is told, and how it is called.
struct Nominal {
  const FlightResult* result;
  std::string name;
};
std::vector<Nominal> nominals(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  if (one_nominal(results)) return {{results.data(), "nominal"}};
  std::vector<Nominal> list;
  for (std::size_t i = 0; i < results.size(); ++i) list.push_back({&results[i], "nominal, " + names[i]});
  return list;
}

FlightFrame frame_of(const FlightResult& r) { return {r.plan, r.study.nominal}; }

// --- Head ------------------------------------------------------------------------------------------------

// "8 sourced, 2 derived, 20 assumed"
std::string origin_words(const FlightResult& r) {
  std::string words;
  for (const OriginCount& c : origins(r))
    if (c.numbers > 0) words += fmt::format("{}{} {}", words.empty() ? "" : ", ", c.numbers, c.origin);
  return words;
}

std::string plan_words(const FlightResult& r) {
  const flight::Flight& f = r.plan.flight;
  std::string out =
      fmt::format("  {}, azimuth {:.6g} deg, from {:.4f} deg, {:.4f} deg\n", printable(f.vehicle.name),
                  r.plan.control.azimuth / kDegree, f.world.site.latitude / kDegree, f.world.site.longitude / kDegree);
  if (const std::string words = origin_words(r); !words.empty())
    out += fmt::format("  the vehicle's numbers: {}\n", words);
  out += fmt::format("  control and navigation at {:.6g} Hz, {}\n", 1 / f.period,
                     r.plan.guidance ? "guided along the nominal trajectory" : "the program of attitude alone");
  const auto& work = r.study.nominal.work;
  out += fmt::format("  integrated by {}, {} steps of at most {:.6g} s\n", to_string(work.method),
                     count_text(work.steps), f.integration.step);
  if (r.study.runs > 0)
    out += fmt::format("  {} flights of each kind, seed {}\n", count_text(r.study.runs), r.study.seed);
  return out;
}

std::string head(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  std::string out = flight_title(results) + "\n";
  for (const Nominal& n : nominals(results, names)) out += plan_words(*n.result);
  for (std::size_t i = 0; i < results.size(); ++i)
    out += fmt::format("  {}: {}\n", names[i], navigation_words(results[i].study));
  return out;
}

// --- Where it ends -----------------------------------------------------------------------------------------

std::vector<std::string> end_row(const std::string& name, const FlightFrame& frame,
                                 const flight::FlightRecord& record) {
  const FromPad end = frame.from_pad(record.end);
  return {name,
          fmt::format("{:.2f}", end.t),
          number(end.place.height / kKilo, 5),
          number(end.position[0] / kKilo, 5),
          number(end.position[1], 4),
          number(end.velocity.norm(), 5),
          number(end.position.norm() / kKilo, 5),
          fmt::format("{:.2f}", end.attitude.pitch / kDegree),
          std::string(to_string(record.ended))};
}

std::string ends(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  TextTable table = numbers_table(
      {"flight", "t s", "height km", "downrange km", "crossrange m", "speed m/s", "distance km", "pitch deg", "ended"});
  for (const Nominal& n : nominals(results, names))
    table.row(end_row(n.name, frame_of(*n.result), n.result->study.nominal));
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (const auto& flown = results[i].study.flown)
      table.row(end_row(names[i], frame_of(results[i]), *flown));
    else
      table.row({names[i], "-", "-", "-", "-", "-", "-", "-", "not flown"});
  }
  return "\nWhere it ends: the IMU, with the sensors of run 0; crossrange is to the left\n" + table.text();
}

std::string accounts(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  std::string out;
  for (const Nominal& n : nominals(results, names))
    out += wrapped(fmt::format("{} {}", n.name, n.result->study.nominal.account), "  - ", "    ");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto& flown = results[i].study.flown;
    if (!flown)
      out += wrapped(fmt::format("{} {}", names[i], not_flown(results[i].study)), "  - ", "    ");
    else if (flown->ended != flight::Ended::complete)
      out += wrapped(fmt::format("{} {}", names[i], flown->account), "  - ", "    ");
  }
  return out;
}

std::string departures(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  TextTable table =
      numbers_table({"flight", "downrange m", "crossrange m", "up m", "distance m", "velocity m/s", "attitude deg"});
  bool any = false;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto& flown = results[i].study.flown;
    const auto d = flown ? frame_of(results[i]).departure(flown->end) : std::nullopt;
    if (!d) continue;
    any = true;
    std::vector<std::string> row{names[i]};
    append(row, d->position, 3);
    for (const double x : {d->position.norm(), d->velocity.norm(), d->attitude.norm() / kDegree})
      row.push_back(number(x, 3));
    table.row(row);
  }
  return any ? "\nDeparture from the nominal flight at the same time\n" + table.text() : "";
}

// --- Navigation error -----------------------------------------------------------------------------------------

std::vector<std::string> error_row(std::string name, const Study& s, const CoreMatrix& P, std::string share) {
  const auto sigmas = navigation::local_sigmas(P, s.C_launch);
  std::vector<std::string> row{std::move(name)};
  append(row, sigmas.position, 3);
  row.push_back(number(sigmas.position.norm(), 3));
  row.push_back(number(sigmas.velocity.norm(), 3));
  row.push_back(number(sigmas.attitude.norm() / kDegree, 3));
  row.push_back(std::move(share));
  return row;
}

std::string check_text(const Study& s) {
  const auto check = navigation_check(s);
  if (!check) return {};
  std::string out = "  sigma found over sigma of the total:";
  const char* const axes[] = {"downrange", "crossrange", "up"};
  for (int i = 0; i < 3; ++i) {
    const double ratio = check->position_ratio[i];
    out += fmt::format(" {} {}{}", axes[i], number(ratio, 3), check->holds(ratio) ? "" : " (outside)");
  }
  return out + fmt::format("\n  99 % of right ones lie in {} to {}\n", number(check->low, 3), number(check->high, 3));
}

std::string navigation_error(const FlightResult& r, const std::string& name) {
  const Study& s = r.study;
  std::string out =
      fmt::format("\nNavigation error at the end of the nominal flight, one sigma by linear covariance: {}\n", name);
  if (!s.budget) return out + "  none: the flight is too short to navigate\n";
  const std::string not_in_it = wrapped(not_stated_text(r.not_stated, kThisTotal), "  ", "  ");
  if (s.budget->lines.empty()) return out + "  none: nothing errs\n" + not_in_it;
  const std::size_t last = s.budget->times.size() - 1;
  const std::vector<double> share = budget::shares(*s.budget, last);
  std::vector<std::size_t> order(share.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return share[i]; });
  TextTable table =
      numbers_table({"source", "downrange m", "crossrange m", "up m", "rss m", "vel m/s", "att deg", "share"});
  for (const std::size_t i : order) {
    const auto& line = s.budget->lines[i];
    table.row(error_row(line.name, s, line.covariance[last], percent(share[i])));
  }
  table.row(error_row("total", s, s.budget->total[last], ""));
  if (!s.budget->claimed.empty()) table.row(error_row("claimed by the filter", s, s.budget->claimed[last], ""));
  if (s.sensors.complete() > 1)
    table.row(error_row(fmt::format("found in {} flights", count_text(s.sensors.complete())), s,
                        s.sensors.navigation_error(), ""));
  out += table.text() + not_in_it + check_text(s);
  for (const auto& l : s.left_out) out += wrapped(fmt::format("not in it: {}: {}", l.what, l.why), "  - ", "    ");
  return out;
}

// --- Dispersion -----------------------------------------------------------------------------------------------

std::vector<std::string> dispersion_row(const std::string& name, const FlightsOf& kind, double azimuth) {
  const Flights& f = *kind.flights;
  const auto position = f.spread(&Outcome::position);
  const closed_loop::Ellipse e = closed_loop::ellipse(position.covariance, azimuth);
  std::vector<std::string> row{name, std::string(kind.cause)};
  if (f.complete() < 2)
    row.insert(row.end(), 6, "-");
  else {
    append(row, position.sigma(), 3);
    row.push_back(fmt::format("{} x {}", number(e.semi_major, 3), number(e.semi_minor, 3)));
    row.push_back(number(f.spread(&Outcome::velocity).sigma().norm(), 3));
    row.push_back(number(f.spread(&Outcome::attitude).sigma().norm() / kDegree, 3));
  }
  row.push_back(count_text(f.complete()));
  row.push_back(count_text(f.lost() + f.unaligned()));
  return row;
}

std::string dispersion(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  TextTable table = numbers_table(
      {"flight", "cause", "downrange m", "crossrange m", "up m", "ellipse m", "vel m/s", "att deg", "flown", "lost"},
      2);
  const bool one = one_nominal(results);
  bool any = false;
  for (std::size_t i = 0; i < results.size(); ++i) {
    for (const FlightsOf& kind : causes(results[i].study)) {
      // The vehicle's own is the same for every sensor.
      if (kind.flights->outcomes.empty() || (i > 0 && one && kind.cause == "vehicle")) continue;
      any = true;
      table.row(
          dispersion_row(one && kind.cause == "vehicle" ? "any sensor" : names[i], kind, results[i].study.azimuth));
    }
  }
  return any ? "\nDispersion at the end about its mean, one sigma\n" + table.text() : "";
}

// --- Limits and margins -----------------------------------------------------------------------------------------

std::string limits(std::span<const FlightResult> results, const std::vector<std::string>& names) {
  TextTable table = numbers_table(
      {"flight", "highest q kPa", "at s", "Mach", "q x angle kPa deg", "nozzle deg", "of", "periods at a limit"});
  const auto row = [&](const std::string& name, const FlightResult& r, const flight::FlightRecord& record) {
    const closed_loop::LimitsUsed u = closed_loop::limits_used(r.plan.flight.vehicle, record);
    table.row({name, number(u.pressure / kKilo, 4), fmt::format("{:.1f}", u.pressure_at), number(u.mach, 3),
               number(u.pressure_angle / kDegree / kKilo, 3), number(u.deflection / kDegree, 3),
               number(u.deflection_limit / kDegree, 3), percent(u.limited)});
  };
  for (const Nominal& n : nominals(results, names)) row(n.name, *n.result, n.result->study.nominal);
  for (std::size_t i = 0; i < results.size(); ++i)
    if (const auto& flown = results[i].study.flown) row(names[i], results[i], *flown);
  return "\nLimits used; q is the dynamic pressure, the angle that of attack\n" + table.text();
}

std::string margins(const Study& s, const std::string& name) {
  const auto least = closed_loop::least_margins(s.margins);
  if (least.empty()) return {};
  TextTable table =
      numbers_table({"bending mode", "gain up dB", "at s", "gain down dB", "at s", "phase deg", "at s", ""});
  for (const closed_loop::LeastMargins& m : least) {
    const std::string mode = m.mode_factor == 1 ? "as planned" : fmt::format("{:+.0f} %", 100 * (m.mode_factor - 1));
    const auto at = [](double value, double t) { return std::isinf(value) ? "" : fmt::format("{:.0f}", t); };
    table.row({least.size() == 1 ? "none" : mode, decibels(m.gain_up_db), at(m.gain_up_db, m.gain_up_at),
               decibels(m.gain_down_db), at(m.gain_down_db, m.gain_down_at),
               std::isinf(m.phase_deg) ? "no limit" : fmt::format("{:.1f}", m.phase_deg), at(m.phase_deg, m.phase_at),
               !m.stable ? "UNSTABLE"
               : m.met() ? "met"
                         : "NOT MET"});
  }
  return fmt::format("\nLeast margins until {:.1f} s, where thrust fades; {:g} dB and {:g} deg are to be had: {}\n",
                     s.margins.until, closed_loop::kGainDemandDb, closed_loop::kPhaseDemandDeg, name) +
         table.text();
}

// --- Notes ----------------------------------------------------------------------------------------------------------

std::string notes(std::span<const FlightResult> results) {
  const std::vector<std::string> all = flight_notes(results);
  std::string out = all.empty() ? "" : "\nNotes\n";
  for (const auto& note : all) out += wrapped(note, "  - ", "    ");
  return out;
}

}  // namespace

std::string flight_text(std::span<const FlightResult> results) {
  const std::vector<std::string> names = flight_names(results);
  std::string out = head(results, names) + ends(results, names) + accounts(results, names) +
                    departures(results, names) + dispersion(results, names);
  for (std::size_t i = 0; i < results.size(); ++i) out += navigation_error(results[i], names[i]);
  out += limits(results, names);
  for (const Nominal& n : nominals(results, names)) out += margins(n.result->study, n.name);
  return out + notes(results);
}

}  // namespace gyrobudget::inline v0::report
