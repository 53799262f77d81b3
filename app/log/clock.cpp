// SPDX-License-Identifier: MIT
#include "clock.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>

namespace gyrobudget::inline v0::log {
namespace {

/// The middle one of the steps above zero between stamps that follow one another [ns]; 0 where there is none.
double middle_step(const std::vector<std::int64_t>& stamps) {
  constexpr std::size_t kEnough = 1 << 16;  // evenly spread; the median needs no more
  const std::size_t stride = stamps.size() / kEnough + 1;
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < stamps.size(); i += stride) {
    std::int64_t step = 0;
    if (stamps[i] == text::kNoStamp || stamps[i - 1] == text::kNoStamp) continue;
    if (!__builtin_sub_overflow(stamps[i], stamps[i - 1], &step) && step > 0) steps.push_back(step);
  }
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return static_cast<double>(*middle);
}

bool falls(const std::vector<std::int64_t>& stamps) {
  std::int64_t before = text::kNoStamp;  // less than any other
  return std::ranges::any_of(stamps, [&](std::int64_t stamp) {
    if (stamp == text::kNoStamp) return false;
    return stamp < std::exchange(before, stamp);
  });
}

/// A clock that is made from a counter of 16 bits starts again with that: at 65536 of its steps.
std::vector<Wrap> with_counted_wrap(std::vector<Wrap> wraps, double step) {
  constexpr double kCounts = 65536;
  const bool is_sure = wraps.front().known;
  if (!is_sure && kCounts * step < 0x1p62) wraps.push_back({static_cast<std::int64_t>(kCounts * step), false});
  std::ranges::sort(wraps, {}, &Wrap::period_ns);
  return wraps;
}

std::string period_text(std::int64_t period, const Choice& choice) {
  if (period == kDay) return "midnight";
  if (period == kWeek) return "the end of the week";
  return choice.stamps[0].ns_per_unit > 0 && period % choice.stamps[0].ns_per_unit == 0
             ? fmt::format("{}", period / choice.stamps[0].ns_per_unit)
             : text::duration_text(static_cast<double>(period) * noise::kNanosecond);
}

// --- Runs of equal stamps ------------------------------------------------------------------------------------------

struct Run {
  std::size_t first = 0, rows = 0;
};

/// Share of the rows with a stamp that repeats the one before; 0 where time goes back.
double repeated_share(const std::vector<std::int64_t>& stamps) {
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] < stamps[i - 1]) return 0;  // or is missing
    repeated += stamps[i] == stamps[i - 1] ? 1 : 0;
  }
  return stamps.empty() ? 0 : static_cast<double>(repeated) / static_cast<double>(stamps.size());
}

/// Spreads a run over [stamp, stamp + quantum): the first one of a log ends with its rows, the last one begins so.
void spread_run(std::vector<std::int64_t>& stamps, const Run& run, double quantum, double interval) {
  const bool starts = run.first == 0, ends = run.first + run.rows == stamps.size();
  const auto rows = static_cast<double>(run.rows);
  const bool is_part = (starts || ends) && rows * interval < quantum;
  const double step = is_part ? interval : quantum / rows;
  const double begin = is_part && starts ? quantum - rows * interval : 0;
  for (std::size_t i = 0; i < run.rows; ++i)
    stamps[run.first + i] += static_cast<std::int64_t>(begin + (static_cast<double>(i) + 0.5) * step);
}

}  // namespace

bool Unroller::start_again(std::int64_t stamp) {
  constexpr double kLongest = 16, kHalf = 0.5;
  for (const Wrap& wrap : wraps_) {
    std::int64_t next = 0, step = 0, offset = 0;
    if (__builtin_add_overflow(stamp, wrap.period_ns, &next) || __builtin_sub_overflow(next, before_, &step) ||
        __builtin_add_overflow(offset_, wrap.period_ns, &offset))
      continue;
    const double longest = wrap.known ? kHalf * static_cast<double>(wrap.period_ns) : kLongest * step_;
    if (step < 0 || static_cast<double>(step) > longest) continue;
    offset_ = offset;
    period_ = wrap.period_ns;
    ++times_;
    return true;
  }
  return false;
}

std::int64_t Unroller::operator()(std::int64_t stamp) {
  if (stamp == text::kNoStamp) return stamp;
  std::int64_t now = 0;
  if (__builtin_add_overflow(stamp, offset_, &now)) return stamp;
  if (started_ && now < before_ && start_again(now)) now = stamp + offset_;
  started_ = true;
  return before_ = now;
}

std::optional<std::string> unroll(std::vector<std::int64_t>& stamps, const Choice& choice) {
  if (choice.wraps.empty() || !falls(stamps)) return std::nullopt;
  const double step = middle_step(stamps);
  Unroller next(with_counted_wrap(choice.wraps, step), step);
  for (std::int64_t& stamp : stamps) stamp = next(stamp);
  if (next.times() == 0) return std::nullopt;
  return fmt::format("the time {} starts again at {}, {} time{}: it is counted on", choice.time_name,
                     period_text(next.period(), choice), next.times(), next.times() == 1 ? "" : "s");
}

std::optional<std::string> count_through(std::vector<std::int64_t>& stamps, double rate_hz,
                                         const std::string& time_name) {
  constexpr double kCoarse = 1.2;  // samples from stamp to stamp
  if (repeated_share(stamps) <= kMostRepeated) return std::nullopt;
  const double quantum = middle_step(stamps), interval = noise::kNanosecondsPerSecond / rate_hz;
  const double largest = static_cast<double>(stamps.back()) + quantum;
  if (quantum < kCoarse * interval || largest > 0x1p62) return std::nullopt;
  for (std::size_t first = 0; first < stamps.size();) {
    Run run{first, 1};
    while (first + run.rows < stamps.size() && stamps[first + run.rows] == stamps[first]) ++run.rows;
    spread_run(stamps, run, quantum, interval);
    first += run.rows;
  }
  return fmt::format("the time {} goes in steps of {:g} s: the rows between are counted through at --rate", time_name,
                     quantum * noise::kNanosecond);
}

}  // namespace gyrobudget::inline v0::log
