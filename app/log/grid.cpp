// SPDX-License-Identifier: MIT
#include "grid.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

using noise::kNanosecond;
constexpr std::int64_t kCentury = 3'155'760'000'000'000'000;  // [ns] the longest log; keeps sums within 64 bits
constexpr double kSameRate = 1e-6;                            // rates this near are one rate, written with other digits

double hertz(double interval_ns) { return 1 / (interval_ns * kNanosecond); }

// --- A first look at the stamps ------------------------------------------------------------------------------------

struct Steps {
  std::size_t stamps = 0;   ///< rows with a stamp
  std::size_t missing = 0;  ///< rows without
  std::size_t repeated = 0;
  std::size_t first_repeated = 0;  ///< its row
  double median = 0;               ///< of the steps above zero [ns]
  double regular_mean = 0;         ///< of the steps within half a median of it
  double mean = 0;                 ///< of all of them: gaps included
};

class Scan {
 public:
  Scan(const std::vector<std::int64_t>& stamps, const TimeColumn& column) : stamps_(stamps), column_(column) {}

  Steps run() {
    count_stamps();
    walk([&](std::size_t row, std::int64_t step) { see(row, step); });
    check_repeated();
    find_median();
    find_means();
    return steps_;
  }

 private:
  void count_stamps() {
    steps_.missing = static_cast<std::size_t>(std::ranges::count(stamps_, text::kNoStamp));
    steps_.stamps = stamps_.size() - steps_.missing;
    if (steps_.stamps >= 2) return;
    text::fail(column_.source,
               fmt::format("the time {} holds fewer than two stamps; correct it, or remove it and give --rate HZ",
                           column_.name));
  }

  /// Calls see(row, step) for each stamp but the first.
  template <class See>
  void walk(See see) {
    std::optional<std::int64_t> first;
    std::int64_t before = 0;  // since the first, as all that follows: within a century, so that nothing overflows
    for (std::size_t row = 0; row < stamps_.size(); ++row) {
      if (stamps_[row] == text::kNoStamp) continue;
      if (!first) {
        first = stamps_[row];
        continue;
      }
      std::int64_t since = 0;
      if (__builtin_sub_overflow(stamps_[row], *first, &since))
        since = stamps_[row] < *first ? -kCentury : kCentury + 1;
      if (since > kCentury) fail_at_row(row, "is more than a century after its start");
      since = std::max(since, -kCentury);
      see(row, since - before);
      before = since;
    }
  }

  void see(std::size_t row, std::int64_t step) {
    if (step < 0) {
      fail_at_row(row, fmt::format("goes back by {:g} s", -static_cast<double>(step) * kNanosecond));
    }
    if (step == 0 && steps_.repeated++ == 0) steps_.first_repeated = row;
  }

  [[noreturn]] void fail_at_row(std::size_t row, const std::string& what) const {
    text::fail_at(
        column_.source, column_.line_of_row(row), 1,
        fmt::format(
            "the time {} {}, expected rising time; cut the log here (allan --segments GAP does), or put its rows in order",
            column_.name, what));
  }

  void check_repeated() {
    const double share = static_cast<double>(steps_.repeated) / static_cast<double>(steps_.stamps - 1);
    if (share <= kMostRepeated) return;
    text::fail_at(
        column_.source, column_.line_of_row(steps_.first_repeated), 1,
        fmt::format(
            "the time {} repeats the stamp of the row before it, as {} of {} rows do, expected rising time; write the time with more digits, or remove the column and give --rate HZ (coarse stamps stay, and the rows between are counted through)",
            column_.name, steps_.repeated, steps_.stamps));
  }

  void find_median() {
    constexpr std::size_t kEnough = 1 << 16;  // steps, evenly spread; the median needs no more
    const std::size_t stride = stamps_.size() / kEnough + 1;
    std::vector<std::int64_t> some;
    std::size_t count = 0;
    walk([&](std::size_t, std::int64_t step) {
      if (step > 0 && count++ % stride == 0) some.push_back(step);
    });
    const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
    std::nth_element(some.begin(), middle, some.end());
    steps_.median = static_cast<double>(*middle);
  }

