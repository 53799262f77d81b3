// SPDX-License-Identifier: MIT
// Slow, plain implementations that share no code with the library, and records to try both on.
#pragma once

#include "gyrobudget/allan/form.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace gyrobudget::allan::reference {

/// Reproducible standard normal numbers.
inline std::vector<double> normal(std::size_t count, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> distribution;
  std::vector<double> values(count);
  for (double& value : values) value = distribution(bits);
  return values;
}

/// What an estimate is made of.
struct Estimate {
  long double variance = 0;
  std::int64_t terms = 0;
};

/// The definition, O(n m): every cluster mean summed anew in long double over the samples that exist.
Estimate overlapped_variance(std::span<const double> rate, std::int64_t m, Form form, double minimum_fill = 0.95);

/// The same exactly, for rates that are whole multiples of `step`: integer sums, one rounding at the end.
long double exact_overlapped_variance(std::span<const double> rate, double step, std::int64_t m);

}  // namespace gyrobudget::allan::reference
