// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/series.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/report/result.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// An axis of a log as it goes into curve and fit: what is in it beside noise is found, and masked where that is asked
/// for. Refers to the axis, which must outlive it.
class Prepared {
 public:
  Prepared(const allan::Axis&, double dt, const CalibrateArguments&);

  [[nodiscard]] const allan::Series& record() const { return *record_; }
  [[nodiscard]] const report::Findings& findings() const { return findings_; }

  /// Looks for a warm-up, a trend or a step beside the noise that was fitted.
  /// @return whether a part of the record was masked for it, and curve and fit are to be made again.
  [[nodiscard]] bool look_for_departure(std::span<const noise::Process> fitted);
  /// Lines that the fit does not hold.
  void look_for_lines(const fit::Result&);

 private:
  void look_for_outliers_and_steps();
  void keep(std::int64_t first, std::int64_t count);
  void keep_longest_without_step();
  [[nodiscard]] std::span<const double> part_of(std::span<const double> whole) const;
  [[nodiscard]] std::span<const double> without_outliers() const;

  const allan::Axis& axis_;
  Masking masking_;
  double dt_, fill_;
  std::vector<double> masked_;  // the rates without outliers, where there are any
  std::optional<allan::Series> record_;
  report::Findings findings_;
};

/// In plain words, each with its times and what can be done.
[[nodiscard]] std::vector<std::string> describe(const report::Findings&, const allan::Axis&, double dt);

}  // namespace gyrobudget::inline v0::cli
