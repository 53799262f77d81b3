// SPDX-License-Identifier: MIT
// Records of known truth that hold more than noise.
#pragma once

#include "gyrobudget/allan/record.h"

#include <string>
#include <vector>

namespace gyrobudget::tests {

/// White noise of N = 0.15 deg/sqrt(h), flicker of B = 0.7 deg/h and a walk of K = 4.32 deg/h/sqrt(h): the MEMS gyro of
/// Nunes et al., `samples` at 10 Hz [rad/s].
[[nodiscard]] std::vector<double> mems_rates(std::int64_t samples, std::uint64_t seed);
[[nodiscard]] allan::Axis gyro_axis(std::vector<double> rate, std::string name = "gyro_x");

inline constexpr double kRecordRate = 10;  ///< [Hz]

inline constexpr double kQuantization =
    1e-4;  ///< of the quantized record: it has 160 times the variance of the white noise at 0.1 s [rad]

/// A record and what is special about it.
struct NamedRecord {
  std::string name;
  allan::Record record;
};
/// Clean; with knocks, a step, a warm-up, a drift, a line, gaps; quantized; silent; two gyros of different grade beside
/// an accelerometer.
[[nodiscard]] std::vector<NamedRecord> ten_records();

}  // namespace gyrobudget::tests
