// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::fit {

/// Neighbouring samples of a record.
struct Stretch {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// The sine coefficients of the longest stretch of a record, its variation brought to about 1 by a power of two.
struct Transformed {
  Stretch used;
  double dt = 1;
  double unit = 1;  ///< signal = transformed signal * unit
  std::vector<double> rate;
  std::vector<double> coefficients;  ///< empty where the record has no answer
};

/// Fewer than 16 samples in a row, or samples all equal, give no coefficients.
[[nodiscard]] Transformed transform_record(std::span<const double> rate, double dt);

}  // namespace gyrobudget::inline v0::fit
