// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

namespace gyrobudget::inline v0::noise {

/// Names a stream of random numbers: the same (seed, stream, index) gives the same number on every x86-64
/// machine, at any thread count and in any chunking. Distinct streams, and normal and uniform numbers of one
/// stream, are independent.
struct StreamKey {
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;
};

// Numbers come from Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3",
// SC11; the Random123 package): key = seed, counter = (index / 2, stream), each block of 128 bits giving two
// of them. Indices run modulo 2^64. Safe to call from many threads.

/// Standard normal numbers first, first+1, ... of the stream, by the Box-Muller transform of two 52-bit
/// uniforms. They reach +-8.57, beyond which the normal distribution has 1e-17 of its weight; error of the
/// transform below 1e-15 of the number.
void fill_normal(StreamKey key, std::uint64_t first, std::span<double> out);

/// Uniform numbers first, first+1, ... of the stream: (k + 1/2) 2^-52, in (0, 1).
void fill_uniform(StreamKey key, std::uint64_t first, std::span<double> out);

}  // namespace gyrobudget::inline v0::noise
