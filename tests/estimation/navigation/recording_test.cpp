// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/recording.h"

#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace gyrobudget::navigation {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-12;

// A rate of 3 + 2 t rad/s about x and a force of 5 m/s^2 along z, as samples at these times [ms].
double angle(double t) { return 3 * t + t * t; }

ImuSamples increments(const std::vector<std::int64_t>& ms, std::int64_t first_interval_ms) {
  ImuSamples samples;
  for (std::size_t k = 0; k < ms.size(); ++k) {
    const std::int64_t before = k == 0 ? ms[0] - first_interval_ms : ms[k - 1];
    const double a = static_cast<double>(before) * 1e-3, b = static_cast<double>(ms[k]) * 1e-3;
    samples.stamps.push_back(ms[k] * kMillisecond);
    samples.values.push_back({.angle = {angle(b) - angle(a), 0, 0}, .velocity = {0, 0, 5 * (b - a)}});
  }
  return samples;
}

Vector3d sum_of_angles(const ImuLog& log) {
  return std::accumulate(log.increments.begin(), log.increments.end(), Vector3d(0, 0, 0),
                         [](const Vector3d& sum, const auto& i) { return Vector3d(sum + earth::vector(i.angle)); });
}

TEST(ImuLog, UnevenIncrementsKeepTheirOwnIntervals) {
  const ImuLog log = imu_log(increments({10, 20, 32, 40, 50}, 10));
  ASSERT_EQ(log.stamps.size(), log.increments.size() + 1);
  EXPECT_EQ(log.stamps.front(), 0);
  EXPECT_EQ(log.stamps[3], 32 * kMillisecond);
  EXPECT_EQ(log.gaps, 0);
  EXPECT_NEAR(sum_of_angles(log).x(), angle(0.05), kRounding);
  EXPECT_NEAR(log.increments[2].velocity[2], 5 * 0.012, kRounding);
  EXPECT_DOUBLE_EQ(log.typical_interval, 0.01);
}

TEST(ImuLog, AGapIsBridgedByAStraightRate) {
  // 40 to 80 ms are lost: the sample at 90 ms covers the 10 ms before it.
  ImuSamples samples = increments({10, 20, 30, 40, 90, 100}, 10);
  samples.values[4] = {.angle = {angle(0.09) - angle(0.08), 0, 0}, .velocity = {0, 0, 0.05}};
  const ImuLog log = imu_log(samples);
  EXPECT_EQ(log.gaps, 1);
  EXPECT_NEAR(log.longest_gap, 0.04, kRounding);
  EXPECT_NEAR(log.bridged_seconds, 0.04, kRounding);
  ASSERT_EQ(log.increments.size(), 7U);
  EXPECT_TRUE(log.bridged[4]);
  EXPECT_NEAR(sum_of_angles(log).x(), angle(0.1), kRounding);  // exact for a rate that is straight
}

TEST(ImuLog, SamplesWithoutANumberAreBridgedTooAndEndsAreCut) {
  ImuSamples samples = increments({10, 20, 30, 40, 50, 60}, 10);
  samples.values[0].angle[1] = samples.values[2].velocity[2] = samples.values[5].angle[0] = kNaN;
  const ImuLog log = imu_log(samples);
  EXPECT_EQ(log.stamps.front(), 10 * kMillisecond);
  EXPECT_EQ(log.stamps.back(), 50 * kMillisecond);
  EXPECT_EQ(log.gaps, 1);
  EXPECT_NEAR(sum_of_angles(log).x(), angle(0.05) - angle(0.01), kRounding);
}

TEST(ImuLog, ASampleMayBeAtTheStartOfItsInterval) {
  ImuSamples samples = increments({10, 20, 30}, 10);
  samples.stamp = StampAt::start;
  const ImuLog log = imu_log(samples);
  EXPECT_EQ(log.stamps.front(), 10 * kMillisecond);
  EXPECT_EQ(log.stamps.back(), 40 * kMillisecond);
}

TEST(ImuLog, RatesAreMeansOrInstants) {
  ImuSamples samples;
  for (int k = 0; k <= 4; ++k) {
    samples.stamps.push_back(k * 10 * kMillisecond);
    samples.values.push_back({.angle = {3 + 2 * 0.01 * k, 0, 0}, .velocity = {0, 0, 5}});  // the rate at the stamp
  }
  samples.gyro = samples.accelerometer = SampleKind::mean;
  EXPECT_NEAR(sum_of_angles(imu_log(samples)).x(), 5 * 0.03 + 0.01 * 0.2, kRounding);
  samples.gyro = samples.accelerometer = SampleKind::instant;
  const ImuLog log = imu_log(samples);
  EXPECT_EQ(log.increments.size(), 4U);
  EXPECT_NEAR(sum_of_angles(log).x(), angle(0.04), kRounding);
}

// A temperature that rises by 0.1 K/s, whose means lie on the same line: what the sensor file says is taken off to
// rounding, away from the ends, where means of 10 s have half of their time.
TEST(ImuLog, BiasOverTemperatureIsTakenOff) {
  noise::SensorModel sensor;
  sensor.gyro.temperature = {20, noise::PerAxis(1e-4, -2e-4, 0), 0.0, noise::PerAxis(0, 0, 3e-3)};
  navigation::ImuSamples samples;
  samples.gyro = samples.accelerometer = navigation::SampleKind::mean;
  for (int k = 0; k < 1000; ++k) {
    const double degrees = 20 + 0.01 * k;
    samples.stamps.push_back(std::int64_t{100'000'000} * k);
    samples.temperature.push_back(degrees);
    samples.values.push_back({.angle = {1e-4 * (degrees - 20), -2e-4 * (degrees - 20), 3e-4}});
  }
  auto other = samples;
  ASSERT_TRUE(navigation::take_off_temperature(samples, sensor));
  constexpr double kZero = 1e-15;
  for (std::size_t k = 100; k < 900; ++k) {
    for (const double y : samples.values[k].angle) EXPECT_NEAR(y, 0, kZero) << k;
  }
  EXPECT_FALSE(navigation::take_off_temperature(other, noise::SensorModel()));
  other.temperature.pop_back();
  EXPECT_THROW((void)navigation::take_off_temperature(other, sensor), navigation::RecordingError);
}

TEST(ImuLog, RefusesWhatIsNoLog) {
  EXPECT_THROW((void)imu_log(increments({10}, 10)), std::invalid_argument);
  EXPECT_THROW((void)imu_log(increments({10, 10, 20}, 10)), std::invalid_argument);
  EXPECT_THROW((void)imu_log(increments({10, 5, 20}, 10)), std::invalid_argument);
  ImuSamples none = increments({10, 20, 30}, 10);
  for (auto& value : none.values) value.angle[0] = kNaN;
  EXPECT_THROW((void)imu_log(none), std::invalid_argument);
  ImuSamples mixed = increments({10, 20, 30}, 10);
  mixed.gyro = SampleKind::instant;
  EXPECT_THROW((void)imu_log(mixed), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::navigation
