// SPDX-License-Identifier: MIT
// Inside navigation: what there is to do in a run, in the order of time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fix_track.h"

namespace gyrobudget::inline v0::navigation::detail {

inline constexpr double kSame = 2e-8;  ///< times that are one except for rounded stamps [s]

struct Event {
  double time = 0;
  std::size_t aid = 0;  ///< past the last: a solution
  std::size_t fix = 0;
};

struct EventList {
  std::vector<Event> events;           ///< aids before solutions, where they are at one time
  std::vector<std::int64_t> left_out;  ///< fixes of each aid that are not used
};

/// From where the filter starts to the end of the run. Fixes up to `used_to` of each aid are in the start already.
[[nodiscard]] EventList events(const Scenario& scenario, const std::vector<FixTrack>& tracks,
                               const std::vector<double>& used_to, const Span& run);

}  // namespace gyrobudget::inline v0::navigation::detail
