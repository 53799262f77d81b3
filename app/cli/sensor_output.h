// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/calibration/several.h"

#include <string>
#include <vector>

#include "arguments.h"

// What calibrate hands on: datasheet, pictures, the sensor file and Kalibr's.
namespace gyrobudget::inline v0::cli {

/// Refuses, before any work, a sensor file that could not be overwritten without a loss, whatever the record tells.
/// @throws text::OutputError
void check_sensor_output(const CalibrateArguments& a);

/// Prints the datasheet and writes what was asked for beside it; where no axis has an answer it says that no sensor
/// file is written.
/// @param notes  how the log was read
/// @return the exit code
/// @throws std::invalid_argument where -o or --kalibr is asked for and no axis is a gyro or an accelerometer;
/// text::OutputError where a file cannot be written, or would lose what it holds (CalibrateArguments::update).
[[nodiscard]] int tell(const calibration::Datasheet& sheet, std::vector<std::string> notes,
                       const CalibrateArguments& a);
[[nodiscard]] int tell(const calibration::TypeDatasheet& sheet, std::vector<std::vector<std::string>> notes,
                       const CalibrateArguments& a);

}  // namespace gyrobudget::inline v0::cli
