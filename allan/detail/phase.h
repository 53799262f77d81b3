// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/mask.h"

#include <cstdint>
#include <memory>
#include <span>

namespace gyrobudget::inline v0::allan::detail {

/// A sum in two doubles (Neumaier 1974): its value is right to one rounding however long it runs.
class CompensatedSum {
 public:
  CompensatedSum() = default;
  void add(double term) {
    const double sum = sum_ + term;
    const double added = sum - sum_;
    lost_ += (sum_ - (sum - added)) + (term - added);
    sum_ = sum;
  }
  void add(const CompensatedSum& other) {
    add(other.sum_);
    lost_ += other.lost_;
  }
  [[nodiscard]] double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0;
  double lost_ = 0;
};

/// What one pass over a record finds.
struct Census {
  double mean = 0;                   ///< of the samples that exist; NaN where none does
  std::shared_ptr<const Mask> mask;  ///< null for a complete record
};
[[nodiscard]] Census census(std::span<const double> rate, double minimum_fill);

/// Prefix sums of a record, x[k] = sum of the first k samples less their mean each, and of its gaps. A missing sample
/// adds 0. Subtracting a constant changes no Allan variance, and where the mean dwarfs the noise the subtraction is
/// exact (Sterbenz), so the noise keeps all its digits.
struct Phase {
  std::unique_ptr<double[]> x;               ///< n + 1
  std::unique_ptr<std::uint32_t[]> missing;  ///< n + 1 counts modulo 2^32; null for a complete record
};
[[nodiscard]] Phase integrate(std::span<const double> rate, const Census&);

/// Prefix sums of a stretch of a record about a constant near the stretch's own mean: x[0] = 0 to x[rate.size()].
void integrate_stretch(std::span<const double> rate, bool has_gaps, double* x);
/// The number of missing samples before each position, likewise.
void count_missing(std::span<const double> rate, std::uint32_t* missing);

}  // namespace gyrobudget::inline v0::allan::detail
