// SPDX-License-Identifier: MIT
#include "tried.h"

#include "gyrobudget/noise/constants.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::navigation::detail {

Recording beginning(const Scenario& scenario, const Recording& whole) {
  const double start = scenario.alignment.start;
  const auto first_of = [&](double t) {
    const std::int64_t stamp = whole.origin + static_cast<std::int64_t>(std::llround(t / noise::kNanosecond));
    return static_cast<std::size_t>(std::ranges::lower_bound(whole.imu.stamps, stamp) - whole.imu.stamps.begin());
  };
  const double log_start = static_cast<double>(whole.imu.stamps.front() - whole.origin) * noise::kNanosecond;
  const std::size_t from = start > log_start ? std::max<std::size_t>(first_of(start), 1) - 1 : 0;
  const std::size_t last = whole.imu.increments.size();
  const std::size_t to = std::min({last, from + kMostSteps, first_of(std::max(start, log_start) + kMostSeconds)});
  if (from >= to) return whole;
  const auto cut = [&](const auto& list, std::size_t end) {
    return std::decay_t<decltype(list)>(list.begin() + static_cast<std::ptrdiff_t>(from),
                                        list.begin() + static_cast<std::ptrdiff_t>(end));
  };
  Recording part = whole;
  part.imu.stamps = cut(whole.imu.stamps, to + 1);
  part.imu.increments = cut(whole.imu.increments, to);
  part.imu.bridged = cut(whole.imu.bridged, to);
  return part;
}

Scenario quick(Scenario scenario) {
  constexpr double kCovarianceInterval = 0.1;  // s
  scenario.recovery = false;
  scenario.smooth = false;
  scenario.reference.clear();
  scenario.at.clear();
  scenario.solution_interval = kMostSeconds;
  scenario.filter.covariance_interval = std::max(scenario.filter.covariance_interval, kCovarianceInterval);
  return scenario;
}

}  // namespace gyrobudget::inline v0::navigation::detail
