// SPDX-License-Identifier: MIT
// What logs of real sensors hold beside noise: what is put in is found with its size, and noise alone has none.
#include "gyrobudget/allan/humps.h"
#include "gyrobudget/allan/motion.h"
#include "gyrobudget/allan/repeats.h"
#include "gyrobudget/allan/rounding.h"
#include "gyrobudget/allan/saturation.h"
#include "gyrobudget/allan/turns.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::allan {
namespace {

using Mix = std::vector<noise::Process>;
using Columns = std::vector<std::span<const double>>;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const Mix kMixes[] = {{noise::White{1}},
                      {noise::Flicker{1}},
                      {noise::RateRandomWalk{1}},
                      {noise::White{1}, noise::Flicker{0.1}, noise::RateRandomWalk{0.001}}};

// One sample a second, so that white noise of N = 1 has a standard deviation of 1.
std::vector<double> record(const Mix& mix, std::int64_t samples, std::uint64_t seed) {
  return noise::generate_record(mix, samples, 1, {seed, 0});
}

std::vector<double> white(std::int64_t samples, std::uint64_t seed) { return record({noise::White{1}}, samples, seed); }

std::vector<double> rounded(std::vector<double> y, double step) {
  for (double& v : y) v = step * std::round(v / step);
  return y;
}

// First order, settled: y follows x with the part `forget` of what it lacks.
std::vector<double> filtered(const std::vector<double>& x, double forget) {
  std::vector<double> y(x.size());
  double state = 0;
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = state += forget * (x[i] - state);
  return y;
}

// Reading floor(i * readings / rows) stands in row i.
std::vector<double> held(const std::vector<double>& x, std::int64_t readings, std::int64_t rows) {
  std::vector<double> y;
  for (std::size_t i = 0; i * std::size_t(readings) / std::size_t(rows) < x.size(); ++i)
    y.push_back(x[i * std::size_t(readings) / std::size_t(rows)]);
  return y;
}

// --- Repeats -------------------------------------------------------------------------------------------------------

TEST(Repeats, AreFoundWithTheRateOfTheSensor) {
  const auto x = white(9000, 1), y = white(9000, 2), z = white(9000, 3);
  for (const auto& [readings, rows] : {std::pair{1, 2}, std::pair{1, 3}, std::pair{2, 3}, std::pair{7, 10}}) {
    const auto a = held(x, readings, rows), b = held(y, readings, rows), c = held(z, readings, rows);
    const auto found = find_repeats(Columns{a, b, c});
    ASSERT_TRUE(found) << readings << "/" << rows;
    EXPECT_NEAR(found->share(), 1 - double(readings) / rows, 1e-3);
    EXPECT_NEAR(found->rows_each, double(rows) / readings, 1e-3);
    const auto back = readings_of(Columns{a, b, c});
    ASSERT_EQ(back.rows.size(), x.size());
    EXPECT_EQ(back.of(a), x);
    EXPECT_EQ(back.of(c), z);
  }
}

TEST(Repeats, NoiseHasNoneRoundedOrBehindAFilter) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    for (const double step : {0.0, 0.1, 0.3, 1.0}) {
      for (const double forget : {1.0, 0.3, 0.03}) {
        auto y = filtered(white(20000, seed), forget);
        if (step > 0) y = rounded(std::move(y), step * std::sqrt(forget / (2 - forget)));  // in sigma of the output
        alarms += find_repeats(Columns{y}) ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(alarms, 0);
}

// A spike in silence, and noise that seldom reaches the next step, are not slow sensors.
TEST(Repeats, SilenceIsNone) {
  std::vector<double> spike(4000);
  spike[2000] = 1;
  EXPECT_FALSE(find_repeats(Columns{spike}));
  EXPECT_FALSE(find_repeats(Columns{rounded(white(20000, 1), 5.5)}));
}

TEST(Repeats, AreFoundBesideRoundingInAnotherAxis) {
  const auto fine = held(white(9000, 1), 2, 3), coarse = rounded(held(white(9000, 2), 2, 3), 1);
  const std::vector<double> dead(fine.size(), 0.5);
  // Three coarse axes do as well: a third of the rows and 0.28^3 of the others repeat in all.
  const auto y = rounded(held(white(9000, 3), 2, 3), 1), z = rounded(held(white(9000, 4), 2, 3), 1);
  const auto coarse_ones = find_repeats(Columns{coarse, y, z});
  ASSERT_TRUE(coarse_ones);
  EXPECT_NEAR(coarse_ones->share(), 1. / 3 + 2. / 3 * 0.022, 0.02);
  const auto found = find_repeats(Columns{coarse, fine, dead});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->share(), 1. / 3, 1e-3);
}

TEST(Repeats, GapsAndFrozenReadingsKeepTheirLength) {
  auto y = held(white(3000, 4), 1, 2);
  std::fill(y.begin() + 1000, y.begin() + 1100, kNaN);     // 50 readings
  std::fill(y.begin() + 3000, y.begin() + 3080, y[3000]);  // frozen for 40
  const auto back = readings_of(Columns{y});
  EXPECT_NEAR(static_cast<double>(back.rows.size()), 3000, 2);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(back.rows, -1)), 50 + 39, 2);
  EXPECT_EQ(back.rows_each, 2);
}

