// SPDX-License-Identifier: MIT
#include "rounding.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kFewestSamples = 64, kWindow = 32;
constexpr double kWhole = 0.01;           // of a step
constexpr double kLeastStep = 1.0 / 20;   // of the scatter
constexpr double kCancelling = -0.25;     // autocorrelation of neighbours
constexpr std::size_t kFirstLook = 4096;  // differences, before all are looked at

/// The smallest difference above zero of the samples from `begin` to `end`; 0 where all are equal.
double smallest_step(std::span<const double> rate) {
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < rate.size(); ++i) {
    const double d = std::abs(rate[i] - rate[i - 1]);
    if (d > 0 && d < step) step = d;
  }
  return std::isfinite(step) ? step : 0;
}

bool are_multiples(std::span<const double> rate, double step) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  for (std::size_t i = 1; i < rate.size(); ++i) {
    const double steps = std::abs(rate[i] - rate[i - 1]) / step;
    if (!std::isfinite(steps)) continue;
    if (std::abs(steps - std::round(steps)) > kWhole + kRounding * std::abs(rate[i]) / step) return false;
  }
  return kRounding * std::abs(rate[0]) < kWhole * step;  // else the step is one of double
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::int64_t count_distinct(std::span<const double> rate) {
  constexpr auto kMost = static_cast<std::size_t>(Rounding::kMostDistinct);
  std::vector<double> values;
  for (std::size_t begin = 0; begin < rate.size(); begin += kMost) {
    for (std::size_t i = begin; i < std::min(begin + kMost, rate.size()); ++i)
      if (std::isfinite(rate[i])) values.push_back(rate[i]);
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    if (values.size() >= kMost) return Rounding::kMostDistinct;
  }
  return static_cast<std::int64_t>(values.size());
}

// Of windows of samples: their scatter, the range of their means, and whether neighbours cancel.
void look_at_windows(std::span<const double> rate, Rounding& found) {
  std::vector<double> variances;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, together = 0, all = 0;
  for (std::size_t begin = 0; begin + kWindow <= rate.size(); begin += kWindow) {
    const auto window = rate.subspan(begin, kWindow);
    double sum = 0, squares = 0, products = 0;
    for (const double y : window) sum += y;
    if (!std::isfinite(sum)) continue;
    const double mean = sum / kWindow;
    for (std::size_t i = 0; i < kWindow; ++i) {
      squares += (window[i] - mean) * (window[i] - mean);
      if (i > 0) products += (window[i] - mean) * (window[i - 1] - mean);
    }
    variances.push_back(squares / (kWindow - 1));
    lowest = std::min(lowest, mean), highest = std::max(highest, mean);
    together += products, all += squares;
  }
  if (variances.empty()) return;
  found.scatter = std::sqrt(median(variances));
  found.wander = (highest - lowest) / found.step;
  found.of_angle = together < kCancelling * all;
}

}  // namespace

std::optional<Rounding> find_rounding(std::span<const double> rate) {
  if (rate.size() < kFewestSamples) return std::nullopt;
  // A record without steps shows it in its first samples.
  const auto first = rate.first(std::min(kFirstLook, rate.size()));
  if (Rounding seen{.step = smallest_step(first)}; seen.step > 0) {
    look_at_windows(first, seen);
    if (2 * seen.step < kLeastStep * seen.scatter || !are_multiples(first, seen.step)) return std::nullopt;
  }
  Rounding found{.step = smallest_step(rate)};
  if (!(found.step > 0) || !are_multiples(rate, found.step)) return std::nullopt;
  look_at_windows(rate, found);
  if (found.step < kLeastStep * found.scatter) return std::nullopt;
  found.distinct = count_distinct(rate);
  return found;
}

}  // namespace gyrobudget::inline v0::allan
