// SPDX-License-Identifier: MIT
// Several records of one sensor type (power-ups, units): each has its own datasheet, and together they tell what the
// type has, and what another unit will have. Records are never joined into one series.
#pragma once

#include "gyrobudget/estimation/fit/combine.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate.h"

namespace gyrobudget::inline v0::calibration {

/// An axis of a sensor type.
struct CombinedAxis {
  std::string name;
  noise::Signal signal = noise::Signal::angular_rate;
  std::vector<fit::Combined> coefficients;  ///< of Q, N, B, K and R; empty where no record is quotable
  std::vector<std::string> left_out;  ///< sources of the records not taken: not described, or rounded above their noise
  /// Where the records' fits begin at different averaging times: the latest, from which all were fitted once more to be
  /// compared [s].
  std::optional<double> common_start_s;
};

struct TypeDatasheet {
  std::vector<Datasheet> records;  ///< the same axes in the same order in each
  std::vector<CombinedAxis> axes;  ///< in that order

  /// Every axis has an answer in one record at least, and none of those that it has is spoilt.
  [[nodiscard]] bool is_complete() const;
};

/// Records may differ this much in their rates, relatively: quantization and filters depend on it.
inline constexpr double kRateTolerance = 0.01;

/// The record with its axes in the order of `first`, a datasheet of the same sensor type.
/// @throws Unusable where it has other axes, axes of other kinds, or another rate.
[[nodiscard]] allan::Record matched(allan::Record record, const Datasheet& first);

/// Combines the datasheets of records of one type, axis by axis, by fit::combine; Gauss-Markov processes and sinusoids
/// have times and frequencies of their own in each record and are not combined.
///
/// Like is compared with like: records whose fits begin at different averaging times are fitted once more from the
/// latest of these on. A filter takes more off N the earlier a fit begins, so that N of one sensor would differ between
/// its own records. Quantization, which the shortest times hold, is that of each record's own fit.
/// @param records  one at least, with the same axes in the same order
/// @throws std::invalid_argument for none, and for axes that are not the same in number.
[[nodiscard]] TypeDatasheet combine(std::vector<Datasheet> records);

/// Each record to its datasheet, then combined. Who has not all records in memory calls calibrate, matched and combine.
/// @throws as these do.
[[nodiscard]] TypeDatasheet calibrate(std::span<const allan::Record> records, const Options& options = {});

}  // namespace gyrobudget::inline v0::calibration
