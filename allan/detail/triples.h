// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/form.h"
#include "gyrobudget/allan/mask.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <vector>

namespace gyrobudget::inline v0::allan::detail {

/// A set of whole numbers as ascending ranges that do not touch.
class Ranges {
 public:
  struct Range {
    std::int64_t first;
    std::int64_t end;
    std::int64_t before;  ///< how many numbers the earlier ranges hold
  };
  /// Adds [first, end) behind what is there.
  void append(std::int64_t first, std::int64_t end);
  [[nodiscard]] std::int64_t size() const { return size_; }
  [[nodiscard]] const std::vector<Range>& ranges() const { return ranges_; }
  /// The number that has `rank` smaller ones in the set.
  [[nodiscard]] std::int64_t at(std::int64_t rank) const;
  /// The set itself, or where it has more than `most` ranges, that many in stretches spread evenly over it.
  [[nodiscard]] Ranges sample(std::size_t most) const;

 private:
  std::vector<Range> ranges_;
  std::int64_t size_ = 0;
};

/// How many k are in a with k + h in b.
[[nodiscard]] std::int64_t count_pairs(const Ranges& a, const Ranges& b, std::int64_t h);

/// The triples of a record with gaps that count at one averaging factor, by their first sample.
struct Triples {
  std::int64_t m = 1;
  Ranges valid;
  Ranges touched;          ///< those of `valid` that miss a sample
  double white_ratio = 1;  ///< mean of (1/c1 + 1/c2) m/2 over `valid`, c the samples that exist in the clusters
};
/// One sweep over the edges of the gaps: O(gaps + missing samples), whatever the length of the record.
[[nodiscard]] Triples find_triples(const Mask&, std::int64_t m, Form);

/// Expectation of the masked estimate for a process: the Allan variance where no cluster misses a sample. See
/// Mask::expectation_ratio for the method and its error. NaN where no triple counts.
[[nodiscard]] double masked_variance(const Mask&, const Triples&, const noise::Process&, double dt);

}  // namespace gyrobudget::inline v0::allan::detail
