// SPDX-License-Identifier: MIT
#include "segments.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::log {
namespace {

using noise::kNanosecond;

/// Seconds from one stamp to a later one; below zero where the clock went back.
double seconds_between(std::int64_t from, std::int64_t to) {
  std::int64_t step = 0;
  if (!__builtin_sub_overflow(to, from, &step)) return static_cast<double>(step) * kNanosecond;
  return (static_cast<double>(to) - static_cast<double>(from)) * kNanosecond;
}

}  // namespace

Stretches cut(const Table& table, double rate_hz, double longest_gap_s) {
  const auto exists = [&](std::size_t row) {
    if (!table.stamps.empty() && table.stamps[row] == text::kNoStamp) return false;
    return std::ranges::any_of(table.numbers, [&](const auto& column) { return std::isfinite(column[row]); });
  };
  const auto seconds = [&](std::size_t from, std::size_t to) {
    return table.stamps.empty() ? static_cast<double>(to - from) / rate_hz
                                : seconds_between(table.stamps[from], table.stamps[to]);
  };
  Stretches result;
  Stretch now;
  const auto finish = [&] {
    result.longest_rows = std::max(result.longest_rows, now.rows);
    if (now.rows >= kFewestRows) {
      result.kept.push_back(now);
    } else if (now.rows > 0) {
      ++result.short_ones;
      result.short_rows += now.rows;
    }
  };
  std::optional<std::size_t> start, before;
  for (std::size_t row = 0; row < table.rows; ++row) {
    if (!exists(row)) continue;
    if (!start) start = row;
    const double step = before ? seconds(*before, row) : 0;
    if (!before || step < 0 || step > longest_gap_s) {
      finish();
      now = {row, 0, seconds(*start, row), {}};
      if (before && step >= 0) now.gap_s = step;
    }
    now.rows = row - now.first + 1;
    before = row;
  }
  finish();
  return result;
}

std::string describe(const Stretches& cuts, const std::vector<std::string>& lengths, double longest_gap_s) {
  constexpr std::size_t kNamed = 6;
  const auto restarts = std::ranges::count_if(cuts.kept, [](const auto& s) { return !s.gap_s; }) -
                        (cuts.kept.empty() || cuts.kept.front().gap_s ? 0 : 1);
  std::string text = fmt::format("cut where more than {:g} s is missing or time goes back: {} segment{} of ",
                                 longest_gap_s, lengths.size(), lengths.size() == 1 ? "" : "s");
  for (std::size_t i = 0; i < std::min(lengths.size(), kNamed); ++i) text += (i > 0 ? ", " : "") + lengths[i];
  if (lengths.size() > kNamed) text += ", ...";
  double longest = 0;
  for (const Stretch& stretch : cuts.kept) longest = std::max(longest, stretch.gap_s.value_or(0));
  if (longest > 0) text += fmt::format("; the longest gap lasts {:.6g} s", longest);
  if (restarts > 0) text += fmt::format("; time goes back {} time{}", restarts, restarts == 1 ? "" : "s");
  if (cuts.short_ones > 0) {
    text += fmt::format("; {} piece{} below {} rows left out ({} rows)", cuts.short_ones,
                        cuts.short_ones == 1 ? "" : "s", kFewestRows, cuts.short_rows);
  }
  return text;
}

}  // namespace gyrobudget::inline v0::log
