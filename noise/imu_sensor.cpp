// SPDX-License-Identifier: MIT
#include "imu_sensor.h"

#include "gyrobudget/noise/detail/check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::noise {

using detail::require;
using detail::require_interval;

namespace {

constexpr int kAxisBits = 46;  // of a stream, above those that users have here
constexpr double kReferenceTemperature = 25;

void require_finite(const ImuSensor& s) {
  const std::initializer_list<std::pair<const char*, const ImuSensor::Vector*>> vectors = {
      {"constant bias", &s.constant_bias},
      {"axes misalignment", &s.axes_misalignment[0]},
      {"axes misalignment", &s.axes_misalignment[1]},
      {"axes misalignment", &s.axes_misalignment[2]},
      {"noise density", &s.noise_density},
      {"bias instability", &s.bias_instability},
      {"random walk", &s.random_walk},
      {"temperature bias", &s.temperature_bias},
      {"temperature scale factor", &s.temperature_scale_factor},
      {"acceleration bias", &s.acceleration_bias}};
  for (const auto& [what, values] : vectors) {
    for (const double v : *values) require(std::isfinite(v), what, v, "finite");
  }
  require(s.measurement_range >= 0, "measurement range", s.measurement_range, "zero or positive");
  require(s.resolution >= 0 && std::isfinite(s.resolution), "resolution", s.resolution, "zero or positive");
}

}  // namespace

FilterCoefficients fractal_coefficients(std::int64_t taps, double alpha) {
  require(alpha >= 0 && alpha < 2, "alpha of 1/f^alpha noise", alpha, "from 0 to below 2");
  return {{1}, fractional_difference(alpha / 2, taps)};
}

Model ImuSensor::model(int axis, double dt) const {
  require(axis >= 0 && axis < 3, "axis", axis, "0, 1 or 2");
  require_interval(dt);
  const auto i = static_cast<std::size_t>(axis);
  // Per sample NoiseDensity sqrt(BW) and RandomWalk/sqrt(BW), where N/sqrt(dt) and K sqrt(dt) are IEEE's.
  const double ratio = noise_type == NoiseType::double_sided ? std::sqrt(0.5) : 1;  // sqrt(BW dt)
  const auto& [numerator, denominator] = bias_instability_coefficients;
  return {{White{noise_density[i] * ratio}, RateRandomWalk{random_walk[i] / ratio}},
          {{bias_instability[i], numerator, denominator}}};
}

ImuSensor::Vector read(const ImuSensor& sensor, const ImuInput& input, const ImuSensor::Vector& noise) {
  const double warmth = input.temperature - kReferenceTemperature;
  ImuSensor::Vector reading{};
  for (std::size_t i = 0; i < reading.size(); ++i) {
    double z = sensor.constant_bias[i] + noise[i] + warmth * sensor.temperature_bias[i] +
               sensor.acceleration_bias[i] * input.acceleration[i];
    for (std::size_t j = 0; j < reading.size(); ++j) z += sensor.axes_misalignment[i][j] / 100 * input.signal[j];
    z *= 1 + warmth / 100 * sensor.temperature_scale_factor[i];
    z = std::clamp(z, -sensor.measurement_range, sensor.measurement_range);
    reading[i] = sensor.resolution > 0 ? std::round(z / sensor.resolution) * sensor.resolution : z;
  }
  return reading;
}

ImuGenerator::ImuGenerator(ImuSensor sensor, double dt, StreamKey key) : sensor_(std::move(sensor)) {
  require_interval(dt);
  require_finite(sensor_);
  if (key.stream >> kAxisBits != 0) {
    throw std::invalid_argument(fmt::format("stream {} must be below 2^{}", key.stream, kAxisBits));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Model model = sensor_.model(axis, dt);
    const StreamKey own{key.seed, key.stream | static_cast<std::uint64_t>(axis) << kAxisBits};
    axes_.emplace_back(model.processes, model.filters, dt, Generator::Options{.key = own});
  }
}

void ImuGenerator::next(std::span<const ImuInput> inputs, std::span<ImuSensor::Vector> readings) {
  if (inputs.size() != readings.size()) {
    throw std::invalid_argument(fmt::format("{} inputs for {} readings", inputs.size(), readings.size()));
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    noise_[i].resize(inputs.size());
    axes_[i].next(noise_[i]);
  }
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    readings[k] = read(sensor_, inputs[k], {noise_[0][k], noise_[1][k], noise_[2][k]});
  }
}

void ImuGenerator::skip(std::uint64_t samples) {
  for (Generator& axis : axes_) axis.skip(samples);
}

}  // namespace gyrobudget::inline v0::noise