  void find_means() {
    std::int64_t sum = 0, count = 0;
    double total = 0;
    const auto least = static_cast<std::int64_t>(std::ceil(0.5 * steps_.median));
    const auto most = static_cast<std::int64_t>(1.5 * steps_.median);
    walk([&](std::size_t, std::int64_t step) {
      const bool regular = step >= least && step <= most;
      sum += regular ? step : 0;
      count += regular ? 1 : 0;
      total += static_cast<double>(step);
    });
    steps_.regular_mean = static_cast<double>(sum) / static_cast<double>(count);
    steps_.mean = total / static_cast<double>(steps_.stamps - 1 - steps_.repeated);
  }

  const std::vector<std::int64_t>& stamps_;
  const TimeColumn& column_;
  Steps steps_;
};

// --- Following the stamps --------------------------------------------------------------------------------------------

/// Unevenness of the stamps, from how the steps between them differ from whole intervals.
struct Jitter {
  double squares = 0, largest = 0, steps = 0;

  void add(double difference) {
    squares += difference * difference;
    largest = std::max(largest, std::abs(difference));
    steps += 1;
  }
  void add(const Jitter& other) {
    squares += other.squares;
    largest = std::max(largest, other.largest);
    steps += other.steps;
  }
  /// Of a stamp: a step has two of them.
  [[nodiscard]] double rms() const { return steps > 0 ? std::sqrt(squares / steps / 2) : 0; }
};

struct Track {
  std::int64_t points = 0;
  double interval = 0;  ///< least squares [ns]
  Jitter jitter;
  std::int64_t gaps = 0;
  std::int64_t longest_gap = 0;  ///< [points]
  std::size_t row_behind_longest = 0;
};

/// Assigns grid points in the order of the rows. `place(row, point, repeated)` is told each of them.
/// `gain` is the share of the offset that the tracker takes over with each stamp.
template <class Place>
Track follow(const std::vector<std::int64_t>& stamps, double interval, double gain, Place place) {
  constexpr int kAhead = 8;               // stamps that must be late too before a late one is a gap
  constexpr double kLargestGap = 0x1p52;  // keeps grid points exact in double
  const auto first_row = static_cast<std::size_t>(
      std::ranges::find_if(stamps, [](auto t) { return t != text::kNoStamp; }) - stamps.begin());
  const std::int64_t origin = stamps[first_row];
  const auto since = [&](std::size_t row) { return static_cast<double>(stamps[row] - origin); };

  Track track;
  std::int64_t point = -1;
  double expected = 0;  // time of the next grid point
  double sum_k = 0, sum_r = 0, sum_kk = 0, sum_kr = 0, count = 0;
  double time_before = 0;
  std::optional<std::int64_t> before;

  // Grid points that were skipped before this row.
  const auto skipped = [&](std::size_t row) {
    double least = std::rint((since(row) - expected) / interval);
    std::size_t ahead = row;
    for (int n = 1; n <= kAhead && least >= 1 && ++ahead < stamps.size(); ++n) {
      if (stamps[ahead] == text::kNoStamp || stamps[ahead] == stamps[ahead - 1]) continue;
      least = std::min(least, std::rint((since(ahead) - expected) / interval - n));
    }
    return static_cast<std::int64_t>(std::clamp(least, 0.0, kLargestGap));
  };

  for (std::size_t row = first_row; row < stamps.size(); ++row) {
    if (stamps[row] == text::kNoStamp) continue;
    if (before == stamps[row]) {
      place(row, point, true);
      continue;
    }
    before = stamps[row];
    const std::int64_t gap = skipped(row);
    if (gap > track.longest_gap) {
      track.longest_gap = gap;
      track.row_behind_longest = row;
    }
    track.gaps += gap > 0 ? 1 : 0;
    point += gap + 1;
    place(row, point, false);

    const double time = since(row);
    const double tracked = expected + static_cast<double>(gap) * interval;
    expected = tracked + gain * (time - tracked) + interval;
    if (point > 0 && gap == 0) track.jitter.add((time - time_before) / interval - 1);
    time_before = time;

    const auto k = static_cast<double>(point);
    const double residual = time - k * interval;
    count += 1;
    sum_k += k;
    sum_r += residual;
    sum_kk += k * k;
    sum_kr += k * residual;
  }
  track.points = point + 1;
  track.interval = interval + (sum_kr - sum_k * sum_r / count) / (sum_kk - sum_k * sum_k / count);
  return track;
}

