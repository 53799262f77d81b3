// SPDX-License-Identifier: MIT
#include "gyrobudget/io/grid.h"

#include "gyrobudget/io/number.h"
#include "gyrobudget/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrobudget::inline v0::io {
namespace {

constexpr double kNanosecond = 1e-9;
constexpr double kSameRate = 1e-6;  // rates this near are one rate, written with other digits

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
  Scan(const std::vector<std::int64_t>& stamps, const TimeColumn& column)
      : stamps_(stamps), column_(column) {}

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
    steps_.missing = static_cast<std::size_t>(std::ranges::count(stamps_, kNoStamp));
    steps_.stamps = stamps_.size() - steps_.missing;
    if (steps_.stamps >= 2) return;
    fail(column_.source,
         fmt::format("the time {} holds fewer than two stamps; correct it, or remove it and give --rate HZ",
                     column_.name));
  }

  /// Calls see(row, step) for each stamp but the first.
  template <class See>
  void walk(See see) {
    constexpr std::int64_t kCentury = 3'155'760'000'000'000'000;
    std::optional<std::int64_t> first;
    std::int64_t before =
        0;  // since the first, as all that follows: within a century, so that nothing overflows
    for (std::size_t row = 0; row < stamps_.size(); ++row) {
      if (stamps_[row] == kNoStamp) continue;
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
    fail_at(column_.source, column_.line_of_row(row), 1,
            fmt::format("the time {} {}, expected rising time; cut the log here, or put its rows in order",
                        column_.name, what));
  }

  void check_repeated() {
    const double share = static_cast<double>(steps_.repeated) / static_cast<double>(steps_.stamps - 1);
    if (share <= kMostRepeated) return;
    fail_at(
        column_.source, column_.line_of_row(steps_.first_repeated), 1,
        fmt::format(
            "the time {} repeats the stamp of the row before it, as {} of {} rows do, expected rising time; "
            "write the time with more digits, or remove the column and give --rate HZ",
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

struct Track {
  std::int64_t points = 0;
  double interval = 0;    ///< least squares [ns]
  double jitter_rms = 0;  ///< of stamps about the tracked time, in intervals
  double jitter_max = 0;
  std::int64_t gaps = 0;
  std::int64_t longest_gap = 0;  ///< [points]
  std::size_t row_behind_longest = 0;
};

/// Assigns grid points in the order of the rows. `place(row, point, repeated)` is told each of them.
template <class Place>
Track follow(const std::vector<std::int64_t>& stamps, double interval, Place place) {
  constexpr double kGain = 0.05;          // share of the offset that the tracker takes over with each stamp
  constexpr int kAhead = 8;               // stamps that must be late too before a late one is a gap
  constexpr double kLargestGap = 0x1p52;  // keeps grid points exact in double
  const auto first_row = static_cast<std::size_t>(
      std::ranges::find_if(stamps, [](auto t) { return t != kNoStamp; }) - stamps.begin());
  const std::int64_t origin = stamps[first_row];
  const auto since = [&](std::size_t row) { return static_cast<double>(stamps[row] - origin); };

  Track track;
  std::int64_t point = -1;
  double expected = 0;  // time of the next grid point
  double sum_k = 0, sum_r = 0, sum_kk = 0, sum_kr = 0, sum_jitter = 0, count = 0;
  std::optional<std::int64_t> before;

  // Grid points that were skipped before this row.
  const auto skipped = [&](std::size_t row) {
    double least = std::rint((since(row) - expected) / interval);
    std::size_t ahead = row;
    for (int n = 1; n <= kAhead && least >= 1 && ++ahead < stamps.size(); ++n) {
      if (stamps[ahead] == kNoStamp || stamps[ahead] == stamps[ahead - 1]) continue;
      least = std::min(least, std::rint((since(ahead) - expected) / interval - n));
    }
    return static_cast<std::int64_t>(std::clamp(least, 0.0, kLargestGap));
  };

  for (std::size_t row = first_row; row < stamps.size(); ++row) {
    if (stamps[row] == kNoStamp) continue;
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
    const double jitter = (time - tracked) / interval;
    sum_jitter += jitter * jitter;
    track.jitter_max = std::max(track.jitter_max, std::abs(jitter));
    expected = tracked + kGain * (time - tracked) + interval;

    const auto k = static_cast<double>(point);
    const double residual = time - k * interval;
    count += 1;
    sum_k += k;
    sum_r += residual;
    sum_kk += k * k;
    sum_kr += k * residual;
  }
  track.points = point + 1;
  track.jitter_rms = std::sqrt(sum_jitter / count);
  track.interval = interval + (sum_kr - sum_k * sum_r / count) / (sum_kk - sum_k * sum_k / count);
  return track;
}

// --- The rate --------------------------------------------------------------------------------------------------------

bool agrees(double interval_ns, double rate_hz) {
  return std::abs(hertz(interval_ns) / rate_hz - 1) <= kRateTolerance;
}

[[noreturn]] void fail_contradiction(const TimeColumn& column, double interval_ns, double rate_hz) {
  fail(column.source, fmt::format("the time {} says {:.6g} Hz, but --rate says {:.6g} Hz, more than {:g} % "
                                  "apart; leave --rate out, or "
                                  "correct it or the unit of time",
                                  column.name, hertz(interval_ns), rate_hz, 100 * kRateTolerance));
}

/// The interval to start from. A given rate decides what coarse or bursting stamps leave open.
double first_interval(const Steps& steps, std::optional<double> rate_hz, const TimeColumn& column) {
  if (!rate_hz || agrees(steps.regular_mean, *rate_hz)) return steps.regular_mean;
  if (agrees(steps.mean, *rate_hz)) return 1 / (*rate_hz * kNanosecond);
  fail_contradiction(column, steps.regular_mean, *rate_hz);
}

void check_density(const Track& track, std::size_t rows, const std::vector<std::int64_t>& stamps,
                   const TimeColumn& column) {
  const double missing = static_cast<double>(track.points) - static_cast<double>(rows);
  if (missing <= kMostMissing * static_cast<double>(track.points)) return;
  const std::size_t row = track.row_behind_longest;
  fail_at(
      column.source, column.line_of_row(row), 1,
      fmt::format(
          "{:.0f} of {} samples are missing, the most ({}) before the stamp of this row, expected at most "
          "half; cut the log here{}",
          missing, track.points, track.longest_gap,
          track.gaps > static_cast<std::int64_t>(stamps.size()) / 4
              ? ", or give --rate if the stamps are coarse"
              : ""));
}

void check_jitter(const Track& track, const TimeColumn& column) {
  if (track.jitter_rms <= kLargestJitter) return;
  fail(column.source,
       fmt::format("the time {} is uneven by {:.0f} % (rms) of the sample interval, expected at most "
                   "{:g} %; if the samples themselves are even, give their rate: --rate HZ",
                   column.name, 100 * track.jitter_rms, 100 * kLargestJitter));
}

std::string plural(std::int64_t n, std::string_view one) {
  return fmt::format("{} {}{}", n, one, n == 1 ? "" : "s");
}

std::vector<std::string> notes_on(const Track& track, const Steps& steps, double rate,
                                  std::optional<double> given, const TimeColumn& column) {
  std::vector<std::string> notes;
  const double measured = hertz(track.interval);
  notes.push_back(fmt::format("rate {:.6g} Hz from the time {}", rate, column.name));
  if (given && rate != *given)
    notes.back() += fmt::format(", not {:.6g} Hz: they differ by {:.2g} %", *given,
                                100 * std::abs(measured / *given - 1));
  constexpr double kWorthSaying = 0.01;
  if (track.jitter_max > kWorthSaying) {
    notes.push_back(
        fmt::format("the stamps jitter by {:.2g} % (rms), at most {:.2g} %, of the sample interval; the "
                    "samples are taken as even",
                    100 * track.jitter_rms, 100 * track.jitter_max));
  }
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
    notes.push_back(fmt::format("{} without a time stamp left out",
                                plural(static_cast<std::int64_t>(steps.missing), "row")));
  }
  return notes;
}

}  // namespace

Grid make_grid(std::vector<std::int64_t> stamps, std::optional<double> rate_hz, const TimeColumn& column) {
  const Steps steps = Scan(stamps, column).run();
  const std::size_t rows = steps.stamps - steps.repeated;
  const double start = first_interval(steps, rate_hz, column);
  const bool rate_decides = rate_hz && !agrees(steps.regular_mean, *rate_hz);

  const auto ignore = [](std::size_t, std::int64_t, bool) {};
  const Track rough = follow(stamps, start, ignore);
  check_density(rough, rows, stamps, column);
  if (!rate_decides) check_jitter(rough, column);

  Grid grid;
  grid.places.assign(stamps.size(), kNoStamp);
  const Track track = follow(stamps, rough.interval, [&](std::size_t row, std::int64_t point, bool repeated) {
    grid.places[row] = repeated ? ~point : point;
  });
  check_density(track, rows, stamps, column);
  if (rate_hz && !agrees(track.interval, *rate_hz)) fail_contradiction(column, track.interval, *rate_hz);

  const double measured = hertz(track.interval);
  grid.rate_hz = rate_hz && std::abs(measured / *rate_hz - 1) <= kSameRate ? *rate_hz : measured;
  grid.points = track.points;
  grid.notes = notes_on(track, steps, grid.rate_hz, rate_hz, column);
  if (grid.points == static_cast<std::int64_t>(stamps.size()) && rows == stamps.size()) grid.places = {};
  return grid;
}

void put_on_grid(const Grid& grid, std::vector<double>& values) {
  if (grid.places.empty()) return;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> placed(static_cast<std::size_t>(grid.points), kNone);
  for (std::size_t row = 0; row < values.size(); ++row) {
    const std::int64_t place = grid.places[row];
    if (place == kNoStamp) continue;
    placed[static_cast<std::size_t>(place < 0 ? ~place : place)] = place < 0 ? kNone : values[row];
  }
  values = std::move(placed);
}

}  // namespace gyrobudget::inline v0::io