// White readings in holds of 1 and 2: V/H^2 = 0.25/2.25 of their variance. The power is known to sqrt(2/blocks).
TEST(Repeats, UnevenHoldsAddWhatTheirVarianceSays) {
  const auto x = white(80000, 5);
  const auto y = held(x, 2, 3);
  const auto back = readings_of(Columns{y});
  EXPECT_NEAR(added_by_uneven_holds(back.of(y), back.holds) * 9, 1, 5 * std::sqrt(2. / 10000));
  const auto even = held(x, 1, 3);
  const auto same = readings_of(Columns{even});
  EXPECT_NEAR(added_by_uneven_holds(same.of(even), same.holds), 0, 1e-4);  // the first and the last may be cut
}

// --- Rounding ------------------------------------------------------------------------------------------------------

TEST(Rounding, FindsTheStepAndHoldsItAgainstTheNoise) {
  for (const double step : {0.3, 1.0, 1.5, 2.5, 3.0, 5.0}) {
    for (const double mean : {0.0, 0.17, 0.35, 0.5}) {
      auto y = white(20000, 1);
      for (double& v : y) v += mean * step;
      const auto found = find_rounding(rounded(std::move(y), step));
      ASSERT_TRUE(found) << step << " " << mean;
      EXPECT_NEAR(found->step / step, 1, 1e-9);
      EXPECT_EQ(found->is_above_noise(), step > 2) << step << " " << mean << " " << found->step / found->scatter;
      if (step > 2) {
        EXPECT_FALSE(found->is_dithered_by_wander());
      }
    }
  }
  EXPECT_FALSE(find_rounding(rounded(white(20000, 1), 0.01)));
}

TEST(Rounding, IsNotSeenWhereThereIsNone) {
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    for (const std::int64_t samples : {64, 512, 4096}) EXPECT_FALSE(find_rounding(white(samples, seed))) << seed;
  }
  EXPECT_FALSE(find_rounding(std::vector<double>(100, 0.3)));
}

TEST(Rounding, OfAnAngleIsQuantizationWhichTheModelHas) {
  auto angle = white(20001, 3);
  double sum = 0;
  for (double& v : angle) v = 3 * std::round((sum += v) / 3);
  std::vector<double> y;
  for (std::size_t i = 1; i < angle.size(); ++i) y.push_back(angle[i] - angle[i - 1]);
  const auto found = find_rounding(y);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->of_angle);
  EXPECT_FALSE(found->is_above_noise());
}

TEST(Rounding, AWanderingMeanDithersIt) {
  auto y = record({noise::White{1}, noise::RateRandomWalk{0.3}}, 20000, 2);
  const auto found = find_rounding(rounded(std::move(y), 4));
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_above_noise());
  EXPECT_TRUE(found->is_dithered_by_wander());
}

// --- Saturation ----------------------------------------------------------------------------------------------------

TEST(Saturation, IsFoundAtEitherEnd) {
  auto y = white(20000, 1);
  for (double& v : y) v = std::clamp(v, -2.5, 2.0);
  const auto ends = find_saturation(y);
  ASSERT_EQ(ends.size(), 2U);
  EXPECT_EQ(ends[0].value, -2.5);
  EXPECT_EQ(ends[1].value, 2.0);
  // A share of 2.3 % beyond 2 sigma, binomial; five of its standard deviations.
  EXPECT_NEAR(static_cast<double>(ends[1].count), 455, 5 * 21);
  EXPECT_EQ(y[static_cast<std::size_t>(ends[1].first)], 2.0);
  EXPECT_GE(ends[1].longest, 1);
}

TEST(Saturation, NoiseAndSinesHaveNone) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    for (const double step : {0.0, 0.1, 0.3, 1.0, 3.0}) {
      const auto y = step > 0 ? rounded(white(20000, seed), step) : white(20000, seed);
      alarms += find_saturation(y).empty() ? 0 : 1;
    }
  }
  EXPECT_EQ(alarms, 0);
  std::vector<double> sine(20000);
  for (std::size_t i = 0; i < sine.size(); ++i) sine[i] = std::round(30 * std::sin(0.01234 * static_cast<double>(i)));
  EXPECT_TRUE(find_saturation(sine).empty());
}

