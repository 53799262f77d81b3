// SPDX-License-Identifier: MIT
#include "series.h"

#include <fmt/core.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

double checked_interval(double dt) {
  if (dt > 0 && std::isfinite(dt)) return dt;
  throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
}

double checked_fill(double minimum_fill) {
  if (minimum_fill > 0 && minimum_fill <= 1) return minimum_fill;
  throw std::invalid_argument(fmt::format("minimum fill of a cluster is {}; it must be in (0, 1]", minimum_fill));
}

}  // namespace

Series::Series(std::span<const double> rate, double dt, double minimum_fill)
    : rate_(rate), dt_(checked_interval(dt)), facts_(detail::census(rate, checked_fill(minimum_fill))) {}

const detail::Phase& Series::phase() const {
  // Isolated: a thread that waits in here must not take up other work that asks for the same sums.
  std::call_once(once_,
                 [this] { tbb::this_task_arena::isolate([this] { phase_ = detail::integrate(rate_, facts_); }); });
  return phase_;
}

void Series::require_factors(std::span<const std::int64_t> factors) const {
  const std::int64_t limit = samples() / 2;
  for (const std::int64_t m : factors) {
    if (m >= 1 && m <= limit) continue;
    throw std::invalid_argument(
        fmt::format("averaging factor is {}; for a record of {} samples it must be from 1 to {}", m, samples(), limit));
  }
}

}  // namespace gyrobudget::inline v0::allan
