// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace gyrobudget::inline v0::noise::detail {

/// Instruction sets that the kernels are compiled for. All give the same bytes: every operation is one IEEE
/// 754 binary64 or integer operation per number, in the same order, without contraction and without the
/// mathematical library.
enum class Target { baseline, avx2, avx512 };

[[nodiscard]] bool supported(Target);
[[nodiscard]] Target best_target();

/// A Philox4x32-10 key and the part of its counter that does not run.
struct BlockKey {
  std::uint64_t seed = 0;
  std::uint64_t stream = 0;
};

/// Blocks first, first+1, ... as the low 64 bits of the counter; each gives two numbers, so `out` holds 2 *
/// blocks.
void normal_blocks(Target, BlockKey, std::uint64_t first, std::int64_t blocks, double* out);
void uniform_blocks(Target, BlockKey, std::uint64_t first, std::int64_t blocks, double* out);

}  // namespace gyrobudget::inline v0::noise::detail
