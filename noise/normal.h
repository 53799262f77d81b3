// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

namespace gyrobudget::inline v0::noise {

/// Names a stream of random numbers: the same (seed, stream, index) gives the same number on every machine, at any
/// thread count and in any chunking.
struct StreamKey {
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;
};

/// Standard normal numbers first, first+1, ... of the stream.
void fill_normal(StreamKey, std::uint64_t first, std::span<double> out);
/// Uniform numbers in (0, 1).
void fill_uniform(StreamKey, std::uint64_t first, std::span<double> out);

}  // namespace gyrobudget::inline v0::noise
