// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/calibration/several.h"

#include <string>
#include <vector>

#include "arguments.h"

// What calibrate hands on: datasheet, pictures, the sensor file and Kalibr's.
namespace gyrobudget::inline v0::cli {

/// Prints the datasheet and writes what was asked for beside it; where no axis has an answer it says that no sensor
/// file is written.
/// @param notes  how the log was read
/// @return the exit code
/// @throws std::invalid_argument where -o or --kalibr is asked for and no axis is a gyro or an accelerometer.
[[nodiscard]] int tell(const calibration::Datasheet& sheet, std::vector<std::string> notes,
                       const CalibrateArguments& a);
[[nodiscard]] int tell(const calibration::TypeDatasheet& sheet, std::vector<std::vector<std::string>> notes,
                       const CalibrateArguments& a);

}  // namespace gyrobudget::inline v0::cli
