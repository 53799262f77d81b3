// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/form.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// Which samples of a record are missing, and what that does to its Allan variance.
///
/// A cluster of m samples counts when at least minimum_count(m) of them exist; its mean is over those. A triple, that
/// is a pair of adjacent clusters, counts when both clusters do. Nothing is interpolated and nothing is moved in
/// time: a gap keeps its length.
class Mask {
 public:
  /// Neighbouring missing samples.
  struct Run {
    std::int64_t first;
    std::int64_t count;
  };

  /// @param samples length of the record, missing ones included; below 2^32.
  /// @param missing ascending, apart from one another and inside the record.
  /// @param minimum_fill part of a cluster's samples that must exist for it to count, in (0, 1].
  /// @throws std::invalid_argument otherwise.
  Mask(std::int64_t samples, std::vector<Run> missing, double minimum_fill);

  [[nodiscard]] std::int64_t samples() const { return samples_; }
  /// How many samples are missing.
  [[nodiscard]] std::int64_t missing() const { return missing_; }
  [[nodiscard]] double minimum_fill() const { return minimum_fill_; }
  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  /// The fewest samples with which a cluster of m counts: minimum_fill m rounded up, at least 1.
  [[nodiscard]] std::int64_t minimum_count(std::int64_t m) const;

 private:
  std::int64_t samples_;
  std::int64_t missing_ = 0;
  double minimum_fill_;
  std::vector<Run> runs_;
};

}  // namespace gyrobudget::inline v0::allan
