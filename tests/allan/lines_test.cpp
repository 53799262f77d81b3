// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/lines.h"

#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace gyrobudget::allan {
namespace {

std::vector<double> record(const std::vector<noise::Process>& processes, std::int64_t samples, std::uint64_t seed) {
  return noise::generate_record(processes, samples, 0.01, {.seed = seed, .stream = 0});
}

TEST(Lines, FindsASinusoidWithItsFrequencyAndAmplitude) {
  const auto y = record({noise::White{0.1}, noise::Sinusoid{0.3, 12.3456, 1}}, 60000, 1);
  const auto lines = find_lines(y, 0.01);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NEAR(lines[0].frequency_hz, 12.3456, lines[0].resolution_hz);
  // The line's power has a relative standard deviation of about sqrt(2 sigma^2 / (n A^2)) per averaged segment, below
  // 2 %; what the window leaves outside the summed bins is below 5 %.
  EXPECT_NEAR(lines[0].amplitude / 0.3, 1, 0.1);
}

TEST(Lines, TellsTwoApart) {
  const auto y = record({noise::White{0.1}, noise::Sinusoid{0.3, 5, 1}, noise::Sinusoid{0.5, 31, 0}}, 60000, 2);
  const auto lines = find_lines(y, 0.01);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_NEAR(lines[0].frequency_hz, 31, lines[0].resolution_hz);
  EXPECT_NEAR(lines[1].frequency_hz, 5, lines[1].resolution_hz);
}

TEST(Lines, NoiseHasNone) {
  constexpr int kRecords = 150;
  constexpr double kFalseAlarm = 0.02;  // a record
  // More than 15 of 300 records at 2 % each: probability 1e-3 (binomial).
  constexpr int kMost = 15;
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    for (const auto& mix :
         {std::vector<noise::Process>{noise::White{1}},
          std::vector<noise::Process>{noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}}}) {
      alarms += find_lines(record(mix, 20000, seed), 0.01, {.false_alarm = kFalseAlarm, .most = 5}).empty() ? 0 : 1;
    }
  }
  EXPECT_LE(alarms, kMost);
}

TEST(Lines, RoundingOfAStrongSignalIsNone) {
  std::vector<double> y(20000);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] = k % 2 == 0 ? 1 : 0;
  EXPECT_TRUE(find_lines(y, 0.01).empty());
}

TEST(Lines, MissingSamplesShortRecordsAndMisuse) {
  auto y = record({noise::White{0.1}, noise::Sinusoid{0.3, 12.3456, 1}}, 60000, 1);
  for (std::size_t k = 0; k < y.size(); k += 97) y[k] = std::numeric_limits<double>::quiet_NaN();
  ASSERT_FALSE(find_lines(y, 0.01).empty());
  EXPECT_NEAR(find_lines(y, 0.01)[0].frequency_hz, 12.3456, 0.01);
  EXPECT_TRUE(find_lines(std::vector<double>(1000, 0.0), 0.01).empty());
  EXPECT_TRUE(find_lines(std::vector<double>(5000, 3.0), 0.01).empty());
  EXPECT_THROW((void)find_lines(y, 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
