// SPDX-License-Identifier: MIT
#include "transformed.h"

#include "gyrobudget/noise/fft.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dst.h"
#include "fill.h"

namespace gyrobudget::inline v0::fit {
namespace {

constexpr std::int64_t kFewestSamples = 16;
constexpr std::int64_t kFewestPerFilled = 10;  // where more are missing, what is drawn shows in the answer

// Stretches of samples that exist, but for gaps of up to `longest_filled`.
std::vector<Stretch> stretches_of(std::span<const double> rate, std::int64_t longest_filled) {
  std::vector<Stretch> list;
  std::int64_t last = 0;  // one past the last sample that exists
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(rate.size()); ++i) {
    if (!std::isfinite(rate[static_cast<std::size_t>(i)])) continue;
    if (list.empty() || i - last > longest_filled) list.push_back({i, 0});
    last = i + 1;
    list.back().count = last - list.back().first;
  }
  return list;
}

std::vector<std::int64_t> missing_in(std::span<const double> rate) {
  std::vector<std::int64_t> missing;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    if (!std::isfinite(rate[i])) missing.push_back(static_cast<std::int64_t>(i));
  }
  return missing;
}

// Trimmed, longest first, the others in the order of time; none that is too short.
std::vector<Stretch> usable(std::vector<Stretch> list) {
  for (Stretch& s : list) s.count = noise::fft_length_within(s.count);
  std::erase_if(list, [](const Stretch& s) { return s.count < kFewestSamples; });
  const auto longest = std::ranges::max_element(list, {}, &Stretch::count);
  if (longest != list.end()) std::rotate(list.begin(), longest, longest + 1);
  return list;
}

std::span<const double> part_of(std::span<const double> rate, const Stretch& s) {
  return rate.subspan(static_cast<std::size_t>(s.first), static_cast<std::size_t>(s.count));
}

// Half of the largest change from one sample to the next that both exist.
double largest_change(std::span<const double> rate) {
  double largest = 0;
  for (std::size_t i = 1; i < rate.size(); ++i) {
    if (std::isfinite(rate[i]) && std::isfinite(rate[i - 1]))  // halves: a difference may be none
      largest = std::max(largest, std::abs(0.5 * rate[i] - 0.5 * rate[i - 1]));
  }
  return largest;
}

}  // namespace

std::int64_t Transformed::samples() const {
  std::int64_t sum = used.count;
  for (const auto& other : others) sum += other.used.count;
  return sum;
}

Transformed transform_record(std::span<const double> rate, double dt) {
  Transformed t;
  t.dt = dt;
  std::vector<Stretch> stretches;
  std::int64_t missing = 0, samples = 0;
  for (const std::int64_t longest_filled : {kLongestFilled, std::int64_t{0}}) {
    stretches = usable(stretches_of(rate, longest_filled));
    missing = samples = 0;
    for (const Stretch& s : stretches) {
      missing += static_cast<std::int64_t>(missing_in(part_of(rate, s)).size());
      samples += s.count;
    }
    if (kFewestPerFilled * missing <= samples) break;
  }
  if (stretches.empty()) {
    const auto whole = stretches_of(rate, 0);
    if (!whole.empty()) t.used = std::ranges::max(whole, {}, &Stretch::count);
    t.used.count = noise::fft_length_within(t.used.count);
    return t;
  }
  t.used = stretches.front();
  double largest = 0;
  for (const Stretch& s : stretches) largest = std::max(largest, largest_change(part_of(rate, s)));
  if (largest <= 0) return t;
  const int exponent = std::ilogb(largest) + 1;
  t.unit = std::ldexp(1.0, exponent);
  t.missing_share = static_cast<double>(missing) / static_cast<double>(samples);
  for (const Stretch& s : stretches) {
    const auto part = part_of(rate, s);
    TransformedStretch one{.used = s, .rate = {part.begin(), part.end()}, .coefficients = {}};
    for (double& y : one.rate) y = std::ldexp(y, -exponent);
    if (const auto gaps = missing_in(one.rate); !gaps.empty())
      fill_gaps(one.rate, gaps, static_cast<std::uint64_t>(s.first));
    one.coefficients = sine_transform_of_differences(one.rate);
    if (s.first == t.used.first)
      static_cast<TransformedStretch&>(t) = std::move(one);
    else
      t.others.push_back(std::move(one));
  }
  return t;
}

}  // namespace gyrobudget::inline v0::fit
