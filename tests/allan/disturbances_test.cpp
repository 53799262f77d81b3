// SPDX-License-Identifier: MIT
// Outliers, steps and slow departures: what is put in is found with its time and size, and noise alone has none.
#include "gyrobudget/allan/departure.h"
#include "gyrobudget/allan/outliers.h"
#include "gyrobudget/allan/steps.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::allan {
namespace {

using Mix = std::vector<noise::Process>;

constexpr std::int64_t kSamples = 20000;
constexpr int kRecords = 100;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// From angle noise to walk alone, and everything together.
const Mix kMixes[] = {{noise::Quantization{1}},
                      {noise::White{1}},
                      {noise::Flicker{1}},
                      {noise::RateRandomWalk{1}},
                      {noise::White{1}, noise::Flicker{0.1}, noise::RateRandomWalk{0.001}}};

std::vector<double> record(const Mix& mix, std::uint64_t seed) {
  return noise::generate_record(mix, kSamples, 1, {seed, 0});
}

// At a false alarm of 2 % a record, alarms among 500 records are at most binomial(500, 0.02): more than 22 has
// probability 4e-4. Thresholds are bounds (they sum over dependent tests), so usually there are fewer.
constexpr double kFalseAlarm = 0.02;
constexpr int kMostAlarms = 22;

template <typename Find>
int alarms(Find find) {
  int count = 0;
  for (const Mix& mix : kMixes) {
    for (std::uint64_t seed = 1; seed <= kRecords; ++seed) count += find(record(mix, seed), mix) ? 1 : 0;
  }
  return count;
}

TEST(Outliers, NoiseHasNone) {
  EXPECT_LE(alarms([](const auto& y, const Mix&) { return !find_outliers(y, {kFalseAlarm}).empty(); }), kMostAlarms);
}

TEST(Outliers, KnocksAreFoundWhereTheyAreAndWithTheirSize) {
  for (const Mix& mix : kMixes) {
    std::vector<double> y = record(mix, 7);
    const double before = y[5000];
    y[5000] += 30;
    y[0] -= 30;
    y[kSamples - 1] += 30;
    const auto outliers = find_outliers(y);
    ASSERT_EQ(outliers.size(), 3U);
    EXPECT_EQ(outliers[0].index, 0);
    EXPECT_EQ(outliers[1].index, 5000);
    EXPECT_EQ(outliers[2].index, kSamples - 1);
    EXPECT_LT(outliers[0].distance, 0);
    // The distance is from the median of 41 neighbours: within their scatter of where noise alone was.
    EXPECT_NEAR(outliers[1].distance, 30, 12);
    EXPECT_GT(outliers[1].sigmas, 8);
    y[5000] = before;
  }
}

TEST(Outliers, BurstsAndGapsAreNoCover) {
  std::vector<double> y = record({noise::White{1}}, 3);
  for (std::size_t k = 300; k < 310; ++k) y[k] += 25;  // ten samples in a row
  y[400] = y[402] = kNaN;
  y[401] += 25;
  const auto outliers = find_outliers(y);
  ASSERT_EQ(outliers.size(), 11U);
  EXPECT_EQ(outliers.front().index, 300);
  EXPECT_EQ(outliers[9].index, 309);
  EXPECT_EQ(outliers.back().index, 401);
}

TEST(Outliers, FivePercentOfContaminationIsFoundWhole) {
  std::vector<double> y = record({noise::White{1}}, 4);
  int put = 0;
  for (std::size_t k = 0; k < y.size(); k += 20, ++put) y[k] += put % 2 == 0 ? 40 : -40;
  const auto outliers = find_outliers(y);
  EXPECT_EQ(static_cast<int>(outliers.size()), put);
  for (const auto& outlier : outliers) EXPECT_EQ(outlier.index % 20, 0);
}

TEST(Outliers, CoarseCountsHaveAScale) {
  std::vector<double> y = record({noise::White{0.3}}, 5);
  for (double& value : y) value = std::round(value);  // nearly all 0, some +-1
  EXPECT_TRUE(find_outliers(y).empty());
  y[777] = 40;
  ASSERT_EQ(find_outliers(y).size(), 1U);
  EXPECT_EQ(find_outliers(y)[0].index, 777);
}

TEST(Outliers, EmptyEqualAndMissingRecordsHaveNone) {
  EXPECT_TRUE(find_outliers({}).empty());
  EXPECT_TRUE(find_outliers(std::vector<double>(1, 2.)).empty());
  EXPECT_TRUE(find_outliers(std::vector<double>(1000, 2.)).empty());
  EXPECT_TRUE(find_outliers(std::vector<double>(1000, kNaN)).empty());
  EXPECT_THROW((void)find_outliers({}, {0}), std::invalid_argument);
}

TEST(Steps, NoiseHasNone) {
  EXPECT_LE(alarms([](const auto& y, const Mix&) {
              return !find_steps(Series(y), {kFalseAlarm, 10}).empty();
            }),
            kMostAlarms);
}

TEST(Steps, AreFoundWhereTheyAreAndWithTheirSize) {
  std::vector<double> y = record({noise::White{1}}, 11);
  for (std::size_t k = 4321; k < y.size(); ++k) y[k] += 2;
  for (std::size_t k = 15000; k < y.size(); ++k) y[k] -= 3;
  const auto steps = find_steps(Series(y));
  ASSERT_EQ(steps.size(), 2U);
  // The middle of a step of 2 sigma is known to a few samples: its likelihood falls by (2/1)^2/2 each.
  EXPECT_NEAR(static_cast<double>(steps[0].index), 4321, 10);
  EXPECT_NEAR(static_cast<double>(steps[1].index), 15000, 10);
  // Means over `span` samples: sigma sqrt(2/span), five of them.
  EXPECT_NEAR(steps[0].size, 2, 5 * std::sqrt(2. / static_cast<double>(steps[0].span)));
  EXPECT_NEAR(steps[1].size, -3, 5 * std::sqrt(2. / static_cast<double>(steps[1].span)));
}

TEST(Steps, StandOutOfRandomWalkToo) {
  std::vector<double> y = record({noise::White{1}, noise::RateRandomWalk{0.01}}, 12);
  for (std::size_t k = 9000; k < y.size(); ++k) y[k] += 4;
  for (std::size_t k = 100; k < y.size(); k += 100) y[k] = kNaN;  // gaps are no obstacle
  const auto steps = find_steps(Series(y));
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_NEAR(static_cast<double>(steps[0].index), 9000, 10);
}

TEST(Steps, HaveASizeBesideLongGapsToo) {
  std::vector<double> y = record({noise::White{1}}, 13);
  for (std::size_t k = 9000; k < y.size(); ++k) y[k] += 20;
  for (std::size_t k = 9010; k < 9900; ++k) y[k] = kNaN;
  for (std::size_t k = 8100; k < 8995; ++k) y[k] = kNaN;
  for (const auto& step : find_steps(Series(y))) EXPECT_TRUE(std::isfinite(step.size)) << step.index;
}

TEST(Steps, ShortEqualAndMissingRecordsHaveNone) {
  EXPECT_TRUE(find_steps(Series({})).empty());
  EXPECT_TRUE(find_steps(Series(std::vector<double>(100, 1.))).empty());
  const std::vector<double> equal(5000, 1.), missing(5000, kNaN);
  EXPECT_TRUE(find_steps(Series(equal)).empty());
  EXPECT_TRUE(find_steps(Series(missing)).empty());
  EXPECT_THROW((void)find_steps(Series(equal), {1, 1}), std::invalid_argument);
}

TEST(Departures, NoiseHasNone) {
  EXPECT_LE(
      alarms([](const auto& y, const Mix& mix) { return find_departure(Series(y), mix, {kFalseAlarm}).has_value(); }),
      kMostAlarms);
}

TEST(Departures, AWarmUpIsFoundWithItsSizeAndTime) {
  const Mix mix{noise::White{1}, noise::RateRandomWalk{0.0003}};
  std::vector<double> y = record(mix, 21);
  constexpr double kSize = 0.5, kTime = 1250;  // 1/16 of the record
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += kSize * std::exp(-static_cast<double>(k) / kTime);
  const auto drift = find_departure(Series(y), mix);
  ASSERT_TRUE(drift.has_value());
  EXPECT_EQ(drift->kind, Departure::Kind::warm_up);
  // Shapes are tried a factor of two apart; the nearest is within one of them.
  EXPECT_GE(drift->time_constant_s, kTime / 2.1);
  EXPECT_LE(drift->time_constant_s, kTime * 2.1);
  EXPECT_NEAR(drift->size, kSize, 0.5 * kSize);
  EXPECT_LT(drift->p_value, 1e-4);
}

TEST(Departures, ATrendIsFoundAsOne) {
  const Mix mix{noise::White{1}, noise::Flicker{0.01}};
  std::vector<double> y = record(mix, 22);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] -= 0.3 * static_cast<double>(k) / kSamples;
  const auto drift = find_departure(Series(y), mix);
  ASSERT_TRUE(drift.has_value());
  EXPECT_EQ(drift->kind, Departure::Kind::trend);
  EXPECT_NEAR(drift->size, -0.3, 0.15);
}

