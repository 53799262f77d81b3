// SPDX-License-Identifier: MIT
#include "turns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kWindow = 96;  // a multiple of 2, 3 and 4
constexpr std::size_t kFewestWindows = 16, kMostWindows = 2000;
constexpr double kVariances = 3, kLevels = 1.5;
constexpr double kSame = 0.75;       // of the windows have the same one loudest, or highest, as the one before
constexpr double kLeastFill = 0.75;  // of the rows of each sensor in a window

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Window {
  double variances = 1;                     // largest over smallest
  double distance = 0;                      // of the means
  double sigma = 0;                         // of a sample, all sensors together
  std::ptrdiff_t loudest = 0, highest = 0;  // whose they are
};

Window look(std::span<const double> rows, std::size_t sensors) {
  std::array<double, 4> means{}, variances{}, counts{};
  for (std::size_t i = 0; i < kWindow; ++i) {
    if (!std::isfinite(rows[i])) continue;
    means[i % sensors] += rows[i];
    ++counts[i % sensors];
  }
  const std::size_t rows_of_each = kWindow / sensors;
  const double fewest = kLeastFill * static_cast<double>(rows_of_each);
  for (std::size_t s = 0; s < sensors; ++s) {
    if (counts[s] < fewest) return {};
    means[s] /= counts[s];
  }
  for (std::size_t i = 0; i < kWindow; ++i) {
    const std::size_t s = i % sensors;
    if (std::isfinite(rows[i])) variances[s] += (rows[i] - means[s]) * (rows[i] - means[s]) / (counts[s] - 1);
  }
  const auto of = static_cast<std::ptrdiff_t>(sensors);
  const auto [low, high] = std::minmax_element(means.begin(), means.begin() + of);
  const auto [quiet, loud] = std::minmax_element(variances.begin(), variances.begin() + of);
  double sum = 0;
  for (std::size_t s = 0; s < sensors; ++s) sum += variances[s];
  return {*quiet > 0 ? *loud / *quiet : 1, *high - *low, std::sqrt(sum / static_cast<double>(sensors)),
          loud - variances.begin(), high - means.begin()};
}

}  // namespace

std::optional<Turns> find_turns(std::span<const double> rate) {
  const std::size_t windows = rate.size() / kWindow;
  if (windows < kFewestWindows) return std::nullopt;
  const std::size_t looks = std::min(windows, kMostWindows);
  std::optional<Turns> best;
  for (std::size_t sensors = 2; sensors <= 4; ++sensors) {
    std::vector<double> variances, distances, sigmas;
    double same_loudest = 0, same_highest = 0;
    Window before;
    for (std::size_t i = 0; i < looks; ++i) {
      const Window w = look(rate.subspan(i * windows / looks * kWindow, kWindow), sensors);
      if (!std::isfinite(w.sigma) || !(w.sigma > 0)) continue;
      same_loudest += !variances.empty() && w.loudest == before.loudest ? 1 : 0;
      same_highest += !variances.empty() && w.highest == before.highest ? 1 : 0;
      before = w;
      variances.push_back(w.variances), distances.push_back(w.distance), sigmas.push_back(w.sigma);
    }
    if (variances.size() < kFewestWindows) return best;
    const Turns found{static_cast<std::int64_t>(sensors), median(distances), std::sqrt(median(variances))};
    const double often = kSame * static_cast<double>(variances.size());
    const bool by_noise = found.noises * found.noises > kVariances && same_loudest > often;
    const bool by_level = found.levels > kLevels * median(sigmas) && same_highest > often;
    if (!by_noise && !by_level) continue;
    constexpr double kMoreVariance = 1.9, kMoreLevel = 1.25;
    const bool clearer = !best || found.noises * found.noises > kMoreVariance * best->noises * best->noises ||
                         (found.levels > kMoreLevel * best->levels && by_level);
    if (clearer) best = found;
  }
  return best;
}

}  // namespace gyrobudget::inline v0::allan
