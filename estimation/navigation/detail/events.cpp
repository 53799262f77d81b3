// SPDX-License-Identifier: MIT
#include "events.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "measure_fix.h"

namespace gyrobudget::inline v0::navigation::detail {
namespace {

void add_solutions(const Scenario& scenario, const Span& run, std::vector<Event>& list) {
  const std::size_t solution = scenario.aids.size();
  const double interval = scenario.solution_interval;
  for (std::int64_t k = 0; run.from + static_cast<double>(k) * interval <= run.to + kSame; ++k)
    list.push_back({run.from + static_cast<double>(k) * interval, solution, 0});
  for (const double t : scenario.at) {
    const double k = std::round((t - run.from) / interval);
    const bool is_one = std::abs(run.from + k * interval - t) <= kSame;
    if (t >= run.from && t <= run.to && !is_one) list.push_back({t, solution, 0});
  }
}

}  // namespace

EventList events(const Scenario& scenario, const std::vector<FixTrack>& tracks, const std::vector<double>& used_to,
                 const Span& run) {
  EventList result;
  result.left_out.assign(scenario.aids.size(), 0);
  std::vector<Event>& list = result.events;
  for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
    const Aid& aid = scenario.aids[i];
    if (!aid.used) continue;
    const auto add = [&](double t, std::size_t fix) {
      if (t > used_to[i] + kSame && t <= run.to + kSame && in_use(aid, t))
        list.push_back({t, i, fix});
      else
        ++result.left_out[i];
    };
    if (aid.kind == Aid::Kind::rest) {
      const double from = std::max(aid.valid.from, run.from), to = std::min(aid.valid.to, run.to);
      for (std::int64_t k = 1; from + static_cast<double>(k) / aid.rate <= to; ++k)
        add(from + static_cast<double>(k) / aid.rate, 0);
    } else {
      for (std::size_t k = 0; k < tracks[i].size(); ++k) add(tracks[i].time(k), k);
    }
  }
  add_solutions(scenario, run, list);
  constexpr double kTick = 1e-7;  // s: within it the order is that of the aids
  std::ranges::stable_sort(list, {}, [](const Event& e) { return std::pair(std::llround(e.time / kTick), e.aid); });
  return result;
}

}  // namespace gyrobudget::inline v0::navigation::detail
