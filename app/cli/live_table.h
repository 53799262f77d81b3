// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/result.h"

#include <chrono>
#include <cstdint>
#include <functional>

namespace gyrobudget::inline v0::cli {

/// Prints the table of a log that grows: once a second in place of the last one on a terminal, else at each doubling.
class LiveTable {
 public:
  LiveTable();
  /// Prints where it is time to. @param result is asked for only then.
  void update(std::int64_t samples, const std::function<report::LogResult()>& result);
  /// The table of the whole, unless it is the last that was shown.
  void finish(std::int64_t samples, const report::LogResult&);

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool due(std::int64_t samples);

  bool terminal_;
  Clock::time_point last_;
  std::int64_t shown_ = 0;
  std::int64_t next_ = 1024;
};

}  // namespace gyrobudget::inline v0::cli
