// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/io/error.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::io {

enum class Input { rate, increment, angle };  ///< what a column holds per sample

struct LogOptions {
  std::string path;                   ///< "-" is standard input
  std::optional<double> rate_hz;      ///< needed where there is no time column; checked against it where there is
  std::optional<std::string> unit;    ///< of every data column without one in the header; "1" is dimensionless
  Input input = Input::rate;
  double scale = 1;                   ///< units per count
  std::vector<std::string> columns;   ///< names or numbers (from 1); empty: every data column
};

struct Axis {
  std::string name;
  noise::Signal signal = noise::Signal::angular_rate;
  std::vector<double> rate;           ///< mean rate over each sample interval, SI; NaN where missing
};

/// A log on a uniform time grid.
struct Record {
  std::string source;
  double rate_hz = 0;
  std::int64_t samples = 0;           ///< grid points, missing ones included
  std::int64_t missing_samples = 0;   ///< grid points at which any axis has no number
  std::vector<Axis> axes;
  std::vector<std::string> notes;     ///< what a person should know of how it was read
};

/// @throws InputError
[[nodiscard]] Record read_log(const LogOptions&);

}  // namespace gyrobudget::inline v0::io
