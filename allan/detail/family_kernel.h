// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "second_difference.h"

namespace gyrobudget::inline v0::allan::detail {

/// The inner loops of the family that cost most, in one instruction set: same lanes and order of additions in
/// all, no fused multiply-add, hence the same bytes.
struct FamilyKernel {
  /// Sum over k < count of (x[k+3m] - 3 x[k+2m] + 3 x[k+m] - x[k])^2.
  double (*third_differences)(const double* x, std::int64_t count, std::int64_t m);

  /// Of values z_0 .. z_{3m-1} whose prefix sums are p_0 .. p_{3m}: the slope that the means of their halves
  /// show is removed, the rest is continued as z_2 z_1 z_0 | z_0 z_1 z_2 ..., and the second differences of
  /// sums over m are squared and averaged over 6m places. `scratch` holds 3m + 1 numbers.
  double (*even_continuation)(const double* p, std::int64_t m, double* scratch);

  /// sum_{j=1}^{m/2} weight[j-1] (x[0] + x[m] - x[j] - x[m-j])^2.
  double (*theo1)(const double* x, std::int64_t m, const double* weight);
};

[[nodiscard]] const FamilyKernel& family_kernel(InstructionSet);
/// The fastest that this machine has.
[[nodiscard]] const FamilyKernel& family_kernel();

}  // namespace gyrobudget::inline v0::allan::detail
