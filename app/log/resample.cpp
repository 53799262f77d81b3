// SPDX-License-Identifier: MIT
#include "resample.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

using noise::kNanosecond;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kMostCells = 0x1p40;

[[noreturn]] void fail_sparse(const TimeColumn& column, double rate_hz, double share) {
  text::fail(
      column.source,
      fmt::format(
          "only {:.0f} % of the intervals of 1/({:g} Hz) can be filled from the time {}, expected at least {:.0f} %; give --resample a lower rate, or cut the log at its gaps with --segments",
          100 * share, rate_hz, column.name, 100 * (1 - kMostMissing)));
}

}  // namespace

Resampler::Resampler(std::vector<std::int64_t> stamps, double rate_hz, Input input, const TimeColumn& column)
    : stamps_(std::move(stamps)), rate_hz_(rate_hz), input_(input) {
  check(column);
  cells_ = static_cast<std::int64_t>(place(stamps_.size() - 1));
  if (input == Input::rate) {
    describe_means(column);
  } else {
    describe_spread(column);
  }
}

double Resampler::place(std::size_t row) const {
  return static_cast<double>(stamps_[row] - stamps_.front()) * kNanosecond * rate_hz_;
}

void Resampler::check(const TimeColumn& column) const {
  for (std::size_t row = 0; row < stamps_.size(); ++row) {
    if (stamps_[row] == text::kNoStamp) {
      text::fail_at(column.source, column.line_of_row(row), 1,
                    fmt::format("the time {} is missing, which --resample cannot place; remove the row", column.name));
    }
    std::int64_t since = 0;
    if (__builtin_sub_overflow(stamps_[row], stamps_.front(), &since)) {
      text::fail_at(column.source, column.line_of_row(row), 1,
                    fmt::format("the time {} is more than 292 years from its start; correct it", column.name));
    }
    if (row > 0 && stamps_[row] < stamps_[row - 1]) {
      text::fail_at(
          column.source, column.line_of_row(row), 1,
          fmt::format(
              "the time {} goes back, expected rising time; put the rows in order, or cut the log there with --segments",
              column.name));
    }
  }
  const double span = place(stamps_.size() - 1), readings = static_cast<double>(stamps_.size());
  if (span >= 1 && span <= kMostCells && readings > span) return;
  text::fail(
      column.source,
      fmt::format(
          "--resample {:g} Hz: the time {} holds {:.4g} readings a second over {:.6g} s, and resampling averages, it invents none; give a lower rate",
          rate_hz_, column.name, readings / span * rate_hz_, span / rate_hz_));
}

std::vector<double> Resampler::operator()(std::span<const double> values) const {
  return input_ == Input::rate ? cell_means(values) : spread(values);
}

std::vector<double> Resampler::cell_means(std::span<const double> rates) const {
  std::vector<double> sums(static_cast<std::size_t>(cells_), 0.), counts(sums);
  for (std::size_t row = 0; row < rates.size(); ++row) {
    const double at = place(row);
    if (at >= static_cast<double>(cells_) || !std::isfinite(rates[row])) continue;
    const auto cell = static_cast<std::size_t>(at);
    sums[cell] += rates[row];
    ++counts[cell];
  }
  for (std::size_t cell = 0; cell < sums.size(); ++cell)
    sums[cell] = counts[cell] > 0 ? sums[cell] / counts[cell] : kNone;
  return sums;
}

// Increments go to the cells that their step lies in; one that is too long to tell where takes its cells away.
std::vector<double> Resampler::spread(std::span<const double> values) const {
  std::vector<double> sums(static_cast<std::size_t>(cells_), 0.);
  const auto add = [&](double cell, double amount) {
    if (cell < static_cast<double>(cells_)) sums[static_cast<std::size_t>(cell)] += amount;
  };
  double from = 0, angle = values.front();
  for (std::size_t row = 1; row < values.size(); ++row) {
    const double to = place(row);
    if (input_ == Input::angle && !std::isfinite(values[row])) continue;  // the step goes on to the next one
    const double amount = input_ == Input::angle ? values[row] - angle : values[row];
    const double first = std::floor(from), last = std::floor(to);
    if (!(to - from <= 1) || !std::isfinite(amount)) {
      for (double cell = first; cell <= std::min(last, static_cast<double>(cells_ - 1)); ++cell) add(cell, kNone);
    } else if (first == last) {
      add(first, amount);
    } else {
      const double share = (last - from) / (to - from);
      add(first, share * amount);
      add(last, (1 - share) * amount);
    }
    from = to;
    angle = values[row];
  }
  for (double& sum : sums) sum *= rate_hz_;
  return sums;
}

void Resampler::describe_means(const TimeColumn& column) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(cells_));
  for (std::size_t row = 0; row < stamps_.size(); ++row) {
    if (const double at = place(row); at < static_cast<double>(cells_)) ++counts[static_cast<std::size_t>(at)];
  }
  double filled = 0, sum = 0, inverse = 0;
  std::int64_t most = 0;
  for (const std::int64_t count : counts) {
    if (count == 0) continue;
    ++filled;
    sum += static_cast<double>(count);
    inverse += 1 / static_cast<double>(count);
    most = std::max(most, count);
  }
  if (filled < (1 - kMostMissing) * static_cast<double>(cells_))
    fail_sparse(column, rate_hz_, filled / static_cast<double>(cells_));
  const double excess = std::sqrt(sum / filled * inverse / filled) - 1;
  note_ = fmt::format(
      "resampled to {:g} Hz as asked: a sample is the mean of the readings in {:g} s, {:.3g} on average and at most {}; white noise reads {:.2g} % high at every tau, as samples of few readings count like those of many",
      rate_hz_, 1 / rate_hz_, sum / filled, most, 100 * excess);
}

void Resampler::describe_spread(const TimeColumn& column) {
  double squares = 0, steps = 0, lost = 0;
  for (std::size_t row = 1; row < stamps_.size(); ++row) {
    const double step = place(row) - place(row - 1);
    if (step > 1) {
      lost += std::floor(place(row)) - std::floor(place(row - 1)) + 1;
      continue;
    }
    squares += step * step;
    steps += step;
  }
  if (!(lost <= kMostMissing * static_cast<double>(cells_)))
    fail_sparse(column, rate_hz_, std::max(0., 1 - lost / static_cast<double>(cells_)));
  const double low = squares / steps / 2;  // of the variance at one cell
  note_ = fmt::format(
      "resampled to {:g} Hz as asked: angles at the ends of {:g} s are interpolated between readings; white noise reads {:.2g} % low at {:g} s, {:.2g} % at {:g} s and less in proportion at longer tau",
      rate_hz_, 1 / rate_hz_, 100 * (1 - std::sqrt(1 - low)), 1 / rate_hz_, 100 * (1 - std::sqrt(1 - low / 4)),
      4 / rate_hz_);
}

}  // namespace gyrobudget::inline v0::log
