// SPDX-License-Identifier: MIT
#include "gyrobudget/app/sensor_file/kalibr.h"

#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using noise::SensorModel;
using sensor_file::kalibr_yaml;
using sensor_file::KalibrOptions;

constexpr double kDegree = std::numbers::pi / 180, kHour = 3600;

class Kalibr : public TemporaryFolder {
 protected:
  [[nodiscard]] SensorModel read(const std::string& text) const {
    return sensor_file::read_sensor(file("imu.yaml", text));
  }
};

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

SensorModel mems() {
  SensorModel model;
  model.gyro.white = 1.2345678901234567e-4;
  model.gyro.rate_random_walk = 3e-7;
  model.gyro.bias_instability = 0.7 * kDegree / kHour;
  return model;
}

TEST_F(Kalibr, IsWrittenAsItIsRead) {
  SensorModel model = mems();
  const std::string gyro_only = kalibr_yaml(model, {.update_rate_hz = 200});
  EXPECT_TRUE(has(gyro_only, "update_rate: 200  # [Hz]")) << gyro_only;
  EXPECT_TRUE(has(gyro_only, "# gyroscope_random_walk: rate random walk as it is,")) << gyro_only;
  EXPECT_TRUE(
      has(gyro_only, "# gyroscope bias instability: 0.7000 deg/h has no place in this form; over 100 s it moves"))
      << gyro_only;
  EXPECT_TRUE(has(gyro_only, "# accelerometer_noise_density and accelerometer_random_walk are not known"));
  EXPECT_EQ(read(gyro_only).gyro.white, model.gyro.white);
  EXPECT_EQ(read(gyro_only).gyro.rate_random_walk, model.gyro.rate_random_walk);
  EXPECT_FALSE(read(gyro_only).accelerometer);
  model.accelerometer = noise::ErrorModel{.white = 1e-3, .rate_random_walk = 1e-5};
  EXPECT_EQ(read(kalibr_yaml(model, {.update_rate_hz = 100})).accelerometer.value().white, noise::PerAxis(1e-3));
  const auto refused = [&](const KalibrOptions& options) {
    return message_of<std::invalid_argument>([&] { (void)kalibr_yaml(mems(), options); });
  };
  EXPECT_TRUE(has(refused({.update_rate_hz = 0}), "update_rate_hz is 0 Hz"));
  EXPECT_TRUE(has(refused({.update_rate_hz = 1, .horizon_s = -1}), "horizon_s is -1 s"));
}

// The walk of flicker has its Allan deviation at the horizon: K sqrt(T/3) = sqrt(2 ln 2/pi) B.
TEST_F(Kalibr, AWalkThatIsNotResolvedIsThatOfBiasInstability) {
  SensorModel model = mems();
  SensorModel limits;
  limits.gyro.rate_random_walk = 4e-7;  // so K, whatever its value, is not resolved
  for (const double horizon : {30.0, 1000.0}) {
    const std::string text = kalibr_yaml(model, {.update_rate_hz = 200, .horizon_s = horizon, .limits = limits});
    const double walk = read(text).gyro.rate_random_walk[0];
    EXPECT_NEAR(walk * std::sqrt(horizon / 3) / (0.6643 * model.gyro.bias_instability[0]), 1, 1e-4);
    EXPECT_TRUE(has(text, "no rate random walk is resolved (it is at most")) << text;
    EXPECT_TRUE(has(text, "stands for the bias instability of 0.7000 deg/h")) << text;
    EXPECT_FALSE(has(text, "bias instability: 0.7000 deg/h has no place")) << text;
  }
  // Nor is it 0 where none was fitted, or the fit is 0.
  model.gyro.rate_random_walk = 0;
  EXPECT_GT(read(kalibr_yaml(model, {.update_rate_hz = 200})).gyro.rate_random_walk[0], 0);
}

TEST_F(Kalibr, WhereNeitherIsResolvedTheLimitStands) {
  SensorModel model = mems(), limits;
  limits.gyro.rate_random_walk = 4e-7;
  limits.gyro.bias_instability = 1e-5;
  limits.gyro.white = 2e-4;
  const std::string text = kalibr_yaml(model, {.update_rate_hz = 200, .limits = limits});
  EXPECT_EQ(read(text).gyro.rate_random_walk, limits.gyro.rate_random_walk);
  EXPECT_EQ(read(text).gyro.white, limits.gyro.white);
  EXPECT_TRUE(
      has(text, "# gyroscope_random_walk: the record does not resolve rate random walk: this is its 95 % limit"))
      << text;
}

TEST_F(Kalibr, WhatIsNotKnownIsAskedForAndNotZero) {
  SensorModel model;
  model.gyro.white = 1e-4;
  const std::string text = kalibr_yaml(model, {.update_rate_hz = 200, .comment = "WARNING: a\nb"});
  EXPECT_TRUE(text.starts_with("# WARNING: a\n# b\n")) << text;
  EXPECT_TRUE(has(text, "# gyroscope_random_walk is not known, and 0 would be wrong: fill it in\n")) << text;
  EXPECT_FALSE(has(text, "\ngyroscope_random_walk:")) << text;
}

// One number for three axes: the largest, and which it is.
TEST_F(Kalibr, OfAxesThatDifferTheWorstIsWritten) {
  SensorModel model = mems();
  model.gyro.white = {1e-4, 3e-4, 2e-4};
  model.gyro.rate_random_walk = {0, 1e-9, 5e-7};
  const std::string text = kalibr_yaml(model, {.update_rate_hz = 200, .horizon_s = 1000});
  EXPECT_EQ(read(text).gyro.white, noise::PerAxis(3e-4));
  EXPECT_TRUE(has(text, "the largest of the three axes, that of y")) << text;
  EXPECT_EQ(read(text).gyro.rate_random_walk, noise::PerAxis(5e-7));
  EXPECT_TRUE(has(text, "the largest of the three axes, that of z")) << text;
}

}  // namespace
}  // namespace gyrobudget::app_tests
