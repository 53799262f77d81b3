// SPDX-License-Identifier: MIT
#include "factors.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {

std::vector<std::int64_t> octave_factors(std::int64_t samples) {
  std::vector<std::int64_t> factors;
  for (std::int64_t m = 1; m <= samples / 2; m *= 2) factors.push_back(m);
  return factors;
}

std::vector<std::int64_t> decade_factors(std::int64_t samples) {
  std::vector<std::int64_t> factors;
  for (std::int64_t decade = 1; decade <= samples / 2; decade *= 10) {
    for (const std::int64_t m : {decade, 2 * decade, 4 * decade}) {
      if (m <= samples / 2) factors.push_back(m);
    }
  }
  return factors;
}

std::vector<std::int64_t> all_factors(std::int64_t samples) {
  std::vector<std::int64_t> factors(static_cast<std::size_t>(std::max<std::int64_t>(samples / 2, 0)));
  std::iota(factors.begin(), factors.end(), 1);
  return factors;
}

std::vector<std::int64_t> log_factors(std::int64_t samples, std::int64_t count) {
  if (count < 1) {
    throw std::invalid_argument(fmt::format("number of averaging factors is {}; it must be at least 1", count));
  }
  const std::int64_t last = samples / 2;
  std::vector<std::int64_t> factors;
  if (last < 1) return factors;
  const double step = count > 1 ? std::log(static_cast<double>(last)) / static_cast<double>(count - 1) : 0;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t m = std::min<std::int64_t>(last, std::llround(std::exp(step * static_cast<double>(i))));
    if (factors.empty() || m > factors.back()) factors.push_back(m);
  }
  return factors;
}

}  // namespace gyrobudget::inline v0::allan
