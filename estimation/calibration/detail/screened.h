// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/series.h"
#include "gyrobudget/estimation/calibration/findings.h"
#include "gyrobudget/estimation/fit/fit.h"

#include <optional>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::calibration::detail {

/// An axis as it goes into curve and fit: what is in it beside noise is found, and left out where that is asked for.
/// Refers to the samples, which must outlive it.
class Screened {
 public:
  /// All of the samples, with nothing found yet.
  Screened(std::span<const double> rate, double dt, double minimum_fill, const Masking& masking);

  [[nodiscard]] const allan::Series& series() const { return *series_; }
  /// Indices count the samples that were given.
  [[nodiscard]] const Findings& findings() const { return findings_; }

  /// Looks for rounding, saturation, rows of several sensors, knocks, motion and steps of the mean, and masks the last
  /// three where that is asked for.
  void look();
  /// Looks for a warm-up, a trend or a step beside the noise that was fitted.
  /// @return whether a part of the record was masked for it, and curve and fit are to be made again.
  [[nodiscard]] bool look_for_departure(std::span<const noise::Process> fitted);
  /// Lines that the fit does not hold.
  void look_for_lines(const fit::Result& fit);

 private:
  void look_at_values();
  void look_for_outliers();
  void look_for_turns_and_motion();
  void look_for_steps();
  void keep(std::int64_t first, std::int64_t count);
  void keep_longest_without_step();
  [[nodiscard]] std::span<const double> part_of(std::span<const double> whole) const;
  [[nodiscard]] std::span<const double> clean() const;
  [[nodiscard]] std::span<const double> used() const;
  [[nodiscard]] bool holds_knocks_or_motion() const;

  std::span<const double> rate_;
  Masking masking_;
  double dt_, fill_;
  std::vector<double> clean_;   // the rates without outliers and motion, where there are any
  std::vector<double> masked_;  // without those that are to be left out, where there are any
  std::optional<allan::Series> series_;
  Findings findings_;
};

}  // namespace gyrobudget::inline v0::calibration::detail
