// SPDX-License-Identifier: MIT
// From a datasheet to the model that simulations, budgets and filters take.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <string>

#include "several.h"

namespace gyrobudget::inline v0::calibration {

/// One model for each triad: of every term the root mean square over the axes that have an answer, as their spectra add
/// up. A Gauss-Markov process of each axis keeps its own correlation time, and lines within 0.1 % of one frequency are
/// one. Values have six digits in the datasheet's unit, more than any record tells, so that a file has what was
/// computed. What depends on temperature is that of each axis where a triad has three, or one that stands for all.
/// Dimensionless axes have no place in it.
/// @param sheet  its gyro axes make the gyro, its accelerometer axes the accelerometer
/// @param name   of the sensor
/// @return a gyro of zeros where no gyro axis has an answer, and no accelerometer where none of its axes has one.
[[nodiscard]] noise::SensorModel sensor_model(const Datasheet& sheet, std::string name);
/// Of the coefficients that several records gave together.
[[nodiscard]] noise::SensorModel sensor_model(const TypeDatasheet& sheet, std::string name);

}  // namespace gyrobudget::inline v0::calibration
