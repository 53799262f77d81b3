// SPDX-License-Identifier: MIT
#include "motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::int64_t kBlock = 64, kBetween = 4;
constexpr double kTimesQuiet = 10, kQuietShare = 0.1, kComesBack = 0.1;
constexpr std::size_t kFewestBlocks = 16;

struct Block {
  double mean = 0, deviation = 0;  // NaN where a quarter of the samples is missing
};

Block block_of(std::span<const double> samples) {
  double sum = 0, squares = 0;
  for (const double y : samples) sum += y;
  if (std::isfinite(sum)) {  // the usual case: plain loops
    const auto size = static_cast<double>(samples.size());
    for (const double y : samples) squares += (y - sum / size) * (y - sum / size);
    return {sum / size, std::sqrt(squares / (size - 1))};
  }
  sum = 0;
  std::int64_t count = 0;
  for (const double y : samples)
    if (std::isfinite(y)) sum += y, ++count;
  const double mean = sum / static_cast<double>(count);
  for (const double y : samples)
    if (std::isfinite(y)) squares += (y - mean) * (y - mean);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  if (4 * count < 3 * static_cast<std::int64_t>(samples.size())) return {kNaN, kNaN};
  return {mean, std::sqrt(squares / static_cast<double>(count - 1))};
}

std::vector<Block> blocks_of(std::span<const double> rate) {
  std::vector<Block> blocks;
  for (std::size_t begin = 0; begin + kBlock <= rate.size(); begin += kBlock)
    blocks.push_back(block_of(rate.subspan(begin, kBlock)));
  return blocks;
}

// The standard deviation that a tenth of the blocks stays below.
double quiet_level(const std::vector<Block>& blocks) {
  std::vector<double> all;
  for (const Block& b : blocks)
    if (std::isfinite(b.deviation)) all.push_back(b.deviation);
  if (all.size() < kFewestBlocks) return std::numeric_limits<double>::infinity();
  const auto at = all.begin() + static_cast<std::ptrdiff_t>(kQuietShare * static_cast<double>(all.size()));
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

// The mean of the quiet blocks next to a motion; empty where there is none.
std::optional<double> level_beside(const std::vector<Block>& blocks, std::int64_t from, std::int64_t step) {
  double sum = 0;
  std::int64_t count = 0;
  for (std::int64_t i = from; i >= 0 && i < std::ssize(blocks) && count < kBetween; i += step) {
    const double mean = blocks[static_cast<std::size_t>(i)].mean;
    if (std::isfinite(mean)) sum += mean, ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

}  // namespace

std::vector<Motion> find_motion(std::span<const double> rate, double dt, double floor) {
  if (!(dt > 0)) throw std::invalid_argument(fmt::format("sample interval {} s is not above 0", dt));
  const std::vector<Block> blocks = blocks_of(rate);
  const double limit = kTimesQuiet * std::max(quiet_level(blocks), floor);
  std::vector<Motion> motions;
  if (!(limit > 0)) return motions;
  const std::int64_t end = std::ssize(blocks);
  const auto active = [&](std::int64_t i) { return blocks[static_cast<std::size_t>(i)].deviation > limit; };
  for (std::int64_t i = 0; i < end; ++i) {
    if (!active(i)) continue;
    std::int64_t last = i;
    for (std::int64_t j = i + 1; j < end && j <= last + kBetween; ++j) last = active(j) ? j : last;
    const auto before = level_beside(blocks, i - 1, -1), behind = level_beside(blocks, last + 1, 1);
    const double level = before && behind ? (*before + *behind) / 2 : before ? *before : behind.value_or(0);
    Motion motion{.first = i * kBlock, .count = (last - i + 1) * kBlock};
    for (std::int64_t k = motion.first; k < motion.first + motion.count; ++k) {
      const double distance = rate[static_cast<std::size_t>(k)] - level;
      if (!std::isfinite(distance)) continue;
      motion.turned += distance * dt;
      if (std::abs(distance) > std::abs(motion.peak)) motion.peak = distance;
    }
    const bool comes_back = !before || !behind || std::abs(*behind - *before) < kComesBack * std::abs(motion.peak);
    if (comes_back) motions.push_back(motion);
    i = last;
  }
  return motions;
}

}  // namespace gyrobudget::inline v0::allan
