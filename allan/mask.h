// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// Which samples of a record are missing, and what that does to its Allan variance.
class Mask {
 public:
  struct Run { std::int64_t first; std::int64_t count; };  ///< of missing samples
  Mask(std::int64_t samples, std::vector<Run> missing, double minimum_fill);
  [[nodiscard]] std::int64_t samples() const;
  [[nodiscard]] std::int64_t missing() const;
  [[nodiscard]] double minimum_fill() const;
  [[nodiscard]] const std::vector<Run>& runs() const;

  /// E[masked estimate] / E[complete estimate] of a process at factor m.
  [[nodiscard]] double expectation_ratio(const noise::Process&, std::int64_t m, double dt) const;
};

}  // namespace gyrobudget::inline v0::allan
