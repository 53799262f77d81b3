// SPDX-License-Identifier: MIT
// Clocks that start again, count samples, or repeat their stamps, made to run on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "columns.h"

namespace gyrobudget::inline v0::log {

/// Makes a clock run on that starts again from nothing: at midnight, at the end of a week, where its bits are full.
class Unroller {
 public:
  /// @param wraps  where it may, ascending
  /// @param step   from stamp to stamp as a rule [ns]: across an unsure wrap it may be 16 times that at most, so that a
  ///   clock that was set back is none
  Unroller(std::vector<Wrap> wraps, double step) : wraps_(std::move(wraps)), step_(step) {}

  /// The stamp [ns], counted on. kNoStamp stays what it is.
  [[nodiscard]] std::int64_t operator()(std::int64_t stamp);
  [[nodiscard]] std::size_t times() const { return times_; }     ///< that it started again so far
  [[nodiscard]] std::int64_t period() const { return period_; }  ///< [ns] the last one

 private:
  [[nodiscard]] bool start_again(std::int64_t stamp);

  std::vector<Wrap> wraps_;
  double step_;
  std::int64_t offset_ = 0, before_ = 0, period_ = 0;
  bool started_ = false;
  std::size_t times_ = 0;
};

/// Unrolls all stamps of a clock that falls, in place. @return a note on it; empty where nothing was to be done
[[nodiscard]] std::optional<std::string> unroll(std::vector<std::int64_t>& stamps, const Choice& choice);

/// Stamps of which runs are equal, as whole seconds give them: each run is spread over the step to the next one, in
/// place, so that every row has a time of its own and gaps between the runs stay.
/// @param rate_hz  given: without it nobody knows that the rows are even
/// @return a note on it; empty where few stamps repeat, or the rate has not more than one sample between two stamps
[[nodiscard]] std::optional<std::string> count_through(std::vector<std::int64_t>& stamps, double rate_hz,
                                                       const std::string& time_name);

}  // namespace gyrobudget::inline v0::log
