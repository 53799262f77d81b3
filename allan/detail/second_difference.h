// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace gyrobudget::inline v0::allan::detail {

/// Sum over the triples that count, and how many did.
struct TripleSum {
  double squares = 0;
  std::int64_t terms = 0;
};

/// The inner loops of the Allan variance, in one instruction set. Every set adds in the same lanes and in the
/// same order without fused multiply-add, so all give the same bytes.
struct SecondDifference {
  /// Sum over k < count of (x[k+2m] - 2 x[k+m] + x[k])^2.
  double (*complete)(const double* x, std::int64_t count, std::int64_t m);

  /// The same for a record with gaps: x are prefix sums with 0 for a missing sample, `missing` counts the missing
  /// ones before each position (modulo 2^32). A triple counts where both clusters hold at least `minimum_count`
  /// samples; its term is the squared difference of the means over the samples that exist.
  TripleSum (*masked)(const double* x, const std::uint32_t* missing, std::int64_t count, std::int64_t m,
                      std::int64_t minimum_count);
};

enum class InstructionSet { baseline, avx2, avx512 };
[[nodiscard]] bool supported(InstructionSet);
/// The widest that this processor has.
[[nodiscard]] InstructionSet best_supported();
[[nodiscard]] const SecondDifference& second_difference(InstructionSet);
/// The fastest that this machine has.
[[nodiscard]] const SecondDifference& second_difference();

}  // namespace gyrobudget::inline v0::allan::detail
