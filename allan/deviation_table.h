// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <string>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// A table of Allan deviations, as other tools and papers give them.
struct DeviationTable {
  struct Column {
    std::string name;
    noise::Signal signal = noise::Signal::angular_rate;
    std::vector<double> deviation;  ///< at each averaging time [rad/s, m/s^2 or 1]
  };
  std::string source;         ///< what it is called: a path, or any name
  std::vector<double> tau_s;  ///< averaging times, ascending [s]
  std::vector<Column> columns;
};

}  // namespace gyrobudget::inline v0::allan
