// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/detail/state_bank.h"

#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gyrobudget::noise::detail {
namespace {

constexpr std::size_t kSteps = 200;

StateBank bank_of(std::size_t states) {
  StateBank bank;
  for (std::size_t i = 0; i < states; ++i) {
    const double x = static_cast<double>(i + 1);
    bank.add(1 / (1 + x), 0.3 * x, 1 / x);
  }
  return bank;
}

std::vector<double> drive_for(std::size_t stride) {
  std::vector<double> drive(kSteps * stride + StateBank::kLanes);
  fill_normal({4, 2}, 0, drive);
  return drive;
}

TEST(StateBank, IsItsRecursion) {
  for (const std::size_t states : {1, 3, 4, 5, 21, 24}) {
    const std::size_t stride = states + 1;
    const auto drive = drive_for(stride);
    StateBank bank = bank_of(states);
    std::vector<double> sums(kSteps), state(states);
    for (std::size_t i = 0; i < states; ++i) state[i] = 1 / static_cast<double>(i + 1);
    bank.run(Target::baseline, drive, stride, sums);
    for (std::size_t k = 0; k < kSteps; ++k) {
      double sum = 0;
      for (std::size_t i = 0; i < states; ++i) {
        const double x = static_cast<double>(i + 1);
        sum += state[i];
        state[i] = state[i] / (1 + x) + 0.3 * x * drive[k * stride + i];
      }
      ASSERT_NEAR(sums[k], sum, 1e-13 * static_cast<double>(states * states)) << states << ' ' << k;
    }
    double end = 0;
    for (const double x : state) end += x;
    EXPECT_NEAR(bank.sum(), end, 1e-13 * static_cast<double>(states * states));
  }
}

TEST(StateBank, EveryTargetGivesTheSameBytes) {
  if (!supported(Target::avx2)) GTEST_SKIP() << "this processor has no AVX2 to compare with";
  for (const std::size_t states : {1, 4, 22}) {
    const auto drive = drive_for(states + 1);
    StateBank one = bank_of(states), other = bank_of(states);
    std::vector<double> baseline(kSteps), avx2(kSteps);
    one.run(Target::baseline, drive, states + 1, baseline);
    other.run(Target::avx2, drive, states + 1, avx2);
    EXPECT_EQ(baseline, avx2);
  }
}

TEST(StateBank, EmptySumsToZero) {
  StateBank bank;
  std::vector<double> sums(3, 1.0);
  bank.run(best_target(), std::vector<double>(3 + StateBank::kLanes), 1, sums);
  EXPECT_EQ(sums, std::vector<double>(3, 0.0));
}

}  // namespace
}  // namespace gyrobudget::noise::detail