/// follow() where no stamp is missing and no step is far from the others: row k is point k, and the sums run on all
/// cores in fixed blocks. Empty where the stamps are another case.
std::optional<Track> follow_even(const std::vector<std::int64_t>& stamps) {
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  const std::size_t blocks = (stamps.size() + kBlock - 1) / kBlock;
  const auto for_blocks = [&](auto visit) {
    tbb::parallel_for(std::size_t{0}, blocks,
                      [&](std::size_t b) { visit(b, b * kBlock, std::min((b + 1) * kBlock, stamps.size())); });
  };

  std::vector<std::pair<std::int64_t, std::int64_t>> extremes(blocks);
  for_blocks([&](std::size_t b, std::size_t begin, std::size_t end) {
    auto& [least, most] = extremes[b] = {std::numeric_limits<std::int64_t>::max(), 0};
    for (std::size_t row = std::max<std::size_t>(begin, 1); row < end; ++row) {
      std::int64_t step = 0;
      const bool overflow = __builtin_sub_overflow(stamps[row], stamps[row - 1], &step);
      least = overflow ? 0 : std::min(least, step);
      most = std::max(most, step);
    }
  });
  std::int64_t least = std::numeric_limits<std::int64_t>::max(), most = 0;
  for (const auto& [l, m] : extremes) {
    least = std::min(least, l);
    most = std::max(most, m);
  }
  const bool missing =
      stamps.front() == text::kNoStamp || stamps.back() == text::kNoStamp;  // others make a step below zero
  std::int64_t span = 0;
  if (missing || least <= 0 || __builtin_sub_overflow(stamps.back(), stamps.front(), &span) || span > kCentury) {
    return std::nullopt;
  }
  const auto n = static_cast<double>(stamps.size());
  const double interval = static_cast<double>(span) / (n - 1);
  if (static_cast<double>(least) < 0.5 * interval || static_cast<double>(most) > 1.5 * interval) return std::nullopt;

  struct Sums {
    double r = 0, kr = 0;
    Jitter jitter;
  };
  std::vector<Sums> sums(blocks);
  for_blocks([&](std::size_t b, std::size_t begin, std::size_t end) {
    Sums& s = sums[b];
    for (std::size_t row = begin; row < end; ++row) {
      const auto k = static_cast<double>(row);
      const double residual = static_cast<double>(stamps[row] - stamps.front()) - k * interval;
      s.r += residual;
      s.kr += k * residual;
      if (row > 0) s.jitter.add(static_cast<double>(stamps[row] - stamps[row - 1]) / interval - 1);
    }
  });
  Track track;
  double sum_r = 0, sum_kr = 0;
  for (const Sums& s : sums) {
    sum_r += s.r;
    sum_kr += s.kr;
    track.jitter.add(s.jitter);
  }
  track.points = static_cast<std::int64_t>(stamps.size());
  track.interval = interval + (sum_kr - sum_r * (n - 1) / 2) / (n * (n * n - 1) / 12);
  return track;
}

// --- The rate --------------------------------------------------------------------------------------------------------

bool agrees(double interval_ns, double rate_hz) { return std::abs(hertz(interval_ns) / rate_hz - 1) <= kRateTolerance; }

[[noreturn]] void fail_contradiction(const TimeColumn& column, double interval_ns, double rate_hz) {
  text::fail(
      column.source,
      fmt::format(
          "the time {} says {:.6g} Hz, but --rate says {:.6g} Hz, more than {:g} % apart; leave --rate out, or correct it or the unit of time",
          column.name, hertz(interval_ns), rate_hz, 100 * kRateTolerance));
}

/// The interval to start from. A given rate decides what coarse or bursting stamps leave open.
double first_interval(const Steps& steps, std::optional<double> rate_hz, const TimeColumn& column) {
  if (!rate_hz || agrees(steps.regular_mean, *rate_hz)) return steps.regular_mean;
  if (agrees(steps.mean, *rate_hz)) return 1 / (*rate_hz * kNanosecond);
  fail_contradiction(column, steps.regular_mean, *rate_hz);
}

