// SPDX-License-Identifier: MIT
#include "records.h"

#include "gyrobudget/noise/generate.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "../fit/sensors.h"

namespace gyrobudget::tests {
namespace {

constexpr std::int64_t kSamples = 36000;  // an hour

// The clean record with something added to sample i.
template <class Added>
allan::Record with(std::uint64_t seed, Added added) {
  auto rate = mems_rates(kSamples, seed);
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] += added(i);
  return allan::make_record({gyro_axis(std::move(rate))}, kRecordRate);
}

allan::Record quantized() {
  constexpr double kStep = 2e-4;  // some 7 steps of angle within the noise of a second
  auto rate = mems_rates(kSamples, 8);
  double angle = 0, told = 0;
  for (double& y : rate) {
    angle += y / kRecordRate;
    const double rounded = std::round(angle / kStep) * kStep;
    y = (rounded - std::exchange(told, rounded)) * kRecordRate;
  }
  return allan::make_record({gyro_axis(std::move(rate))}, kRecordRate);
}

allan::Record three_axes() {
  auto worse = mems_rates(kSamples, 10);
  for (double& y : worse) y *= 5;
  const std::array<noise::Process, 1> white{noise::White{1e-3}};  // [m/s/sqrt(s)]
  return allan::make_record({gyro_axis(mems_rates(kSamples, 9)),
                             gyro_axis(std::move(worse), "gyro_y"),
                             {"accel_x", noise::Signal::specific_force,
                              noise::generate_record(white, kSamples, 1 / kRecordRate, {.seed = 11, .stream = 0})}},
                            kRecordRate);
}

}  // namespace

std::vector<double> mems_rates(std::int64_t samples, std::uint64_t seed) {
  return noise::generate_record(mems().processes(), samples, 1 / kRecordRate, {.seed = seed, .stream = 0});
}

allan::Axis gyro_axis(std::vector<double> rate, std::string name) {
  return {std::move(name), noise::Signal::angular_rate, std::move(rate)};
}

std::vector<NamedRecord> ten_records() {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  std::vector<NamedRecord> list;
  list.push_back({"clean", with(1, [](std::size_t) { return 0.0; })});
  list.push_back({"knocks", with(2, [](std::size_t i) { return i % 7001 == 5000 ? 0.01 : 0.0; })});
  list.push_back({"step", with(3, [](std::size_t i) { return i > 15000 ? 1e-4 : 0.0; })});
  list.push_back({"warm-up", with(4, [](std::size_t i) { return 1e-3 * std::exp(-static_cast<double>(i) / 2000); })});
  list.push_back({"drift", with(5, [](std::size_t i) { return 3e-8 * static_cast<double>(i); })});
  list.push_back({"line", with(6, [](std::size_t i) {
                    return 2e-4 * std::sin(2 * std::numbers::pi * 1.7 * static_cast<double>(i) / kRecordRate);
                  })});
  list.push_back({"gaps", with(7, [=](std::size_t i) { return i % 997 < 7 || (i > 9000 && i < 9400) ? kNaN : 0.0; })});
  list.push_back({"quantized", quantized()});
  list.push_back({"silent", allan::make_record({gyro_axis(std::vector<double>(kSamples, 1e-3))}, kRecordRate)});
  list.push_back({"three axes", three_axes()});
  return list;
}

}  // namespace gyrobudget::tests
