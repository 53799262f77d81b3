// SPDX-License-Identifier: MIT
#include "transformed.h"

#include "gyrobudget/noise/fft.h"

#include <algorithm>
#include <cmath>

#include "dst.h"

namespace gyrobudget::inline v0::fit {
namespace {

constexpr std::int64_t kFewestSamples = 16;

Stretch longest_stretch(std::span<const double> rate) {
  Stretch best, now;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    if (std::isfinite(rate[i])) {
      ++now.count;
      if (now.count > best.count) best = now;
    } else {
      now = {static_cast<std::int64_t>(i) + 1, 0};
    }
  }
  return best;
}

}  // namespace

Transformed transform_record(std::span<const double> rate, double dt) {
  Transformed t;
  t.dt = dt;
  t.used = longest_stretch(rate);
  t.used.count = noise::fft_length_within(t.used.count);
  if (t.used.count < kFewestSamples) return t;
  const auto part = rate.subspan(static_cast<std::size_t>(t.used.first), static_cast<std::size_t>(t.used.count));
  double largest = 0;  // halves: a difference of two finite numbers may be none
  for (std::size_t i = 1; i < part.size(); ++i)
    largest = std::max(largest, std::abs(0.5 * part[i] - 0.5 * part[i - 1]));
  if (largest <= 0) return t;
  const int exponent = std::ilogb(largest) + 1;
  t.unit = std::ldexp(1.0, exponent);
  t.rate.assign(part.begin(), part.end());
  for (double& y : t.rate) y = std::ldexp(y, -exponent);
  t.coefficients = sine_transform_of_differences(t.rate);
  return t;
}

}  // namespace gyrobudget::inline v0::fit
