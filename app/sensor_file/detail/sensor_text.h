// SPDX-License-Identifier: MIT
// Inside sensor_file: pieces of a sensor file as text.
#pragma once

#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <string>

namespace gyrobudget::inline v0::sensor_file::detail {

/// @param name  of its file, for messages. @throws InputError as read_sensor_file.
[[nodiscard]] SensorFile read_sensor_text(std::string name, std::string text);

/// "gyro:" or "accelerometer:" with what stands below it, a line each, indented by two.
[[nodiscard]] std::string triad_yaml(const noise::ErrorModel& model, noise::Signal signal);

/// A text as a value of YAML, in quotes where it needs them.
[[nodiscard]] std::string text_yaml(const std::string& text);

}  // namespace gyrobudget::inline v0::sensor_file::detail
