// SPDX-License-Identifier: MIT
#include "join.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

/// Rows with a stamp, in order.
std::vector<std::size_t> stamped_rows(const Table& table) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < table.stamps.size(); ++i)
    if (table.stamps[i] != text::kNoStamp) rows.push_back(i);
  return rows;
}

/// Middle step between rows [ns]; 0 where there is none.
double middle_interval(const std::vector<std::int64_t>& stamps, const std::vector<std::size_t>& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i)
    steps.push_back(static_cast<double>(stamps[rows[i]]) - static_cast<double>(stamps[rows[i - 1]]));
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return *middle;
}

double seconds_apart(std::int64_t from, std::int64_t to) {
  return (static_cast<double>(to) - static_cast<double>(from)) * noise::kNanosecond;
}

void check_overlap(const Joinable& base, const Joinable& other, const std::vector<std::size_t>& base_rows,
                   const std::vector<std::size_t>& other_rows) {
  for (const auto& [log, rows] : {std::pair{&base, &base_rows}, std::pair{&other, &other_rows}}) {
    const auto& stamps = log->table.stamps;
    const auto back = std::ranges::adjacent_find(*rows, [&](auto a, auto b) { return stamps[b] < stamps[a]; });
    if (rows->size() < 2 || back != rows->end())
      text::fail(log->source, rows->size() < 2
                                  ? "has no time that another log could be joined by; leave out --with"
                                  : "its time goes back, expected rising time to join logs by; put its rows in order");
  }
  const auto first = [](const Joinable& log, const auto& rows) { return log.table.stamps[rows.front()]; };
  const auto last = [](const Joinable& log, const auto& rows) { return log.table.stamps[rows.back()]; };
  const std::int64_t from = std::max(first(base, base_rows), first(other, other_rows));
  const std::int64_t to = std::min(last(base, base_rows), last(other, other_rows));
  if (from <= to) return;
  text::fail(
      other.source,
      fmt::format(
          "its time and that of {} do not overlap, {:.6g} s lie between them; join logs of one recording, with the same clock",
          base.source, seconds_apart(to, from)));
}

/// The place among the rows of the stamp that is nearest to a time; `from` is where to begin to look.
std::size_t nearest(const std::vector<std::int64_t>& stamps, const std::vector<std::size_t>& rows, std::int64_t time,
                    std::size_t from) {
  const auto away = [&](std::size_t i) { return std::abs(seconds_apart(stamps[rows[i]], time)); };
  while (from + 1 < rows.size() && away(from + 1) <= away(from)) ++from;
  return from;
}

/// What lies between the stamps as a rule [ns].
std::int64_t usual_offset(const Joinable& base, const Joinable& other, const std::vector<std::size_t>& base_rows,
                          const std::vector<std::size_t>& other_rows, double interval) {
  std::vector<std::int64_t> offsets;
  std::size_t at = 0;
  for (const std::size_t row : other_rows) {
    const std::int64_t time = other.table.stamps[row];
    at = nearest(base.table.stamps, base_rows, time, at);
    std::int64_t offset = 0;
    if (!__builtin_sub_overflow(time, base.table.stamps[base_rows[at]], &offset) &&
        std::abs(static_cast<double>(offset)) <= interval)
      offsets.push_back(offset);
  }
  if (offsets.empty()) return 0;
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::ranges::nth_element(offsets, middle);
  return *middle;
}

}  // namespace

bool is_faster(const Table& a, const Table& b) {
  const double of_a = middle_interval(a.stamps, stamped_rows(a)), of_b = middle_interval(b.stamps, stamped_rows(b));
  constexpr double kSame = 0.9;  // logs of one rate stay in the order in which they are named
  return of_a < kSame * of_b;
}

std::vector<std::string> join(Joinable& base, Joinable other) {
  const std::vector<std::size_t> base_rows = stamped_rows(base.table), other_rows = stamped_rows(other.table);
  check_overlap(base, other, base_rows, other_rows);
  const double interval = middle_interval(base.table.stamps, base_rows);
  const std::int64_t offset = usual_offset(base, other, base_rows, other_rows, interval);

  constexpr auto kFree = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> source_row(base.table.rows, kFree);
  std::size_t at = 0, lost = 0;
  for (const std::size_t row : other_rows) {
    const std::int64_t time = other.table.stamps[row] - offset;
    at = nearest(base.table.stamps, base_rows, time, at);
    const auto is_near = [&](std::size_t i) {
      return std::abs(seconds_apart(base.table.stamps[base_rows[i]], time)) <= interval * noise::kNanosecond;
    };
    // Where stamps jitter two rows may be nearest to one: the later one takes the next place.
    if (source_row[base_rows[at]] != kFree && at + 1 < base_rows.size() && is_near(at + 1)) ++at;
    if (source_row[base_rows[at]] == kFree && is_near(at))
      source_row[base_rows[at]] = row;
    else
      ++lost;
  }
  for (const auto& column : other.table.numbers) {
    std::vector<double>& placed = base.table.numbers.emplace_back(base.table.rows, std::nan(""));
    for (std::size_t row = 0; row < placed.size(); ++row)
      if (source_row[row] != kFree) placed[row] = column[source_row[row]];
  }
  const bool all = std::ranges::find(source_row, kFree) == source_row.end();
  base.table.complete = base.table.complete && other.table.complete && all;

  std::vector<std::string> notes{fmt::format(
      "{} is joined by time: its stamps are {:.3g} ms {} those of {}", other.source,
      std::abs(static_cast<double>(offset)) * noise::kNanosecond * 1e3, offset < 0 ? "before" : "behind", base.source)};
  if (lost > 0)
    notes.push_back(fmt::format("{} of {} rows of {} have no stamp of the other near theirs and are left out", lost,
                                other_rows.size(), other.source));
  return notes;
}

}  // namespace gyrobudget::inline v0::log