// --- Motion --------------------------------------------------------------------------------------------------------

TEST(Motion, TurnsAreFoundWithTheirAngle) {
  auto y = white(20000, 1);
  for (std::size_t i = 0; i < 300; ++i)
    y[7000 + i] += 100 * std::sin(std::numbers::pi * static_cast<double>(i) / 300);  // half a sine
  const auto found = find_motion(y, 1);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(static_cast<double>(found[0].first), 7000, 64);
  EXPECT_NEAR(static_cast<double>(found[0].count), 300, 128);
  EXPECT_NEAR(found[0].peak, 100, 5);  // and the noise beside it
  EXPECT_NEAR(found[0].turned / (100 * 300 * 2 / std::numbers::pi), 1, 0.02);
}

TEST(Motion, NoiseAndStepsAreNone) {
  int alarms = 0;
  for (const Mix& mix : kMixes) {
    for (std::uint64_t seed = 1; seed <= 150; ++seed)
      alarms += find_motion(record(mix, 20000, seed), 1).empty() ? 0 : 1;
  }
  EXPECT_EQ(alarms, 0);
  auto y = white(20000, 1);
  for (std::size_t i = 9990; i < y.size(); ++i) y[i] += 100;
  EXPECT_TRUE(find_motion(y, 1).empty());
  EXPECT_THROW((void)find_motion(y, 0), std::invalid_argument);
}

// --- Several sensors by turns --------------------------------------------------------------------------------------

TEST(Turns, AreFoundByLevelOrByNoise) {
  for (const std::size_t sensors : {2U, 3U, 4U}) {
    auto levels = white(20000, 1), noises = white(20000, 2);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (i % sensors == 1) levels[i] += 4, noises[i] *= 2.5;
    }
    const auto by_level = find_turns(levels), by_noise = find_turns(noises);
    ASSERT_TRUE(by_level && by_noise) << sensors;
    EXPECT_EQ(by_level->sensors, static_cast<std::int64_t>(sensors));
    EXPECT_EQ(by_noise->sensors, static_cast<std::int64_t>(sensors));
    EXPECT_NEAR(by_level->levels, 4, 0.5);  // two standard deviations of a mean of 24
    // The extremes of windows of 24 rows lie a quarter further apart than what they are extremes of.
    EXPECT_NEAR(by_noise->noises, 2.5, 0.25 * 2.5);
  }
}

TEST(Turns, OneSensorIsOne) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    for (const Mix& mix : kMixes) alarms += find_turns(record(mix, 4096, seed)) ? 1 : 0;
    alarms += find_turns(filtered(white(4096, seed), 0.1)) ? 1 : 0;
    alarms += find_turns(held(white(4096, seed), 2, 3)) ? 1 : 0;
    alarms += find_turns(record({noise::White{1}, noise::Sinusoid{5, 0.2487, 0}}, 4096, seed)) ? 1 : 0;
  }
  EXPECT_EQ(alarms, 0);
}

// --- Humps ---------------------------------------------------------------------------------------------------------

TEST(Humps, AResonanceIsOneHump) {
  // Second order, at 0.05 cycles a sample, 10 times as high as beside it.
  const auto x = white(65536, 1), e = white(65536, 2);
  std::vector<double> y(x.size());
  constexpr double kRadius = 0.97;
  const double cosine = std::cos(2 * std::numbers::pi * 0.05);
  for (std::size_t i = 2; i < y.size(); ++i)
    y[i] = 2 * kRadius * cosine * y[i - 1] - kRadius * kRadius * y[i - 2] + 0.04 * x[i];
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += e[i];
  const auto humps = find_humps(y, 1);
  ASSERT_EQ(humps.size(), 1U);
  EXPECT_NEAR(humps[0].frequency_hz, 0.05, 0.006);  // a band of 1/8 octave
  EXPECT_LT(humps[0].low_hz, 0.05);
  EXPECT_GT(humps[0].high_hz, 0.05);
}

TEST(Humps, NoiseAndLinesHaveNone) {
  int alarms = 0;
  for (const Mix& mix : kMixes) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) alarms += find_humps(record(mix, 32768, seed), 1).empty() ? 0 : 1;
  }
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
    alarms += find_humps(filtered(white(32768, seed), 0.1), 1).empty() ? 0 : 1;
  EXPECT_EQ(alarms, 0);
  EXPECT_TRUE(find_humps(record({noise::White{1}, noise::Sinusoid{2, 0.1234, 0}}, 65536, 1), 1).empty());
  EXPECT_THROW((void)find_humps(white(16384, 1), 0), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
