// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/detail/phase.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>

#include "mask.h"

namespace gyrobudget::inline v0::allan {

/// Part of a cluster's samples that must exist for it to count, unless asked otherwise.
inline constexpr double kMinimumFill = 0.95;

/// A rate record made ready for everything that is computed from it: its mean, its gaps, and its prefix sums, which
/// are made when first asked for and then shared. Make one where more than one statistic of a record is wanted.
///
/// It refers to the samples, which must outlive it. NaN and infinite samples are missing (see Mask).
class Series {
 public:
  /// @param rate rates [signal]; for angle increments divide by dt, for angles difference first.
  /// @param dt sample interval [s].
  /// @param minimum_fill part of a cluster's samples that must exist for it to count, in (0, 1]; 1 = all.
  /// @throws std::invalid_argument for dt that is not positive and finite, a minimum fill outside (0, 1], a record of
  /// 2^32 samples or more with gaps, or samples whose sum overflows.
  explicit Series(std::span<const double> rate, double dt = 1, double minimum_fill = kMinimumFill);

  [[nodiscard]] std::span<const double> rate() const { return rate_; }
  [[nodiscard]] double dt() const { return dt_; }
  [[nodiscard]] std::int64_t samples() const { return static_cast<std::int64_t>(rate_.size()); }
  /// Of the samples that exist [signal]; NaN where none does.
  [[nodiscard]] double mean() const { return facts_.mean; }
  /// Null for a complete record.
  [[nodiscard]] const std::shared_ptr<const Mask>& mask() const { return facts_.mask; }
  /// Prefix sums, 8 bytes a sample (12 with gaps). Any thread may ask.
  [[nodiscard]] const detail::Phase& phase() const;

  /// @throws std::invalid_argument unless 1 <= m <= n/2 for each.
  void require_factors(std::span<const std::int64_t> factors) const;

 private:
  std::span<const double> rate_;
  double dt_;
  detail::Census facts_;
  mutable std::once_flag once_;
  mutable detail::Phase phase_;
};

}  // namespace gyrobudget::inline v0::allan