TEST(Departures, AStepTooSmallForFindStepsIsFound) {
  // 0.6 sigma in 20 000 samples with a walk: 0.05 a second each second.
  const Mix mix{noise::White{1}, noise::RateRandomWalk{0.002}};
  std::vector<double> y = record(mix, 23);
  for (std::size_t k = 7000; k < y.size(); ++k) y[k] += 0.6;
  EXPECT_TRUE(find_steps(Series(y)).empty());
  const auto step = find_departure(Series(y), mix);
  ASSERT_TRUE(step.has_value());
  EXPECT_EQ(step->kind, Departure::Kind::step);
  EXPECT_NEAR(step->size, 0.6, 0.3);
  EXPECT_NEAR(static_cast<double>(step->index), 7000, kSamples / 128.);
}

TEST(Departures, ScaleOfTheNoiseDoesNotMatter) {
  const Mix mix{noise::White{1}, noise::RateRandomWalk{0.0003}}, far{noise::White{1e30}, noise::RateRandomWalk{3e26}};
  std::vector<double> y = record(mix, 21);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += 0.5 * std::exp(-static_cast<double>(k) / 1250);
  EXPECT_NEAR(find_departure(Series(y), mix)->p_value, find_departure(Series(y), far)->p_value, 1e-12);
}

TEST(Departures, NothingToLookAtIsNoDrift) {
  const std::vector<double> equal(5000, 1.);
  EXPECT_FALSE(find_departure(Series(equal), Mix{noise::White{1}}).has_value());
  EXPECT_FALSE(find_departure(Series(equal), Mix{}).has_value());
  EXPECT_FALSE(find_departure(Series(std::vector<double>(10, 1.)), Mix{noise::White{1}}).has_value());
  EXPECT_THROW((void)find_departure(Series(equal), Mix{}, {2}), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::allan
