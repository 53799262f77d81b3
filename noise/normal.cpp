// SPDX-License-Identifier: MIT
#include "normal.h"

#include "gyrobudget/noise/detail/normal_kernel.h"

#include <Random123/philox.h>
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#define GYROBUDGET_INLINE inline __attribute__((always_inline))

namespace gyrobudget::inline v0::noise {
namespace detail {
namespace {

// --- Elementary functions in plain double operations, for loops that vectorise -----------------------------

/// x[k] + y x[k+1] + ... by Horner's rule.
template <std::size_t n>
GYROBUDGET_INLINE double polynomial(const std::array<double, n>& coefficients, double y) {
  double sum = coefficients[n - 1];
  for (std::size_t k = n - 1; k-- > 0;) sum = sum * y + coefficients[k];
  return sum;
}

/// Coefficients of artanh(s)/s, sin(x)/x and cos(x) as series in s^2 and x^2.
template <std::size_t n>
constexpr std::array<double, n> artanh_series() {
  std::array<double, n> c{};
  for (std::size_t k = 0; k < n; ++k) c[k] = 1 / static_cast<double>(2 * k + 1);
  return c;
}
template <std::size_t n>
constexpr std::array<double, n> alternating_factorial_series(int first) {
  std::array<double, n> c{};
  double factorial = 1, sign = 1;
  for (std::size_t k = 0; k < n; ++k, sign = -sign) {
    c[k] = sign / factorial;
    factorial *= static_cast<double>((2 * k + static_cast<std::size_t>(first) + 1) *
                                     (2 * k + static_cast<std::size_t>(first) + 2));
  }
  return c;
}
constexpr auto kArtanh = artanh_series<11>();                 // next term 1e-18 at |s| = 0.172
constexpr auto kSine = alternating_factorial_series<8>(1);    // 5e-17 at pi/4
constexpr auto kCosine = alternating_factorial_series<9>(0);  // 2e-18 at pi/4

/// ln(u) of a normal positive number: u = 2^e m with m in [sqrt(1/2), sqrt(2)), ln m = 2 artanh((m-1)/(m+1)).
GYROBUDGET_INLINE double logarithm(double u) {
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcd;  // bits of sqrt(1/2)
  constexpr std::uint64_t kMantissa = 0x000fffffffffffff;
  const auto bits = std::bit_cast<std::uint64_t>(u);
  const std::uint64_t shifted = bits - kRootHalf + (std::uint64_t{1023} << 52);  // exponent field 1023 + e
  const auto m = std::bit_cast<double>((shifted & kMantissa) + kRootHalf);
  // The exponent as a double without an integer conversion, which AVX2 lacks: put it into the mantissa of
  // 2^52.
  constexpr double kTwo52 = 0x1p52;
  const auto e = std::bit_cast<double>((shifted >> 52) | std::bit_cast<std::uint64_t>(kTwo52)) - (kTwo52 + 1023);
  const double s = (m - 1) / (m + 1);
  constexpr double kLn2High = 0x1.62e42feep-1,
                   kLn2Low = 0x1.a39ef35793c76p-33;  // ln 2 in two parts, e * high exact
  return e * kLn2High + (2 * s * polynomial(kArtanh, s * s) + e * kLn2Low);
}

/// 52 random bits as a number in [1, 2).
GYROBUDGET_INLINE double one_to_two(std::uint64_t word) {
  return std::bit_cast<double>((word >> 12) | std::bit_cast<std::uint64_t>(1.0));
}

GYROBUDGET_INLINE double uniform(std::uint64_t word) { return (one_to_two(word) - 1) + 0x1p-53; }

/// Box-Muller: radius from one word; from the other a direction within +-pi/4 of an axis, and which axis.
GYROBUDGET_INLINE void box_muller(std::uint64_t radius_word, std::uint64_t angle_word, double& x, double& y) {
  const double radius = std::sqrt(-2 * logarithm(uniform(radius_word)));
  const double angle = ((one_to_two(angle_word) - 1.5) + 0x1p-53) * (std::numbers::pi / 2);
  const double square = angle * angle;
  const double along = radius * polynomial(kCosine, square), across = radius * (angle * polynomial(kSine, square));
  const std::uint64_t swap = 0 - (angle_word & 1), sign = (angle_word & 2) << 62;
  const auto a = std::bit_cast<std::uint64_t>(along), b = std::bit_cast<std::uint64_t>(across);
  const std::uint64_t difference = (a ^ b) & swap;
  x = std::bit_cast<double>(a ^ difference ^ sign);
  y = std::bit_cast<double>(b ^ difference ^ sign);
}

// --- Blocks ------------------------------------------------------------------------------------------------

constexpr std::int64_t kTile = 128;  // blocks whose words stay in the first-level cache
struct Words {
  std::uint64_t first[kTile], second[kTile];
};

std::uint32_t low(std::uint64_t v) { return static_cast<std::uint32_t>(v); }
std::uint32_t high(std::uint64_t v) { return static_cast<std::uint32_t>(v >> 32); }

/// The two 64-bit words of up to kTile blocks.
void philox_baseline(BlockKey key, std::uint64_t block, std::int64_t count, Words& words) {
  const philox4x32_key_t seed = {{low(key.seed), high(key.seed)}};
  for (std::int64_t i = 0; i < count; ++i, ++block) {
    const philox4x32_ctr_t counter = {{low(block), high(block), low(key.stream), high(key.stream)}};
    const philox4x32_ctr_t r = philox4x32_R(10, counter, seed);
    words.first[i] = r.v[0] | static_cast<std::uint64_t>(r.v[1]) << 32;
    words.second[i] = r.v[2] | static_cast<std::uint64_t>(r.v[3]) << 32;
  }
}

struct Normal {
  GYROBUDGET_INLINE void operator()(std::uint64_t w0, std::uint64_t w1, double& x, double& y) const {
    box_muller(w0, w1, x, y);
  }
};
struct Uniform {
  GYROBUDGET_INLINE void operator()(std::uint64_t w0, std::uint64_t w1, double& x, double& y) const {
    x = uniform(w0);
    y = uniform(w1);
  }
};

template <typename Transform>
GYROBUDGET_INLINE void transform_words(const Words& words, std::int64_t count, double* out) {
  for (std::int64_t i = 0; i < count; ++i) {
    Transform{}(words.first[i], words.second[i], out[2 * i], out[2 * i + 1]);
  }
}
template <typename Transform>
void transform_baseline(const Words& words, std::int64_t count, double* out) {
  transform_words<Transform>(words, count, out);
}

namespace avx2 {
#define GYROBUDGET_TARGET __attribute__((target("avx2")))
using Lanes = std::uint64_t __attribute__((vector_size(32)));
GYROBUDGET_TARGET inline Lanes product(const Lanes& a, const Lanes& b) {
  return reinterpret_cast<Lanes>(_mm256_mul_epu32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
}
#include "gyrobudget/noise/detail/normal_lanes.inc"
#undef GYROBUDGET_TARGET
}  // namespace avx2

namespace avx512 {
#define GYROBUDGET_TARGET __attribute__((target("avx512f,avx512dq")))
using Lanes = std::uint64_t __attribute__((vector_size(64)));
GYROBUDGET_TARGET inline Lanes product(const Lanes& a, const Lanes& b) {
  // The masked form: the plain one reads a register that GCC 12 warns is not set.
  constexpr __mmask8 kAll = 0xff;
  return reinterpret_cast<Lanes>(
      _mm512_maskz_mul_epu32(kAll, reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
}
#include "gyrobudget/noise/detail/normal_lanes.inc"
#undef GYROBUDGET_TARGET
}  // namespace avx512

/// How an instruction set makes the words of a tile and turns them into numbers.
template <typename Transform>
struct Kernel {
  void (*words)(BlockKey, std::uint64_t block, std::int64_t count, Words&);
  void (*transform)(const Words&, std::int64_t count, double* out);

  static Kernel of(Target target) {
    if (target == Target::avx512) return {avx512::philox, avx512::transform<Transform>};
    if (target == Target::avx2) return {avx2::philox, avx2::transform<Transform>};
    return {philox_baseline, transform_baseline<Transform>};
  }
};

template <typename Transform>
void blocks_in_tiles(Target target, BlockKey key, std::uint64_t first, std::int64_t blocks, double* out) {
  const auto kernel = Kernel<Transform>::of(target);
  Words words;
  for (std::int64_t done = 0; done < blocks; done += kTile) {
    const std::int64_t count = std::min(kTile, blocks - done);
    kernel.words(key, first + static_cast<std::uint64_t>(done), count, words);
    kernel.transform(words, count, out + 2 * done);
  }
}

}  // namespace

bool supported(Target target) {
  switch (target) {
    case Target::baseline:
      return true;
    case Target::avx2:
      return __builtin_cpu_supports("avx2");
    case Target::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
  }
  return false;
}

Target best_target() {
  static const Target best = supported(Target::avx512) ? Target::avx512
                             : supported(Target::avx2) ? Target::avx2
                                                       : Target::baseline;
  return best;
}

void normal_blocks(Target target, BlockKey key, std::uint64_t first, std::int64_t blocks, double* out) {
  blocks_in_tiles<Normal>(target, key, first, blocks, out);
}

void uniform_blocks(Target target, BlockKey key, std::uint64_t first, std::int64_t blocks, double* out) {
  blocks_in_tiles<Uniform>(target, key, first, blocks, out);
}

}  // namespace detail

namespace {

using BlockFunction = void (*)(detail::Target, detail::BlockKey, std::uint64_t, std::int64_t, double*);

/// Numbers first, first+1, ... where number 2 b + i is number i of block b + offset.
void fill(BlockFunction blocks, StreamKey key, std::uint64_t offset, std::uint64_t first, std::span<double> out) {
  const detail::BlockKey block_key{key.seed, key.stream};
  const auto whole = [&](std::uint64_t block, std::int64_t count, double* to) {
    blocks(detail::best_target(), block_key, offset + block, count, to);
  };
  std::array<double, 2> pair{};
  if (first % 2 == 1 && !out.empty()) {  // the second half of a block
    whole(first / 2, 1, pair.data());
    out[0] = pair[1];
    out = out.subspan(1);
    ++first;
  }
  whole(first / 2, std::ssize(out) / 2, out.data());
  if (out.size() % 2 == 1) {  // the first half of a block
    whole((first + out.size() - 1) / 2, 1, pair.data());
    out.back() = pair[0];
  }
}

}  // namespace

void fill_normal(StreamKey key, std::uint64_t first, std::span<double> out) {
  fill(detail::normal_blocks, key, 0, first, out);
}

void fill_uniform(StreamKey key, std::uint64_t first, std::span<double> out) {
  constexpr std::uint64_t kOwnBlocks = std::uint64_t{1} << 63;  // index / 2 never reaches them
  fill(detail::uniform_blocks, key, kOwnBlocks, first, out);
}

}  // namespace gyrobudget::inline v0::noise
