// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/navigation/error_state.h"

namespace gyrobudget::inline v0::navigation::detail {

/// Instruction sets that the kernel is compiled for. Both give the same bytes: the same operations on the
/// same numbers in the same order, without contraction.
enum class Target { baseline, avx2 };

[[nodiscard]] bool supported(Target);
[[nodiscard]] Target best_target();

/// Rows of a column of P in memory: the states, filled up with zeros to whole lanes.
inline constexpr int kLanes = 4;
[[nodiscard]] constexpr int padded(int states) { return (states + kLanes - 1) / kLanes * kLanes; }

/// P <- Phi P Phi^T + Q for a P that is kept in full, column by column, `padded(step.size)` apart; symmetric
/// to the last bit where P is. About (9 states + 6 terms) multiplications for each of nine rows, and a
/// multiplication an element of the sensor block where a term decays.
void propagate_dense(Target, const Transition& step, double* p);

}  // namespace gyrobudget::inline v0::navigation::detail
