// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/io/error.h"
#include "gyrobudget/noise/sensor.h"

#include <optional>
#include <string>

namespace gyrobudget::inline v0::io {

/// Reads a sensor file (YAML, every value with its unit) or a Kalibr/OpenVINS/imu_utils imu.yaml.
/// @throws InputError with file:line:column.
[[nodiscard]] noise::SensorModel read_sensor(const std::string& path);

/// The sensor file of a model, datasheet units; read_sensor of it gives the model back.
[[nodiscard]] std::string sensor_yaml(const noise::SensorModel&);

/// Kalibr's imu.yaml: continuous-time densities, SI.
[[nodiscard]] std::string kalibr_yaml(const noise::SensorModel&, double update_rate_hz);

}  // namespace gyrobudget::inline v0::io