/// Stamps of a loop whose turns last unevenly wander off the grid by more than an interval, and a slow tracker would
/// take that for gaps again and again: its rate comes out above that of the steps. Then each step is looked at alone.
double gain_for(const std::vector<std::int64_t>& stamps, const Steps& steps, double start) {
  constexpr double kSlow = 0.05, kAtOnce = 1, kFar = 0.003;
  const auto ignore = [](std::size_t, std::int64_t, bool) {};
  const auto off = [&](const Track& track) { return std::abs(track.interval / steps.regular_mean - 1); };
  const Track slow = follow(stamps, start, kSlow, ignore);
  if (slow.gaps == 0 || off(slow) < kFar) return kSlow;
  const Track at_once = follow(stamps, start, kAtOnce, ignore);
  return at_once.gaps < slow.gaps && off(at_once) < off(slow) ? kAtOnce : kSlow;
}

void check_density(const Track& track, std::size_t rows, const std::vector<std::int64_t>& stamps,
                   const TimeColumn& column) {
  const double missing = static_cast<double>(track.points) - static_cast<double>(rows);
  if (missing <= kMostMissing * static_cast<double>(track.points)) return;
  const std::size_t row = track.row_behind_longest;
  text::fail_at(
      column.source, column.line_of_row(row), 1,
      fmt::format(
          "{:.0f} of {} samples are missing, the most ({}) before the stamp of this row, expected at most half; cut the log here (allan --segments GAP does){}",
          missing, track.points, track.longest_gap,
          track.gaps > static_cast<std::int64_t>(stamps.size()) / 4 ? ", or give --rate if the stamps are coarse"
                                                                    : ""));
}

void check_jitter(const Track& track, const TimeColumn& column) {
  if (track.jitter.rms() <= kLargestJitter) return;
  text::fail(
      column.source,
      fmt::format(
          "the time {} is uneven by {:.0f} % (rms) of the sample interval, expected at most {:g} %; if the samples themselves are even, take the time column away and give --rate HZ; if not, average them over even intervals: --resample HZ",
          column.name, 100 * track.jitter.rms(), 100 * kLargestJitter));
}

std::string plural(std::int64_t n, std::string_view one) { return fmt::format("{} {}{}", n, one, n == 1 ? "" : "s"); }

/// What is missing, doubled or without a stamp.
void note_rows(const Track& track, const Steps& steps, const TimeColumn& column, std::vector<std::string>& notes);

std::vector<std::string> notes_on(const Track& track, const Steps& steps, double rate, std::optional<double> given,
                                  const TimeColumn& column) {
  std::vector<std::string> notes;
  const double measured = hertz(track.interval);
  notes.push_back(fmt::format("rate {:.6g} Hz from the time {}", rate, column.name));
  if (given && rate != *given)
    notes.back() +=
        fmt::format(", not {:.6g} Hz: they differ by {:.2g} %", *given, 100 * std::abs(measured / *given - 1));
  constexpr double kWorthSaying = 0.01;
  if (track.jitter.largest > kWorthSaying) {
    notes.push_back(fmt::format(
        "the stamps jitter by {:.2g} % (rms), at most {:.2g} %, of the sample interval; the samples are taken as even",
        100 * track.jitter.rms(), 100 * track.jitter.largest));
  }
  note_rows(track, steps, column, notes);
  return notes;
}

void note_rows(const Track& track, const Steps& steps, const TimeColumn& column, std::vector<std::string>& notes) {
  const std::int64_t missing = track.points - static_cast<std::int64_t>(steps.stamps - steps.repeated);
  if (track.gaps > 0) {
    notes.push_back(fmt::format("{} in time: {} missing, at most {} in a row (before line {})",
                                plural(track.gaps, "gap"), plural(missing, "sample"), track.longest_gap,
                                column.line_of_row(track.row_behind_longest)));
  }
  if (steps.repeated > 0) {
    notes.push_back(fmt::format("{} (the first in line {}): the samples that share a stamp are masked",
                                plural(static_cast<std::int64_t>(steps.repeated), "repeated time stamp"),
                                column.line_of_row(steps.first_repeated)));
  }
  if (steps.missing > 0) {
    notes.push_back(
        fmt::format("{} without a time stamp left out", plural(static_cast<std::int64_t>(steps.missing), "row")));
  }
}

Grid described(const Track& track, const Steps& steps, std::optional<double> rate_hz, const TimeColumn& column) {
  const double measured = hertz(track.interval);
  const double rate = rate_hz && std::abs(measured / *rate_hz - 1) <= kSameRate ? *rate_hz : measured;
  return {rate, track.points, {}, notes_on(track, steps, rate, rate_hz, column)};
}

}  // namespace

