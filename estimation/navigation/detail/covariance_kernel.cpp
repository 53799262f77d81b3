// SPDX-License-Identifier: MIT
// Four rows at a time in vectors of the compiler, which become two or one registers: no target is named
// outside the two functions at the end, and of Eigen nothing but data() is called, so no code for AVX2 leaks.
#include "covariance_kernel.h"

#define GYROBUDGET_INLINE inline __attribute__((always_inline))

namespace gyrobudget::inline v0::navigation::detail {
namespace {

constexpr int kCore = kCoreStates;
constexpr int kInputs = 6;
constexpr int kCoreRows = padded(kCore);
constexpr int kTurned = kAttitude;  // rows from here see attitude and gyro alone

using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

/// Lanes that lie in memory as doubles do. That they need no more alignment is said by a struct, for an
/// attribute of a typedef is lost where Clang compiles a function that returns a reference: it would promise
/// the optimiser the alignment of the plain vector, of 32 bytes, and P is only at a multiple of 16.
struct __attribute__((packed, aligned(alignof(double)), may_alias)) InMemory {
  Lanes lanes;
};
static_assert(alignof(InMemory) == alignof(double) && sizeof(InMemory) == sizeof(Lanes));

GYROBUDGET_INLINE InMemory& at(double* x) { return *reinterpret_cast<InMemory*>(x); }
GYROBUDGET_INLINE const InMemory& at(const double* x) { return *reinterpret_cast<const InMemory*>(x); }

/// out_i = sum_j core(i, j) x_j + sum_s input(i, s) e_s for columns of `rows` numbers.
GYROBUDGET_INLINE void transform(const double* core, const double* input, int rows, const double* x, int x_stride,
                                 const double* e, int e_stride, double* out, int out_stride) {
  for (int r = 0; r < rows; r += kLanes) {
    Lanes column[kCore], error[kInputs];
    for (int j = 0; j < kCore; ++j) column[j] = at(x + j * x_stride + r).lanes;
    for (int s = 0; s < kInputs; ++s) error[s] = at(e + s * e_stride + r).lanes;
    for (int i = 0; i < kTurned; ++i) {
      Lanes sum = core[i] * column[0];
      for (int j = 1; j < kCore; ++j) sum += core[i + kCore * j] * column[j];
      for (int s = 0; s < kInputs; ++s) sum += input[i + kCore * s] * error[s];
      at(out + i * out_stride + r).lanes = sum;
    }
    for (int i = kTurned; i < kCore; ++i) {
      Lanes sum = core[i + kCore * kTurned] * column[kTurned];
      for (int j = kTurned + 1; j < kCore; ++j) sum += core[i + kCore * j] * column[j];
      for (int s = 0; s < kInputs / 2; ++s) sum += input[i + kCore * s] * error[s];
      at(out + i * out_stride + r).lanes = sum;
    }
  }
}

GYROBUDGET_INLINE void add(double factor, const double* x, double* sum, int rows) {
  for (int r = 0; r < rows; r += kLanes) at(sum + r).lanes += factor * at(x + r).lanes;
}

/// The sensor block: elements times both decays, in an order in which P stays symmetric.
GYROBUDGET_INLINE void decay(const Transition& step, double* p, int stride) {
  alignas(32) double decays[kMaxStates];
  bool any = false;
  for (int i = 0; i < stride; ++i) decays[i] = 1;
  for (int i = kCore; i < step.size; ++i) {
    decays[i] = step.terms[static_cast<std::size_t>(i - kCore)].decay;
    any |= decays[i] != 1;
  }
  if (!any) return;
  for (int k = kCore; k < step.size; ++k)
    for (int r = kCore / kLanes * kLanes; r < stride; r += kLanes)
      at(p + k * stride + r).lanes *= decays[k] * at(decays + r).lanes;
}

// With C = input W, W (6 x n) one gain a column, and M = [core, C] P:
//   P_cc = M_c core^T + (M_s W^T + input q) input^T,  P_cs = M_s decay + ...,  P_ss = decay P decay + q.
GYROBUDGET_INLINE void propagate(const Transition& step, double* p) {
  const int stride = padded(step.size), terms = step.size - kCore;
  const double* core = step.core.data();
  const double* input = step.input.data();
  alignas(32) double errors[kInputs * kMaxStates];  // P W^T
  alignas(32) double moved[kCore * kMaxStates];     // M^T
  alignas(32) double rows[kMaxStates * kCoreRows];  // M, column by column
  alignas(32) double inputs[kInputs * kCoreRows];   // input, filled up
  alignas(32) double shared[kInputs * kCoreRows];   // M_s W^T + input q
  alignas(32) double updated[kCore * kCoreRows];    // P_cc, of which one half counts
  double noise[kInputs];

  for (int s = 0; s < kInputs; ++s) {
    noise[s] = step.input_noise.data()[s];
    for (int r = 0; r < stride; ++r) errors[s * stride + r] = 0;
  }
  for (int k = 0; k < terms; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal < 0) continue;
    add(term.gain, p + (kCore + k) * stride, errors + term.signal * stride, stride);
    noise[term.signal] += term.noise * term.spill * term.spill;
  }
  transform(core, input, stride, p, stride, errors, stride, moved, stride);

  for (int i = 0; i < step.size; ++i) {
    for (int j = 0; j < kCore; ++j) rows[i * kCoreRows + j] = moved[j * stride + i];
    for (int j = kCore; j < kCoreRows; ++j) rows[i * kCoreRows + j] = 0;
  }
  for (int s = 0; s < kInputs; ++s)
    for (int i = 0; i < kCoreRows; ++i) {
      inputs[s * kCoreRows + i] = i < kCore ? input[i + kCore * s] : 0;
      shared[s * kCoreRows + i] = inputs[s * kCoreRows + i] * noise[s];
    }
  for (int k = 0; k < terms; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal >= 0) add(term.gain, rows + (kCore + k) * kCoreRows, shared + term.signal * kCoreRows, kCoreRows);
  }
  transform(core, input, kCoreRows, rows, kCoreRows, shared, kCoreRows, updated, kCoreRows);
  for (int j = 0; j < kCore; ++j)
    for (int i = 0; i <= j; ++i)
      p[j * stride + i] = p[i * stride + j] = (updated[j * kCoreRows + i] + updated[i * kCoreRows + j]) / 2;

  decay(step, p, stride);
  for (int k = 0; k < terms; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    double* cross = rows + (kCore + k) * kCoreRows;
    for (int r = 0; r < kCoreRows; r += kLanes) at(cross + r).lanes *= term.decay;
    if (term.signal >= 0 && term.noise != 0)
      add(term.noise * term.spill, inputs + term.signal * kCoreRows, cross, kCoreRows);
    for (int i = 0; i < kCore; ++i) p[(kCore + k) * stride + i] = p[i * stride + kCore + k] = cross[i];
    p[(kCore + k) * stride + kCore + k] += term.noise;
  }
}

void propagate_baseline(const Transition& step, double* p) { propagate(step, p); }
__attribute__((target("avx2"))) void propagate_avx2(const Transition& step, double* p) { propagate(step, p); }

}  // namespace

bool supported(Target target) { return target == Target::baseline || __builtin_cpu_supports("avx2") != 0; }

Target best_target() {
  static const Target best = supported(Target::avx2) ? Target::avx2 : Target::baseline;
  return best;
}

void propagate_dense(Target target, const Transition& step, double* p) {
  (target == Target::avx2 ? propagate_avx2 : propagate_baseline)(step, p);
}

}  // namespace gyrobudget::inline v0::navigation::detail
