// SPDX-License-Identifier: MIT
#include "repeats.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

using Axes = std::span<const std::span<const double>>;

constexpr std::int64_t kFewestRows = 64;
constexpr double kLeastShare = 0.005;
constexpr double kTimesChance = 2, kStandardDeviations = 6;
constexpr double kFrozen = 3;  // times the mean hold

std::int64_t length_of(Axes axes) {
  if (axes.empty()) return 0;
  for (const auto& axis : axes) {
    if (axis.size() == axes.front().size()) continue;
    throw std::invalid_argument(
        fmt::format("an axis has {} samples, expected the first one's {}", axis.size(), axes.front().size()));
  }
  return static_cast<std::int64_t>(axes.front().size());
}

/// Which increments of an axis are 0, and the smallest that is not.
struct Increments {
  std::int64_t zero = 0, pairs = 0;
  double step = std::numeric_limits<double>::infinity();
};

Increments increments_of(std::span<const double> axis) {
  Increments found;
  for (std::size_t i = 1; i < axis.size(); ++i) {
    const double d = std::abs(axis[i] - axis[i - 1]);
    found.zero += d == 0 ? 1 : 0;
    found.pairs += std::isfinite(d) ? 1 : 0;
    if (d > 0 && d < found.step) found.step = d;
  }
  return found;
}

/// Share of the increments that rounding alone would make 0, at most: where steps are fine, as many as are of one step
/// among those that are not 0; else nothing tells how many, and all of them may be.
double chance_of(std::span<const double> axis, const Increments& found) {
  constexpr double kOne = 0.5, kTwo = 1.5, kFine = 0.02;
  std::int64_t one = 0;
  for (std::size_t i = 1; i < axis.size(); ++i) {
    const double steps = std::abs(axis[i] - axis[i - 1]) / found.step;
    one += steps > kOne && steps < kTwo ? 1 : 0;
  }
  const double share = static_cast<double>(one) / static_cast<double>(found.pairs - found.zero);
  return share < kFine ? share : static_cast<double>(found.zero) / static_cast<double>(found.pairs);
}

/// Whether row i has a number in every axis.
bool is_complete(Axes axes, std::int64_t i) {
  return std::ranges::all_of(axes, [&](const auto& a) { return std::isfinite(a[static_cast<std::size_t>(i)]); });
}

bool is_repeated(Axes axes, std::int64_t i) {
  return std::ranges::all_of(
      axes, [&](const auto& a) { return a[static_cast<std::size_t>(i)] == a[static_cast<std::size_t>(i - 1)]; });
}

/// Runs of rows with one reading; missing rows are a run with `first` of -1.
struct Hold {
  std::int64_t first = 0, rows = 0;
};

std::vector<Hold> holds_of(Axes axes, std::int64_t samples) {
  std::vector<Hold> holds;
  for (std::int64_t i = 0; i < samples; ++i) {
    const bool complete = is_complete(axes, i), empty = holds.empty();
    const bool same = !empty && (complete ? holds.back().first >= 0 && is_repeated(axes, i) : holds.back().first < 0);
    if (same) {
      ++holds.back().rows;
    } else {
      holds.push_back({complete ? i : -1, 1});
    }
  }
  return holds;
}

/// Mean rows of a reading, and the most: of those between two others, as the first and the last are cut.
struct Length {
  double mean = 1, longest = 1;
};

Length length_of(const std::vector<Hold>& holds) {
  Length length{0, std::numeric_limits<double>::infinity()};
  for (int pass = 0; pass < 3; ++pass) {  // frozen ones raise the mean that they are judged by
    const double limit = pass == 0 ? length.longest : kFrozen * length.mean + 1;
    std::int64_t rows = 0, count = 0, most = 1;
    for (std::size_t i = 1; i + 1 < holds.size(); ++i) {
      const bool whole = holds[i].first >= 0 && holds[i + 1].first >= 0 && holds[i - 1].first >= 0;
      if (!whole || static_cast<double>(holds[i].rows) > limit) continue;
      rows += holds[i].rows, ++count, most = std::max(most, holds[i].rows);
    }
    length = count == 0 ? Length{} : Length{static_cast<double>(rows) / static_cast<double>(count), double(most)};
  }
  return length;
}

}  // namespace

