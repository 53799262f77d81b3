// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/detail/state_bank.h"

#include <cstring>

namespace gyrobudget::inline v0::noise::detail {
namespace {

using Lanes = double __attribute__((vector_size(StateBank::kLanes * sizeof(double))));

#define GYROBUDGET_INLINE inline __attribute__((always_inline))

// Vectors are passed by reference: by value they would need an ABI that not every target has.
GYROBUDGET_INLINE void load(const double* from, Lanes& to) { std::memcpy(&to, from, sizeof to); }
GYROBUDGET_INLINE void store(const Lanes& from, double* to) { std::memcpy(to, &from, sizeof from); }
GYROBUDGET_INLINE double total(const Lanes& x) { return (x[0] + x[2]) + (x[1] + x[3]); }

struct Bank {
  const double *phi, *step;
  double* state;
  std::size_t size;  ///< a multiple of the lanes
};

GYROBUDGET_INLINE void run_lanes(Bank bank, const double* drive, std::size_t stride, std::span<double> sums) {
  for (double& out : sums) {
    Lanes sum{};
    for (std::size_t i = 0; i < bank.size; i += StateBank::kLanes) {
      Lanes x, phi, step, u;
      load(bank.state + i, x);
      load(bank.phi + i, phi);
      load(bank.step + i, step);
      load(drive + i, u);
      sum += x;
      x = phi * x + step * u;
      store(x, bank.state + i);
    }
    out = total(sum);
    drive += stride;
  }
}

void run_baseline(Bank bank, const double* drive, std::size_t stride, std::span<double> sums) {
  run_lanes(bank, drive, stride, sums);
}
__attribute__((target("avx2"))) void run_avx2(Bank bank, const double* drive, std::size_t stride,
                                              std::span<double> sums) {
  run_lanes(bank, drive, stride, sums);
}

}  // namespace

void StateBank::add(double phi, double step, double start) {
  if (size_ == state_.size()) {
    for (auto* values : {&phi_, &step_, &state_}) values->resize(size_ + kLanes);
  }
  phi_[size_] = phi;
  step_[size_] = step;
  state_[size_++] = start;
}

double StateBank::sum() const {
  Lanes sum{};
  for (std::size_t i = 0; i < state_.size(); i += kLanes) {
    Lanes x;
    load(state_.data() + i, x);
    sum += x;
  }
  return total(sum);
}

void StateBank::run(Target target, std::span<const double> drive, std::size_t stride, std::span<double> sums) {
  const Bank bank{phi_.data(), step_.data(), state_.data(), state_.size()};
  (target == Target::baseline ? run_baseline : run_avx2)(bank, drive.data(), stride, sums);
}

}  // namespace gyrobudget::inline v0::noise::detail
