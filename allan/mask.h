// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <vector>

#include "form.h"

namespace gyrobudget::inline v0::allan {

/// Which samples of a record are missing, and what that does to its Allan variance.
///
/// A cluster of m samples counts when at least minimum_count(m) of them exist; its mean is over those. A triple, that
/// is a pair of adjacent clusters, counts when both clusters do. Nothing is interpolated and nothing is moved in
/// time: a gap keeps its length.
class Mask {
 public:
  /// Neighbouring missing samples.
  struct Gap {
    std::int64_t first;
    std::int64_t count;
  };

  /// @param samples length of the record, missing ones included; below 2^32.
  /// @param missing ascending, apart from one another and inside the record.
  /// @param minimum_fill part of a cluster's samples that must exist for it to count, in (0, 1].
  /// @throws std::invalid_argument otherwise.
  Mask(std::int64_t samples, std::vector<Gap> missing, double minimum_fill);

  [[nodiscard]] std::int64_t samples() const { return samples_; }
  /// How many samples are missing.
  [[nodiscard]] std::int64_t missing() const { return missing_; }
  [[nodiscard]] double minimum_fill() const { return minimum_fill_; }
  [[nodiscard]] const std::vector<Gap>& runs() const { return runs_; }
  /// The fewest samples with which a cluster of m counts: minimum_fill m rounded up, at least 1.
  [[nodiscard]] std::int64_t minimum_count(std::int64_t m) const;

  /// E[masked estimate] / E[complete estimate] of a process at factor m; 1 where every cluster that counts is
  /// complete, NaN where none counts.
  ///
  /// White noise: exact, the mean of (1/c1 + 1/c2) m/2 over all triples that count, c the samples that exist in their
  /// clusters. Others: over at most 512 triples spread evenly among those that miss samples; of each the expectation
  /// is exact for quantization, ramp and sinusoid (averaged over its phase), and for flicker, random walk and
  /// Gauss-Markov from the structure function between 32 blocks a cluster. Error of the ratio for up to 5 % of samples
  /// lost, at random or in gaps: below 1e-3 + 5 % of its distance from 1 (tested against all triples, all samples).
  ///
  /// @throws std::invalid_argument for m outside 1 .. n/2 or an invalid dt [s] or process.
  [[nodiscard]] double expectation_ratio(const noise::Process& process, std::int64_t m, double dt,
                                         Form form = Form::full) const;

 private:
  std::int64_t samples_;
  std::int64_t missing_ = 0;
  double minimum_fill_;
  std::vector<Gap> runs_;
};

}  // namespace gyrobudget::inline v0::allan
