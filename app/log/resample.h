// SPDX-License-Identifier: MIT
// Readings at uneven times onto even ones, where that is asked for.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "grid.h"
#include "log.h"

namespace gyrobudget::inline v0::log {

/// Averages readings over even cells [t0 + k T, t0 + (k+1) T), T = 1 / rate, from the first stamp to the last whole
/// cell. Nothing is invented: a cell that the readings do not reach is missing.
///
/// **Rates**: the mean of the readings of a cell. Cells count alike, whatever they hold: white noise reads high by the
/// same factor sqrt(mean count * mean 1/count) at every tau.
///
/// **Increments, angles**: an increment is spread evenly over the time since the stamp before, so the angle at the
/// ends of the cells is interpolated linearly; cells that touch a step longer than T are missing. Angles between cells
/// keep every digit at long tau; the variance of white noise reads low by the part r / (2 tau) with r = mean
/// step^2 / mean step (exact: the interpolated ends miss the bridge of a random walk).
class Resampler {
 public:
  /// @param stamps [ns], rising.
  /// @throws InputError for time that goes back, a rate above the mean rate of the stamps, or fewer than half of the
  /// cells that could be filled.
  Resampler(std::vector<std::int64_t> stamps, double rate_hz, Input, const TimeColumn&);

  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] std::int64_t cells() const { return cells_; }
  /// What was done and what it does to short taus.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Mean rates of the cells of one column; NaN where missing.
  /// @param values of each row: rates, increments, or angles without wraps.
  [[nodiscard]] std::vector<double> operator()(std::span<const double> values) const;

 private:
  [[nodiscard]] double place(std::size_t row) const;  ///< in cells
  [[nodiscard]] std::vector<double> cell_means(std::span<const double> rates) const;
  [[nodiscard]] std::vector<double> spread(std::span<const double> values) const;
  void check(const TimeColumn&) const;
  void describe_means(const TimeColumn&);
  void describe_spread(const TimeColumn&);

  std::vector<std::int64_t> stamps_;
  double rate_hz_;
  Input input_;
  std::int64_t cells_ = 0;
  std::string note_;
};

}  // namespace gyrobudget::inline v0::log
