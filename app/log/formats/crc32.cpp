// SPDX-License-Identifier: MIT
#include "crc32.h"

#include <zlib.h>

#include <cstddef>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace gyrobudget::inline v0::log {
namespace {

std::uint32_t zlib_crc32(std::uint32_t before, const void* data, std::size_t size) {
  return static_cast<std::uint32_t>(::crc32_z(before, static_cast<const Bytef*>(data), size));
}

#ifdef __x86_64__

/// x^power modulo the polynomial of CRC-32. Its bits are in the order of the bytes' own, x^31 the lowest, and one place
/// up: a product of two such 64-bit numbers has 127 bits.
constexpr long long power_of_x(int power) {
  std::uint32_t value = 0x80000000U;  // 1
  for (int i = 0; i < power; ++i) value = value >> 1U ^ ((value & 1U) != 0 ? 0xedb88320U : 0U);
  return static_cast<long long>(std::uint64_t{value} << 1U);
}

/// Moves 128 bits of a message on by as many places as the two powers say, and adds them to what stands there. The
/// powers of its halves differ by 64; they are 32 above and below the places, for a remainder has 32 bits of 64.
__attribute__((target("pclmul,sse4.1"))) inline __m128i fold(__m128i bits, __m128i powers, __m128i onto) {
  const __m128i low = _mm_clmulepi64_si128(bits, powers, 0x00), high = _mm_clmulepi64_si128(bits, powers, 0x11);
  return _mm_xor_si128(_mm_xor_si128(low, high), onto);
}

/// Folds a message (at least 64 bytes) into its last 16 bytes, which leave the same remainder; zlib takes these, and
/// what is behind the last whole 16 bytes. Four folds run side by side, as each waits for the one before.
/// After V. Gopal and others, Fast CRC Computation for Generic Polynomials Using PCLMULQDQ, Intel, 2009.
__attribute__((target("pclmul,sse4.1"))) std::uint32_t folded_crc32(std::string_view bytes) {
  constexpr std::size_t kLane = 16, kLanes = 4;
  constexpr int kBits = 8 * kLane;
  const __m128i by_four = _mm_set_epi64x(power_of_x(kLanes * kBits - 32), power_of_x(kLanes * kBits + 32));
  const __m128i by_one = _mm_set_epi64x(power_of_x(kBits - 32), power_of_x(kBits + 32));
  const auto take = [&]() __attribute__((target("pclmul,sse4.1"))) {
    const __m128i lane = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes.data()));
    bytes.remove_prefix(kLane);
    return lane;
  };
  __m128i lanes[kLanes];
  for (__m128i& lane : lanes) lane = take();
  lanes[0] = _mm_xor_si128(lanes[0], _mm_cvtsi32_si128(-1));  // a CRC-32 begins with ones
  while (bytes.size() >= kLane * kLanes) {
    for (__m128i& lane : lanes) lane = fold(lane, by_four, take());
  }
  __m128i sum = lanes[0];
  for (std::size_t i = 1; i < kLanes; ++i) sum = fold(sum, by_one, lanes[i]);
  while (bytes.size() >= kLane) sum = fold(sum, by_one, take());
  constexpr std::uint32_t kNothingBefore = 0xffffffffU;  // to zlib, which inverts it
  return zlib_crc32(zlib_crc32(kNothingBefore, &sum, sizeof sum), bytes.data(), bytes.size());
}

#endif

}  // namespace

std::uint32_t crc32_of(std::string_view bytes) {
#ifdef __x86_64__
  constexpr std::size_t kWorthIt = 256;
  static const bool kFolds = __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("sse4.1");
  if (kFolds && bytes.size() >= kWorthIt) return folded_crc32(bytes);
#endif
  return zlib_crc32(0, bytes.data(), bytes.size());
}

}  // namespace gyrobudget::inline v0::log
