// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"
#include "gyrobudget/noise/units.h"

#include <vector>

namespace gyrobudget::tests {

/// The two gyros of Nunes et al., Table I, in SI.
struct Gyro {
  double n = 0, b = 0, k = 0;
  [[nodiscard]] std::vector<noise::Process> processes() const {
    return {noise::White{n}, noise::Flicker{b}, noise::RateRandomWalk{k}};
  }
};

inline Gyro gyro(const char* n, const char* b, const char* k) {
  return {noise::parse_unit("deg/sqrt(h)").to_si * std::stod(n), noise::parse_unit("deg/h").to_si * std::stod(b),
          noise::parse_unit("deg/h/sqrt(h)").to_si * std::stod(k)};
}

inline Gyro ifog() { return gyro("5.4e-4", "1.7e-3", "4.32e-2"); }
inline Gyro mems() { return gyro("0.15", "0.70", "4.32"); }

}  // namespace gyrobudget::tests
