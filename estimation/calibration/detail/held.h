// SPDX-License-Identifier: MIT
// Sensors that are slower than their log: their readings in place of its rows.
#pragma once

#include "gyrobudget/allan/record.h"
#include "gyrobudget/allan/repeats.h"
#include "gyrobudget/estimation/calibration/calibrate.h"

#include <memory>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::calibration::detail {

/// What the rows of one sensor repeat.
struct HeldSensor {
  allan::Repeats repeats;
  allan::Readings readings;
};

/// For each axis the sensor that it belongs to; null where its rows do not repeat. The gyro axes of a record are one
/// sensor, the accelerometer axes another; where these do not repeat together, and for dimensionless axes, each axis is
/// one. A few readings that stand for most of the record (a spike in zeros, say) are no slower sensor's.
[[nodiscard]] std::vector<std::shared_ptr<const HeldSensor>> held_sensors(const allan::Record& record);

/// The white noise of a datasheet of readings as it is where the rows of the log are summed as they stand: raised by
/// what uneven holds add. Coefficients, covariance, curves and residuals hold that afterwards.
/// @param readings  of the axis
/// @param dt        their interval [s]
/// @return N afterwards over N before; 1 where N was not fitted, or is 0
double raise_white_noise(AxisDatasheet& sheet, std::span<const double> readings, const HeldSensor& sensor, double dt);

}  // namespace gyrobudget::inline v0::calibration::detail
