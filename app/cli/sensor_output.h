// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/result.h"

#include "arguments.h"

// What calibrate hands on: the sensor file, and Kalibr's.
namespace gyrobudget::inline v0::cli {

/// A converged fit that describes the record and finds at least one of N, B, K and G.
[[nodiscard]] bool has_answer(const report::AxisResult&);
/// Every axis has that in one record at least.
[[nodiscard]] bool every_axis_has_answer(const report::RunsResult&);

/// Writes -o and --kalibr, or says why there is nothing to write.
/// @throws std::invalid_argument where no axis is a gyro or an accelerometer.
void write_sensor_files(const report::LogResult&, const CalibrateArguments&);
void write_sensor_files(const report::RunsResult&, const CalibrateArguments&);

}  // namespace gyrobudget::inline v0::cli
