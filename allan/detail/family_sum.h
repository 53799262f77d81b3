// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/estimator.h"

#include <cstdint>

namespace gyrobudget::inline v0::allan::detail {

/// A record as the sums over its terms see it.
struct FamilyRecord {
  const double* x;               ///< n + 1 prefix sums of the rate, missing samples bridged
  const std::uint32_t* missing;  ///< missing samples before each of the n + 1 positions; null for a complete record
  std::int64_t samples;          ///< n
  double minimum_fill;           ///< part of the samples a term spans that must exist for it to count
};

/// Sum over terms that count, and how many did.
struct TermSum {
  double squares = 0;
  std::int64_t terms = 0;
};

/// Number of positions at which a term can begin, one sample apart.
[[nodiscard]] std::int64_t family_positions(Estimator, std::int64_t samples, std::int64_t m);

/// A shorter record that is to clusters of `coarse` samples as this one is to clusters of m: the same number
/// of positions in clusters.
[[nodiscard]] std::int64_t rescaled_samples(Estimator, std::int64_t samples, std::int64_t m, std::int64_t coarse);

/// What one term costs in elementary steps: 1, or about m where it is a sum over m samples.
[[nodiscard]] std::int64_t steps_per_term(Estimator, std::int64_t m);

/// TheoBR and TheoH have no terms of their own: see basis_of.
/// Sum of the squares of the terms that begin at positions first, first + stride, ... (count of them), in
/// units where x is the phase and one sample is the unit of time: see family_scale.
[[nodiscard]] TermSum family_sum(Estimator, const FamilyRecord&, std::int64_t m, std::int64_t first,
                                 std::int64_t stride, std::int64_t count);

/// The variance is squares / terms times this.
[[nodiscard]] double family_scale(Estimator, std::int64_t m, double dt);

}  // namespace gyrobudget::inline v0::allan::detail
