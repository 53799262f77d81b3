// SPDX-License-Identifier: MIT
#include "second_difference.h"

#include <algorithm>

// The loops are written once and compiled once per instruction set: always_inline bodies inside functions that
// differ by their target attribute alone.
#if defined(__x86_64__) && defined(__clang__)
#define GYROBUDGET_AVX2 [[gnu::target("avx2")]]
#define GYROBUDGET_AVX512 [[gnu::target("avx512f,avx512vl,avx512dq")]]
#elif defined(__x86_64__) && defined(__GNUC__)
#define GYROBUDGET_AVX2 [[gnu::target("avx2")]]
#define GYROBUDGET_AVX512 [[gnu::target("avx512f,avx512vl,avx512dq,prefer-vector-width=512")]]
#else
#define GYROBUDGET_AVX2
#define GYROBUDGET_AVX512
#endif

namespace gyrobudget::inline v0::allan::detail {
namespace {

constexpr int kLanes = 16;

[[gnu::always_inline]] inline double sum_lanes(double (&lane)[kLanes]) {
  for (int half = kLanes / 2; half > 0; half /= 2) {
    for (int l = 0; l < half; ++l) lane[l] += lane[l + half];
  }
  return lane[0];
}

/// Calls body(k, lane) for k = 0 .. count-1 with lane = k mod kLanes, in blocks the compiler turns into vectors.
template <typename Body>
[[gnu::always_inline]] inline void in_lanes(std::int64_t count, Body body) {
  std::int64_t k = 0;
  for (; k + kLanes <= count; k += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) body(k + lane, lane);
  }
  for (int lane = 0; k + lane < count; ++lane) body(k + lane, lane);
}

[[gnu::always_inline]] inline double complete(const double* x0, std::int64_t count, std::int64_t m) {
  const double *x1 = x0 + m, *x2 = x1 + m;
  double squares[kLanes] = {};
  in_lanes(
      count, [&](std::int64_t k, int lane) __attribute__((always_inline)) {
        const double d = (x2[k] - x1[k]) - (x1[k] - x0[k]);
        squares[lane] += d * d;
      });
  return sum_lanes(squares);
}

[[gnu::always_inline]] inline TripleSum masked(const double* x0, const std::uint32_t* missing0, std::int64_t count,
                                               std::int64_t m, std::int64_t minimum_count) {
  constexpr std::int64_t kBlock = 256;  // terms first, sums after: loops this plain become vectors
  double term[kBlock], valid[kBlock];
  double squares[kLanes] = {}, terms[kLanes] = {};
  const auto length = static_cast<std::int32_t>(m), least = static_cast<std::int32_t>(minimum_count);
  for (std::int64_t first = 0; first < count; first += kBlock) {
    const double *x = x0 + first, *x1 = x + m, *x2 = x1 + m;
    const std::uint32_t *missing = missing0 + first, *missing1 = missing + m, *missing2 = missing1 + m;
    const std::int64_t size = count - first < kBlock ? count - first : kBlock;
    for (std::int64_t k = 0; k < size; ++k) {
      const std::int32_t count1 = length - static_cast<std::int32_t>(missing1[k] - missing[k]);
      const std::int32_t count2 = length - static_cast<std::int32_t>(missing2[k] - missing1[k]);
      const double d = (x2[k] - x1[k]) / std::max(count2, 1) - (x1[k] - x[k]) / std::max(count1, 1);
      valid[k] = static_cast<std::int32_t>(std::min(count1, count2) >= least);
      term[k] = valid[k] * (d * d);  // an empty cluster divides by one and weighs nothing
    }
    in_lanes(
        size, [&](std::int64_t k, int lane) __attribute__((always_inline)) { squares[lane] += term[k]; });
    in_lanes(
        size, [&](std::int64_t k, int lane) __attribute__((always_inline)) { terms[lane] += valid[k]; });
  }
  return {sum_lanes(squares), static_cast<std::int64_t>(sum_lanes(terms))};
}

double complete_baseline(const double* x, std::int64_t count, std::int64_t m) { return complete(x, count, m); }
TripleSum masked_baseline(const double* x, const std::uint32_t* missing, std::int64_t count, std::int64_t m,
                          std::int64_t minimum_count) {
  return masked(x, missing, count, m, minimum_count);
}
GYROBUDGET_AVX2 double complete_avx2(const double* x, std::int64_t count, std::int64_t m) {
  return complete(x, count, m);
}
GYROBUDGET_AVX2 TripleSum masked_avx2(const double* x, const std::uint32_t* missing, std::int64_t count, std::int64_t m,
                                      std::int64_t minimum_count) {
  return masked(x, missing, count, m, minimum_count);
}
GYROBUDGET_AVX512 double complete_avx512(const double* x, std::int64_t count, std::int64_t m) {
  return complete(x, count, m);
}
GYROBUDGET_AVX512 TripleSum masked_avx512(const double* x, const std::uint32_t* missing, std::int64_t count,
                                          std::int64_t m, std::int64_t minimum_count) {
  return masked(x, missing, count, m, minimum_count);
}

}  // namespace

bool supported(InstructionSet set) {
  switch (set) {
    case InstructionSet::baseline:
      return true;
#if defined(__x86_64__) && defined(__GNUC__)
    case InstructionSet::avx2:
      return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
             __builtin_cpu_supports("avx512dq") != 0;
#endif
    default:
      return false;
  }
}

InstructionSet best_supported() {
  static const InstructionSet best = supported(InstructionSet::avx512) ? InstructionSet::avx512
                                     : supported(InstructionSet::avx2) ? InstructionSet::avx2
                                                                       : InstructionSet::baseline;
  return best;
}

const SecondDifference& second_difference(InstructionSet set) {
  static constexpr SecondDifference kKernels[] = {
      {complete_baseline, masked_baseline}, {complete_avx2, masked_avx2}, {complete_avx512, masked_avx512}};
  return kKernels[static_cast<std::size_t>(set)];
}

const SecondDifference& second_difference() { return second_difference(best_supported()); }

}  // namespace gyrobudget::inline v0::allan::detail
