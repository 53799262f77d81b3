// SPDX-License-Identifier: MIT
// What real logs hold beside noise, and what it does to the datasheet.
#include "gyrobudget/estimation/calibration/calibrate.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <tbb/parallel_for.h>

#include <array>
#include <atomic>
#include <cmath>

#include "records.h"

namespace gyrobudget::tests {
namespace {

using calibration::calibrate;
using fit::Status;
using noise::Term;

constexpr double kRate = 150;    // of the log [Hz]
constexpr double kWhite = 5e-5;  // N of the readings at their own rate [rad/sqrt(s)]
constexpr std::int64_t kRows = 24000;

std::vector<double> white(std::int64_t samples, double rate_hz, std::uint64_t seed) {
  const std::array<noise::Process, 1> processes{noise::White{kWhite}};
  return noise::generate_record(processes, samples, 1 / rate_hz, {.seed = seed, .stream = 0});
}

// Readings at `readings`/`rows` of the rate of the log, each standing until the next one is there.
allan::Record held_record(std::int64_t readings, std::int64_t rows, std::uint64_t seed) {
  std::vector<allan::Axis> axes;
  const double own_rate = kRate * double(readings) / double(rows);
  for (const char* name : {"gyro_x", "gyro_y", "gyro_z"}) {
    const auto x = white(kRows * readings / rows + 1, own_rate, seed * 3 + axes.size());
    std::vector<double> y(kRows);
    for (std::int64_t i = 0; i < kRows; ++i) y[std::size_t(i)] = x[std::size_t(i * readings / rows)];
    axes.push_back(gyro_axis(std::move(y), name));
  }
  return allan::make_record(std::move(axes), kRate);
}

// N of who sums the rows as they stand: raised by the mean of the squared holds over the square of their mean.
double raised_by(std::int64_t readings, std::int64_t rows) {
  double sum = 0, squares = 0;
  for (std::int64_t k = 0; k < readings; ++k) {
    const auto first = [&](std::int64_t reading) { return (reading * rows + readings - 1) / readings; };
    const auto hold = double(first(k + 1) - first(k));
    sum += hold, squares += hold * hold;
  }
  return std::sqrt(squares * double(readings)) / sum;
}

// Of 900 intervals each of 1 reading in 2 rows, 1 in 3, 2 in 3 and 5 in 7 there covered 94.9, 95.6, 95.3 and 94.7 %.
// Here are 150 each (50 records of three axes): binomial, five standard deviations of 1.8 %, around 93 to 97 %.
TEST(HeldReadings, TheIntervalOfNCovers) {
  constexpr int kRecords = 50;
  for (const auto& share : {std::pair{1, 2}, std::pair{1, 3}, std::pair{2, 3}, std::pair{5, 7}}) {
    const int readings = share.first, rows = share.second;
    const double truth = kWhite * raised_by(readings, rows);
    std::atomic<int> inside = 0, described = 0;
    tbb::parallel_for(1, kRecords + 1, [&](int seed) {
      const auto sheet = calibrate(held_record(readings, rows, std::uint64_t(seed)));
      for (const auto& axis : sheet.axes) {
        const auto& n = axis.fit[Term::white];
        inside += n.lower <= truth && truth <= n.upper;
        described += axis.has_answer() && axis.findings->held;
      }
    });
    EXPECT_GT(inside / (3.0 * kRecords), 0.93 - 5 * 0.018) << readings << " in " << rows;
    EXPECT_GT(described, 3 * kRecords * 93 / 100);  // 1 % of true models are not described
  }
}

TEST(HeldReadings, AreNamedWithTheRateOfTheSensor) {
  const auto sheet = calibrate(held_record(2, 3, 1));
  for (const auto& axis : sheet.axes) {
    ASSERT_TRUE(axis.findings->held);
    EXPECT_NEAR(axis.findings->held->share(), 1. / 3, 1e-3);
    EXPECT_NEAR(axis.findings->held->rate_hz, 100, 0.01);
    EXPECT_NEAR(axis.findings->held->raised, raised_by(2, 3), 0.01);
    EXPECT_FALSE(axis.findings->spoil());
    EXPECT_EQ(axis.points.front().tau_s, 1 / axis.findings->held->rate_hz);
  }
}

// White noise alone, with flicker and walk, walk above all, and written with four decimals. All searches together are
// to show something in some 2 of 1000 records; more than 3 of 120 has a probability of 1e-4.
TEST(NoiseAlone, ShowsNoFinding) {
  constexpr int kRecords = 120;
  std::atomic<int> found = 0;
  tbb::parallel_for(1, kRecords + 1, [&](int seed) {
    const double k = seed % 4 == 3 ? 2e-5 : 2e-7, b = seed % 4 == 0 ? 0 : 3e-6;
    const std::vector<noise::Process> processes{noise::White{kWhite}, noise::Flicker{b}, noise::RateRandomWalk{k}};
    auto y = noise::generate_record(processes, kRows, 1 / kRate, {.seed = std::uint64_t(seed) + 500, .stream = 0});
    if (seed % 4 == 2)
      for (double& v : y) v = std::round(v * 1e4) / 1e4;
    found += calibrate(allan::make_record({gyro_axis(std::move(y))}, kRate)).axes[0].findings->any();
  });
  EXPECT_LE(found, 3);
}

allan::Record rounded_record(double step, double mean) {
  const double sigma = kWhite * std::sqrt(kRate);
  auto y = white(kRows, kRate, 7);
  for (double& v : y) v = step * sigma * std::round(v / (step * sigma) + mean);
  return allan::make_record({gyro_axis(std::move(y))}, kRate);
}

TEST(Rounding, AboveTheNoiseLeavesNoAnswer) {
  for (const double mean : {0.0, 0.3, 0.5}) {
    const auto sheet = calibrate(rounded_record(3, mean));
    const auto& axis = sheet.axes[0];
    ASSERT_TRUE(axis.findings->rounding) << mean;
    EXPECT_TRUE(axis.findings->rounded_above_noise())
        << mean << " " << axis.findings->rounding->scatter << " " << axis.findings->rounding->step << " "
        << bool(axis.findings->held);
    EXPECT_TRUE(axis.findings->spoil());
    EXPECT_EQ(axis.fit[Term::white].status, Status::not_quotable);
    EXPECT_FALSE(axis.has_answer());
  }
}

// The error of rounding is white, of variance q^2/12. N is known to 0.46 % here; five of those.
TEST(Rounding, BelowTheNoiseAddsATwelfthOfTheSquaredStep) {
  for (const double step : {0.3, 1.0}) {
    const auto sheet = calibrate(rounded_record(step, 0.3));
    const auto& axis = sheet.axes[0];
    EXPECT_TRUE(axis.has_answer());
    EXPECT_FALSE(axis.findings->spoil());
    EXPECT_NEAR(axis.fit[Term::white].value / (kWhite * std::sqrt(1 + step * step / 12)), 1, 5 * 0.0046) << step;
  }
}

TEST(Motion, LeavesNothingDescribedUnlessItIsMasked) {
  auto y = white(kRows, kRate, 8);
  for (std::size_t i = 0; i < 450; ++i) y[9000 + i] += 0.5 * std::sin(std::numbers::pi * double(i) / 450);  // 3 s
  const auto record = allan::make_record({gyro_axis(std::move(y))}, kRate);
  const auto moved = calibrate(record);
  ASSERT_EQ(moved.axes[0].findings->motion.size(), 1U);
  EXPECT_EQ(moved.axes[0].fit.verdict, fit::Verdict::not_described);
  EXPECT_TRUE(moved.axes[0].findings->spoil());
  EXPECT_FALSE(moved.axes[0].has_answer());
  const auto masked = calibrate(record, {.mask = {.motion = true}});
  EXPECT_TRUE(masked.axes[0].has_answer());
  EXPECT_NEAR(masked.axes[0].fit[Term::white].value / kWhite, 1, 5 * 0.0046);
}

// A shake of 30 sigma at 5 Hz: its crests stand out like knocks, and are of the motion, with which they are masked.
TEST(Motion, HoldsTheSamplesThatStandOutOfIt) {
  auto y = white(kRows, kRate, 12);
  const double sigma = kWhite * std::sqrt(kRate);
  const auto shaken = static_cast<std::size_t>(kRate / 2);
  for (std::size_t i = 0; i < shaken; ++i)
    y[9000 + i] += 30 * sigma * std::sin(2 * std::numbers::pi * 5 * double(i) / kRate);
  const auto record = allan::make_record({gyro_axis(std::move(y))}, kRate);
  const auto masked = calibrate(record, {.mask = {.motion = true}});
  ASSERT_EQ(masked.axes[0].findings->motion.size(), 1U);
  EXPECT_TRUE(masked.axes[0].findings->outliers.empty());
  EXPECT_TRUE(masked.axes[0].has_answer());
  EXPECT_FALSE(masked.axes[0].is_spoilt());
  EXPECT_NEAR(masked.axes[0].fit[Term::white].value / kWhite, 1, 5 * 0.0046);
}

// A warm-up of 3 sigma looks like two steps of the mean as well; masked, nothing of it is left in curve and fit.
TEST(WarmUp, HoldsTheStepsThatItLookedLike) {
  constexpr std::size_t kLong = 100'000;
  auto y = white(kLong, kRate, 13);
  const double sigma = kWhite * std::sqrt(kRate);
  for (std::size_t i = 0; i < kLong; ++i) y[i] += 3 * sigma * std::exp(-20 * double(i) / double(kLong));
  const auto record = allan::make_record({gyro_axis(std::move(y))}, kRate);
  ASSERT_FALSE(calibrate(record).axes[0].findings->steps.empty());
  const auto masked = calibrate(record, {.mask = {.warm_up = true}});
  EXPECT_TRUE(masked.axes[0].findings->warm_up_masked);
  EXPECT_TRUE(masked.axes[0].findings->steps.empty());
  EXPECT_FALSE(masked.axes[0].is_spoilt());
}

TEST(SeveralSensors, LeaveNothingDescribed) {
  auto y = white(kRows, kRate, 9);
  for (std::size_t i = 1; i < y.size(); i += 2) y[i] *= 2;
  const auto sheet = calibrate(allan::make_record({gyro_axis(std::move(y))}, kRate));
  ASSERT_TRUE(sheet.axes[0].findings->turns);
  EXPECT_EQ(sheet.axes[0].fit.verdict, fit::Verdict::not_described);
  EXPECT_FALSE(sheet.axes[0].has_answer());
}

TEST(HeavyTail, IsToldFromKnocks) {
  auto y = white(kRows, kRate, 10);
  auto knocked = y;
  const double sigma = kWhite * std::sqrt(kRate);
  const auto where = white(kRows, kRate, 11);
  for (std::size_t i = 0; i < y.size(); ++i)
    if (std::abs(where[i]) > 1.96 * sigma) y[i] *= 20;  // 5 % of the samples
  for (std::size_t i = 100; i < 230; i += 10) knocked[i] += 30 * sigma;
  const auto tail = calibrate(allan::make_record({gyro_axis(std::move(y))}, kRate));
  EXPECT_TRUE(tail.axes[0].findings->has_heavy_tail());
  EXPECT_NEAR(tail.axes[0].findings->outlier_share(), 0.04, 0.01);  // those of 5 % that 20 sigma take beyond 4.5
  const auto knocks = calibrate(allan::make_record({gyro_axis(std::move(knocked))}, kRate));
  EXPECT_FALSE(knocks.axes[0].findings->has_heavy_tail());
  EXPECT_EQ(knocks.axes[0].findings->outliers.size(), 13U);
}

TEST(Saturation, SpoilsTheNumbersWhereItIsMoreThanAThousandth) {
  auto y = white(kRows, kRate, 12);
  const double sigma = kWhite * std::sqrt(kRate);
  for (double& v : y) v = std::min(v, 2 * sigma);
  const auto sheet = calibrate(allan::make_record({gyro_axis(std::move(y))}, kRate));
  EXPECT_EQ(sheet.axes[0].findings->saturation.size(), 1U);
  EXPECT_TRUE(sheet.axes[0].findings->saturation_spoils());
}

}  // namespace
}  // namespace gyrobudget::tests
