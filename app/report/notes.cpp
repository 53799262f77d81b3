// SPDX-License-Identifier: MIT
#include "notes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace gyrobudget::inline v0::report {

void note_scene(std::vector<std::string>& notes, const std::string& no_heading,
                std::span<const budget::OutOfRange> out_of_range) {
  if (!no_heading.empty()) notes.push_back(no_heading);
  for (const budget::OutOfRange& o : out_of_range) {
    const bool gyro = o.carrier == navigation::Carrier::gyro;
    notes.push_back(fmt::format(
        "{} {} is cut off from {:.4g} s on: it senses up to {:.3g} {} where its range is {:.3g}; the covariance knows nothing of that and does not hold, look at Monte Carlo",
        gyro ? "gyro" : "accelerometer", "xyz"[o.axis], o.from, o.peak, gyro ? "rad/s" : "m/s^2", o.range));
  }
}

void note_refused(std::vector<std::string>& notes, const budget::FixCount& fixes) {
  if (!fixes.beyond_chance()) return;
  notes.push_back(fmt::format(
      "the filters of Monte Carlo refused {:.3g} % of their fixes: something is wrong that they are not designed for, such as errors of the world beside sensors that are ideal; linear covariance takes every fix. 'filter: {{gate: 0}}' has Monte Carlo take them too",
      100 * fixes.refused_share()));
}

void note_faults(std::vector<std::string>& notes, const flight::Plan& plan) {
  const flight::Faults& f = plan.flight.faults;
  const flight::NavigatorFaults& n = plan.navigator_faults;
  std::vector<std::string> what;
  if (std::isfinite(f.thrust_cut_at)) what.push_back(fmt::format("thrust cut at {:g} s", f.thrust_cut_at));
  if (std::isfinite(f.nozzle_stuck_at)) what.push_back(fmt::format("nozzle stuck at {:g} s", f.nozzle_stuck_at));
  if (!f.thrust_misalignment.isZero(0)) what.emplace_back("thrust misaligned");
  if (n.dead_gyro) what.push_back(fmt::format("gyro {} dead from {:g} s on", "xyz"[*n.dead_gyro], n.dead_gyro_at));
  if (n.delay > 0) what.push_back(fmt::format("navigation {:g} s late", n.delay));
  if (!what.empty())
    notes.push_back(fmt::format("faults: {}; the nominal flight has none of them", fmt::join(what, ", ")));
}

void note_lost(std::vector<std::string>& notes, std::string_view kind, const closed_loop::Flights& flights) {
  constexpr std::size_t kNamed = 3;
  if (flights.lost() == 0) return;
  std::vector<std::string> named;
  for (std::size_t run = 0; run < flights.outcomes.size() && named.size() < kNamed; ++run) {
    const closed_loop::Outcome& o = flights.outcomes[run];
    if (o.lost()) named.push_back(fmt::format("run {} {} at {:.4g} s", run, to_string(o.ended), o.t));
  }
  notes.push_back(fmt::format("{}: {} of {} flights were lost and are in no sigma: {}{}", kind, flights.lost(),
                              flights.outcomes.size(), fmt::join(named, ", "),
                              named.size() < static_cast<std::size_t>(flights.lost()) ? ", ..." : ""));
}

void note_short_flight(std::vector<std::string>& notes, const flight::Flight& flight, double duration) {
  if (!flight::ends_early(flight, duration)) return;
  notes.push_back(fmt::format("the flight ends at {:.4g} s and not at {:.4g} s: gyrobudget fly says why", duration,
                              flight::asked_duration(flight)));
}

}  // namespace gyrobudget::inline v0::report
