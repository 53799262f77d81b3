// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// What a sensor axis is called and what it measures.
struct AxisLabel {
  std::string name;                                    ///< as its log has it: any bytes
  noise::Signal signal = noise::Signal::angular_rate;  ///< decides units and names
};

/// What one sensor axis said.
struct Axis {
  std::string name;                                    ///< as its log has it: any bytes
  noise::Signal signal = noise::Signal::angular_rate;  ///< decides units and names
  std::vector<double> rate;  ///< mean over each sample interval [rad/s, m/s^2 or 1]; NaN where missing
};

/// What a sensor said at an even rate: the axes of one recording, as a value. A reader makes one (log::read_log), and
/// so does whoever has samples in memory:
///
///     const auto record = allan::make_record({{"gyro_x", noise::Signal::angular_rate, samples}}, 100);
struct Record {
  std::string source = {};           ///< what it is called: the path of a log, or any name
  double rate_hz = 0;                ///< [Hz]
  std::int64_t samples = 0;          ///< length of each axis, missing samples included
  std::int64_t missing_samples = 0;  ///< at which any axis has no number
  double start_s = 0;                ///< of a segment, since the first row of the log by its own clock
  std::int64_t first_row = 1;        ///< likewise, the line of its first row (binary: the row), from 1
  std::vector<Axis> axes = {};
  /// Of the sensor [degC], as long as the axes, NaN where missing (a slow one may be so at most samples); empty: none.
  std::vector<double> temperature = {};
  std::vector<std::string> notes = {};  ///< what a person should know of how it was read, one sentence each
};

/// A record of samples in memory, its lengths and missing samples counted.
/// @param axes     all of one length
/// @param rate_hz  [Hz]
/// @throws std::invalid_argument for a rate that is not positive and finite, and axes of different lengths.
[[nodiscard]] Record make_record(std::vector<Axis> axes, double rate_hz, std::string source = "samples");

}  // namespace gyrobudget::inline v0::allan
