// SPDX-License-Identifier: MIT
// What a simulated log says of itself, and what a person should know of it.
#pragma once

#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/estimation/navigation/simulated_imu.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/noise/simulation.h"

#include <cstdint>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::report {

/// The head of the log of a sensor at rest.
/// @param gyro_unit of the gyro columns. @param model its name. @param skipped samples left out at the start.
[[nodiscard]] log::LogHead rest_head(const noise::Simulation&, const std::string& sensor, const std::string& model,
                                     const std::string& gyro_unit, std::uint64_t skipped, log::Format);

/// The head of the log of an IMU along a trajectory, of which the first row is of the interval `skipped`.
/// @param increments whether the columns are angles and velocities, else means over the interval.
[[nodiscard]] log::LogHead imu_head(const navigation::SimulatedImuOptions&, const std::string& sensor,
                                    const std::string& trajectory, const std::string& gyro_unit, bool increments,
                                    std::uint64_t skipped, log::Format);

/// Which terms of the sensor the model leaves out.
[[nodiscard]] std::vector<std::string> left_out_notes(const noise::SimulationModel&, const noise::SensorModel&,
                                                      const std::string& name);

/// What is special of an IMU's log: readings out of range, a lever arm, an accelerometer that is ideal.
[[nodiscard]] std::vector<std::string> imu_notes(const noise::SensorModel&, const noise::Imu&);

/// A binary log does not say what it holds: in words, with the options that read it.
[[nodiscard]] std::string how_to_read(const log::LogHead&);

}  // namespace gyrobudget::inline v0::report