Grid make_grid(const std::vector<std::int64_t>& stamps, std::optional<double> rate_hz, const TimeColumn& column) {
  if (const auto even = follow_even(stamps); even && (!rate_hz || agrees(even->interval, *rate_hz))) {
    check_jitter(*even, column);
    return described(*even, {.stamps = stamps.size()}, rate_hz, column);
  }
  const Steps steps = Scan(stamps, column).run();
  const std::size_t rows = steps.stamps - steps.repeated;
  const double start = first_interval(steps, rate_hz, column);
  const bool rate_decides = rate_hz && !agrees(steps.regular_mean, *rate_hz);

  const auto ignore = [](std::size_t, std::int64_t, bool) {};
  const double gain = gain_for(stamps, steps, start);
  const Track rough = follow(stamps, start, gain, ignore);
  check_density(rough, rows, stamps, column);
  if (!rate_decides) check_jitter(rough, column);

  std::vector<std::int64_t> places(stamps.size(), text::kNoStamp);
  const Track track = follow(stamps, rough.interval, gain, [&](std::size_t row, std::int64_t point, bool repeated) {
    places[row] = repeated ? ~point : point;
  });
  check_density(track, rows, stamps, column);
  if (rate_hz && !agrees(track.interval, *rate_hz)) fail_contradiction(column, track.interval, *rate_hz);
  Grid grid = described(track, steps, rate_hz, column);
  if (grid.points != static_cast<std::int64_t>(rows) || rows != stamps.size()) grid.places = std::move(places);
  return grid;
}

CountedGrid make_counted_grid(const std::vector<std::int64_t>& stamps, std::int64_t interval_ns, double rate_hz,
                              const TimeColumn& column) {
  Steps steps;
  Track track;
  std::vector<std::int64_t> places(stamps.size(), text::kNoStamp);
  std::optional<std::int64_t> first, before;
  const auto fault = [&](std::size_t row, const char* what) {
    return CountedGrid{{}, fmt::format("{} {}", column.name, what), row};
  };
  for (std::size_t row = 0; row < stamps.size(); ++row) {
    if (stamps[row] == text::kNoStamp) {
      ++steps.missing;
      continue;
    }
    if (!first) first = stamps[row];
    std::int64_t since = 0;
    if (__builtin_sub_overflow(stamps[row], *first, &since)) return fault(row, "jumps");
    const std::int64_t point = (since + (since > 0 ? 1 : -1) * interval_ns / 2) / interval_ns;
    if (before && point < *before) return fault(row, "goes back");
    const bool repeats = before && point == *before;
    if (repeats && steps.repeated++ == 0) steps.first_repeated = row;
    const std::int64_t lost = before && !repeats ? point - *before - 1 : 0;
    if (lost > track.longest_gap) track.longest_gap = lost, track.row_behind_longest = row;
    track.gaps += lost > 0 ? 1 : 0;
    places[row] = repeats ? ~point : point;
    before = point;
  }
  steps.stamps = stamps.size() - steps.missing;
  if (steps.stamps < 2) return fault(0, "holds fewer than two counts");
  track.points = *before + 1;
  const auto rows = static_cast<std::int64_t>(steps.stamps - steps.repeated);
  if (static_cast<double>(steps.repeated) > kMostRepeated * static_cast<double>(steps.stamps))
    return fault(steps.first_repeated, "repeats");
  if (static_cast<double>(track.points - rows) > kMostMissing * static_cast<double>(track.points))
    return fault(track.row_behind_longest, "leaves out more counts than it has");
  Grid grid{rate_hz, track.points, {}, {}};
  grid.notes.push_back(fmt::format("{} counts the samples, at --rate {:g} Hz", column.name, rate_hz));
  note_rows(track, steps, column, grid.notes);
  if (grid.points != rows || static_cast<std::size_t>(rows) != stamps.size()) grid.places = std::move(places);
  return {std::move(grid), {}, 0};
}

void put_on_grid(const Grid& grid, std::vector<double>& values) {
  if (grid.places.empty()) return;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> placed(static_cast<std::size_t>(grid.points), kNone);
  for (std::size_t row = 0; row < values.size(); ++row) {
    const std::int64_t place = grid.places[row];
    if (place == text::kNoStamp) continue;
    placed[static_cast<std::size_t>(place < 0 ? ~place : place)] = place < 0 ? kNone : values[row];
  }
  values = std::move(placed);
}

}  // namespace gyrobudget::inline v0::log
