// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/calibration/temperature.h"

#include "gyrobudget/estimation/calibration/calibrate.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "../fit/sensors.h"
#include "records.h"

namespace gyrobudget::tests {
namespace {

using calibration::calibrate;
using calibration::SmoothTemperature;
using calibration::Temperature;
using calibration::TemperatureCoefficient;
using noise::Term;

constexpr std::int64_t kSamples = 36000;
constexpr double kReference = 30;

// A room that is heated beside a sensor that warms up: two exponentials and an oscillation of 20 minutes [degC], an
// hour at 10 Hz.
double temperature_at(double t) {
  return 35 - 12 * std::exp(-t / 400) - 6 * std::exp(-t / 1500) + 1.5 * std::sin(2 * std::numbers::pi * t / 1200);
}
double slope_at(double t) {
  return 12. / 400 * std::exp(-t / 400) + 6. / 1500 * std::exp(-t / 1500) +
         1.5 * 2 * std::numbers::pi / 1200 * std::cos(2 * std::numbers::pi * t / 1200);
}

struct Truth {
  double linear = 2e-5, quadratic = -5e-7, rate = 1e-3;  // [rad/s/K], /K^2, /(K/s)
  double bias = 1e-4;                                    // at kReference
};

std::vector<double> temperatures() {
  std::vector<double> list;
  for (std::int64_t i = 0; i < kSamples; ++i) list.push_back(temperature_at((double(i) + 0.5) / kRecordRate));
  return list;
}

allan::Record warm_record(std::uint64_t seed, const Truth& truth) {
  auto rate = mems_rates(kSamples, seed);
  for (std::size_t i = 0; i < rate.size(); ++i) {
    const double t = (static_cast<double>(i) + 0.5) / kRecordRate, above = temperature_at(t) - kReference;
    rate[i] += truth.bias + (truth.linear + truth.quadratic * above) * above + truth.rate * slope_at(t);
  }
  auto record = allan::make_record({gyro_axis(std::move(rate))}, kRecordRate);
  record.temperature = temperatures();
  return record;
}

bool covers(const TemperatureCoefficient& c, double truth) { return c.fitted && c.lower <= truth && truth <= c.upper; }

// The reference of a fit is the mean temperature: what the truth is there.
Truth at(double reference, const Truth& truth) {
  const double shift = reference - kReference;
  return {.linear = truth.linear + 2 * truth.quadratic * shift,
          .quadratic = truth.quadratic,
          .rate = truth.rate,
          .bias = truth.bias + (truth.linear + truth.quadratic * shift) * shift};
}

// Of 600 records the intervals of bias, linear, quadratic and rate covered 95.8, 96.2, 96.5 and 97.2 %. Of 200, 93 to
// 98 % may look like five standard deviations (1.8 %) less or more.
TEST(Temperature, IntervalsCoverBesideFlickerAndWalk) {
  constexpr int kRecords = 200;
  std::array<std::atomic<int>, 4> inside{};
  tbb::parallel_for(1, kRecords + 1, [&](int seed) {
    const auto sheet = calibrate(warm_record(std::uint64_t(seed), {}));
    const auto& found = sheet.axes[0].temperature;
    if (!found) return;
    const Truth truth = at(found->reference, {});
    inside[0] += covers(found->bias, truth.bias);
    inside[1] += covers(found->linear, truth.linear);
    inside[2] += covers(found->quadratic, truth.quadratic);
    inside[3] += covers(found->rate, truth.rate);
  });
  const std::array names{"bias", "linear", "quadratic", "rate"};
  for (std::size_t i = 0; i < 4; ++i) {
    const double covered = double(inside[i]) / kRecords;
    EXPECT_GT(covered, 0.93 - 5 * 0.018) << names[i];
  }
}

// What is left is the noise: N within five of its standard deviations (1/sqrt(2 n) and as much again for other terms),
// and the walk that temperature was taken for is gone.
TEST(Temperature, IsTakenOffAndTheNoiseIsLeft) {
  const auto sheet = calibrate(warm_record(5, {}));
  const auto& axis = sheet.axes[0];
  ASSERT_TRUE(axis.temperature && axis.temperature->removed);
  EXPECT_GT(axis.temperature->explained, 0.9);
  EXPECT_NEAR(axis.fit[Term::white].value / mems().n, 1, 10 / std::sqrt(2.0 * kSamples));
  const double before = axis.temperature->before[Term::rate_random_walk].value;
  EXPECT_GT(before, 3 * axis.fit[Term::rate_random_walk].value);
  EXPECT_FALSE(axis.findings->departure);
  EXPECT_EQ(axis.temperature->points.size(), 128U);
}

// At 0.1 % a record; more than 3 of 100 has a probability of 4e-6.
TEST(Temperature, NoiseAloneIsNone) {
  constexpr int kRecords = 100;
  std::atomic<int> removed = 0;
  tbb::parallel_for(1, kRecords + 1, [&](int seed) {
    const auto sheet = calibrate(warm_record(std::uint64_t(seed) + 1000, {0, 0, 0, 0}));
    removed += sheet.axes[0].temperature->removed;
  });
  EXPECT_LE(removed, 3);
}

TEST(Temperature, OfOneExponentialTellsNoRate) {
  auto record = warm_record(3, {});
  for (std::size_t i = 0; i < record.temperature.size(); ++i)
    record.temperature[i] = 30 - 10 * std::exp(-static_cast<double>(i) / kRecordRate / 600);
  const auto found = calibrate(record).axes[0].temperature;
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->linear.fitted);
  EXPECT_FALSE(found->rate.fitted);
}

// Ten readings a second of which one in 50 is a temperature, in steps of 0.05 K.
TEST(Temperature, SlowAndCoarseOnesDo) {
  auto record = warm_record(4, {});
  for (std::size_t i = 0; i < record.temperature.size(); ++i) {
    const double rounded = std::round(record.temperature[i] * 20) / 20;
    record.temperature[i] = i % 50 == 7 ? rounded : std::numeric_limits<double>::quiet_NaN();
  }
  const auto found = calibrate(record).axes[0].temperature;
  ASSERT_TRUE(found && found->removed);
  const Truth truth = at(found->reference, {});
  EXPECT_NEAR(found->linear.value, truth.linear, 2 * (found->linear.upper - found->linear.lower));
  EXPECT_NEAR(found->rate.value, truth.rate, 2 * (found->rate.upper - found->rate.lower));
}

TEST(Temperature, ThatStandsStillOrIsOfAnotherLengthIsRefused) {
  auto record = warm_record(1, {});
  record.temperature.assign(record.temperature.size(), 25);
  EXPECT_FALSE(calibrate(record).axes[0].temperature);
  record.temperature.pop_back();
  EXPECT_THROW((void)calibrate(record), std::invalid_argument);
  const std::vector<double> few(1000, 0.0);
  EXPECT_THROW((void)calibration::fit_temperature(few, SmoothTemperature(few, 1), 1, {}), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::tests