std::optional<Repeats> find_repeats(std::span<const std::span<const double>> axes) {
  const std::int64_t samples = length_of(axes);
  if (samples < kFewestRows) return std::nullopt;
  std::vector<std::span<const double>> alive;
  Repeats found{.chance = 1};
  double fewest = 1;  // repeats of an axis by itself
  for (const auto& axis : axes) {
    const Increments increments = increments_of(axis);
    if (increments.pairs > 0 && increments.zero == increments.pairs) continue;
    const auto least = kLeastShare * static_cast<double>(increments.pairs);
    if (static_cast<double>(increments.zero) < least) return std::nullopt;
    alive.push_back(axis);
    found.chance *= chance_of(axis, increments);
    fewest = std::min(fewest, static_cast<double>(increments.zero) / static_cast<double>(increments.pairs));
  }
  if (alive.empty()) return std::nullopt;
  for (std::int64_t i = 1; i < samples; ++i) {
    if (!is_complete(alive, i) || !is_complete(alive, i - 1)) continue;
    ++found.compared;
    found.repeated += is_repeated(alive, i) ? 1 : 0;
  }
  const auto rows = static_cast<double>(found.compared), repeated = static_cast<double>(found.repeated);
  const double by_chance = kTimesChance * found.chance * rows;
  constexpr double kTogether = 0.5;  // of what the axis with the fewest repeats by itself
  if (repeated < std::max(kLeastShare, kTogether * fewest) * rows ||
      repeated <= by_chance + kStandardDeviations * std::sqrt(by_chance))
    return std::nullopt;
  const Length length = length_of(holds_of(alive, samples));
  found.rows_each = length.mean;
  found.longest = length.longest;
  return found;
}

Readings readings_of(std::span<const std::span<const double>> axes) {
  const std::int64_t samples = length_of(axes);
  const std::vector<Hold> holds = holds_of(axes, samples);
  Readings readings{.rows_each = length_of(holds).mean};
  const auto intervals = [&](std::int64_t rows) {
    return std::max<std::int64_t>(1, std::llround(static_cast<double>(rows) / readings.rows_each));
  };
  const auto missing = [&](std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) readings.rows.push_back(-1), readings.holds.push_back(0);
  };
  for (const Hold& hold : holds) {
    if (hold.first < 0) {
      missing(intervals(hold.rows));
      continue;
    }
    const bool frozen = static_cast<double>(hold.rows) > kFrozen * readings.rows_each + 1;
    readings.rows.push_back(hold.first);
    readings.holds.push_back(frozen ? 1 : hold.rows);
    if (frozen) missing(intervals(hold.rows) - 1);
  }
  return readings;
}

std::vector<double> Readings::of(std::span<const double> axis) const {
  std::vector<double> values(rows.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] >= 0) values[i] = axis[static_cast<std::size_t>(rows[i])];
  }
  return values;
}

double added_by_uneven_holds(std::span<const double> readings, std::span<const std::int64_t> holds) {
  if (readings.size() != holds.size())
    throw std::invalid_argument(fmt::format("{} readings have {} holds", readings.size(), holds.size()));
  constexpr std::size_t kBlock = 8;
  double weighed = 0, weights = 0, count = 0, sum = 0, squares = 0;
  for (std::size_t begin = 0; begin + kBlock <= readings.size(); begin += kBlock) {
    double y = 0, h = 0;
    for (std::size_t i = begin; i < begin + kBlock; ++i) y += readings[i], h += static_cast<double>(holds[i]);
    if (!std::isfinite(y)) continue;
    double product = 0;
    for (std::size_t i = begin; i < begin + kBlock; ++i) {
      const auto hold = static_cast<double>(holds[i]);
      const double centred = hold - h / kBlock;
      product += centred * (readings[i] - y / kBlock);
      weights += centred * centred;
      sum += hold, squares += hold * hold, ++count;
    }
    weighed += product * product;
  }
  if (!(weights > 0)) return 0;
  const double mean = sum / count;
  return (squares / count / (mean * mean) - 1) * weighed / weights;
}

}  // namespace gyrobudget::inline v0::allan
