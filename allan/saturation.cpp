// SPDX-License-Identifier: MIT
#include "saturation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kNear = 5;  // the extreme value and the four next to it
constexpr double kTimes = 4, kMore = 10;

struct Value {
  double value = -std::numeric_limits<double>::infinity();
  std::int64_t count = 0;
};

// The largest different values of sign * rate with their counts, largest first.
std::array<Value, kNear> largest(std::span<const double> rate, double sign) {
  std::array<Value, kNear> top{};
  for (const double sample : rate) {
    const double y = sign * sample;
    if (!(y >= top.back().value) || !std::isfinite(y)) continue;
    const auto at = std::ranges::find_if(top, [&](const Value& v) { return v.value <= y; });
    if (at->value == y) {
      ++at->count;
    } else {
      std::move_backward(at, top.end() - 1, top.end());
      *at = {y, 1};
    }
  }
  return top;
}

// Whether an extreme value is frequent enough to be looked at; a loop plain enough to become vectors.
bool repeats_an_extreme(std::span<const double> rate) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double y : rate) {
    low = y < low ? y : low;
    high = y > high ? y : high;
  }
  std::int64_t at_low = 0, at_high = 0;
  for (const double y : rate) {
    at_low += y == low ? 1 : 0;
    at_high += y == high ? 1 : 0;
  }
  return static_cast<double>(std::max(at_low, at_high)) >= kMore;
}

Saturation described(std::span<const double> rate, double value) {
  Saturation found{.value = value, .count = 0, .first = -1, .longest = 0};
  std::int64_t run = 0;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    run = rate[i] == value ? run + 1 : 0;
    if (run == 0) continue;
    ++found.count;
    if (found.first < 0) found.first = static_cast<std::int64_t>(i);
    found.longest = std::max(found.longest, run);
  }
  return found;
}

}  // namespace

std::vector<Saturation> find_saturation(std::span<const double> rate) {
  std::vector<Saturation> ends;
  if (!repeats_an_extreme(rate)) return ends;
  const auto low = largest(rate, -1), high = largest(rate, 1);
  if (low.back().count == 0 || high.back().count == 0 || !(-low.back().value < high.back().value)) return ends;
  for (const auto& [top, sign] : {std::pair{low, -1.0}, std::pair{high, 1.0}}) {
    std::int64_t next = 0;
    for (std::size_t i = 1; i < kNear; ++i) next = std::max(next, top[i].count);
    if (static_cast<double>(top[0].count) >= kTimes * static_cast<double>(next) + kMore)
      ends.push_back(described(rate, sign * top[0].value));
  }
  return ends;
}

}  // namespace gyrobudget::inline v0::allan
