// SPDX-License-Identifier: MIT
#include "family_kernel.h"

#include "lanes.h"

// Bodies are written once, always inlined into functions that differ by their target attribute alone.
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
#define GYROBUDGET_INLINE __attribute__((always_inline))

namespace gyrobudget::inline v0::allan::detail {
namespace {

GYROBUDGET_INLINE inline double square(double value) { return value * value; }

GYROBUDGET_INLINE inline double third(const double* x0, std::int64_t count, std::int64_t m) {
  const double *x1 = x0 + m, *x2 = x1 + m, *x3 = x2 + m;
  return lane_sum(count, [=](std::int64_t k) GYROBUDGET_INLINE {
    return square(((x3[k] - x2[k]) - (x2[k] - x1[k])) - ((x2[k] - x1[k]) - (x1[k] - x0[k])));
  });
}

/// Prefix sums of what is left of 3m values without their mean and slope.
GYROBUDGET_INLINE inline void remove_trend(const double* p, std::int64_t m, double* s) {
  const std::int64_t length = 3 * m, half = length / 2, second = length - half;
  const double mean = (p[length] - p[0]) / static_cast<double>(length);
  const double rise = (p[length] - p[second]) - (p[half] - p[0]);
  const double bend = rise / static_cast<double>(half) / static_cast<double>(second) / 2, first = p[0];
  const auto end = static_cast<double>(length);
  for (std::int64_t j = 0; j <= length; ++j) {
    const auto t = static_cast<double>(static_cast<std::int32_t>(j));
    s[j] = (p[j] - first) - t * (mean - bend * (end - t));
  }
}

// Even continuation has period 6m and mirror symmetry, so 4m of the 6m places are enough. Its prefix sums are
// S(t) to 3m and -S(6m - t) from there on, as S(3m) = 0; a second difference of sums over m takes four of
// them.
GYROBUDGET_INLINE inline double even(const double* p, std::int64_t m, double* scratch) {
  remove_trend(p, m, scratch);
  const double *s = scratch, *end = s + 3 * m;
  const double inside = lane_sum(
      m, [=](std::int64_t t) GYROBUDGET_INLINE { return square((end[-t] + s[t]) + 3 * (s[t + 2 * m] - s[t + m])); });
  const double right = lane_sum(m + 1, [=](std::int64_t i) GYROBUDGET_INLINE {
    const std::int64_t t = m + i;
    return square((end[-t] + s[t]) - 3 * (end[m - t] + s[t + m]));
  });
  const double outside = lane_sum(m, [=](std::int64_t i) GYROBUDGET_INLINE {
    const std::int64_t u = i + 1;
    return square((s[u] + end[-u]) + 3 * (s[m - u] - s[2 * m - u]));
  });
  const double left = lane_sum(m - 1, [=](std::int64_t i) GYROBUDGET_INLINE {
    const std::int64_t u = m + i + 1;
    return square((s[u] + end[-u]) - 3 * (s[u - m] + s[2 * m - u]));
  });
  return (2 * (inside + outside) + (right + left)) / static_cast<double>(6 * m);
}

GYROBUDGET_INLINE inline double theo(const double* x, std::int64_t m, const double* weight) {
  const double *begin = x + 1, *end = x + m - 1;
  const double ends = x[0] + x[m];
  return lane_sum(m / 2,
                  [=](std::int64_t j) GYROBUDGET_INLINE { return weight[j] * square(ends - (begin[j] + end[-j])); });
}

double third_baseline(const double* x, std::int64_t count, std::int64_t m) { return third(x, count, m); }
double even_baseline(const double* p, std::int64_t m, double* s) { return even(p, m, s); }
double theo_baseline(const double* x, std::int64_t m, const double* w) { return theo(x, m, w); }
GYROBUDGET_AVX2 double third_avx2(const double* x, std::int64_t count, std::int64_t m) { return third(x, count, m); }
GYROBUDGET_AVX2 double even_avx2(const double* p, std::int64_t m, double* s) { return even(p, m, s); }
GYROBUDGET_AVX2 double theo_avx2(const double* x, std::int64_t m, const double* w) { return theo(x, m, w); }
GYROBUDGET_AVX512 double third_avx512(const double* x, std::int64_t count, std::int64_t m) {
  return third(x, count, m);
}
GYROBUDGET_AVX512 double even_avx512(const double* p, std::int64_t m, double* s) { return even(p, m, s); }
GYROBUDGET_AVX512 double theo_avx512(const double* x, std::int64_t m, const double* w) { return theo(x, m, w); }

}  // namespace

const FamilyKernel& family_kernel(InstructionSet set) {
  static constexpr FamilyKernel kKernels[] = {{third_baseline, even_baseline, theo_baseline},
                                              {third_avx2, even_avx2, theo_avx2},
                                              {third_avx512, even_avx512, theo_avx512}};
  return kKernels[static_cast<std::size_t>(set)];
}

const FamilyKernel& family_kernel() { return family_kernel(best_supported()); }

}  // namespace gyrobudget::inline v0::allan::detail
