// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace gyrobudget::inline v0::allan::detail {

inline constexpr int kSumLanes = 16;

/// sum_{i < count} body(i), in a fixed number of lanes: the compiler can use registers of any width without
/// changing a bit. `body` must be always inlined.
template <typename Body>
[[gnu::always_inline]] inline double lane_sum(std::int64_t count, Body body) {
  double lane[kSumLanes] = {};
  std::int64_t i = 0;
  for (; i + kSumLanes <= count; i += kSumLanes) {
    for (int l = 0; l < kSumLanes; ++l) lane[l] += body(i + l);
  }
  for (int l = 0; i + l < count; ++l) lane[l] += body(i + l);
  for (int half = kSumLanes / 2; half > 0; half /= 2) {
    for (int l = 0; l < half; ++l) lane[l] += lane[l + half];
  }
  return lane[0];
}

}  // namespace gyrobudget::inline v0::allan::detail
