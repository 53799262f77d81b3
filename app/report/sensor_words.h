// SPDX-License-Identifier: MIT
// What a sensor file leaves open, and what it warns of, in words.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::report {

/// What a sensor's file does not state and nothing but the file can (noise::not_stated): "gyro.turn_on_bias",
/// "gyro.scale_factor" and so on; "accelerometer" where it has none at all, and "gyro" where nothing stands below it.
[[nodiscard]] std::vector<std::string> not_stated(const noise::SensorModel& sensor);

/// "The sensor file states no turn-on bias of the gyro, and no accelerometer at all: what it leaves out is taken as
/// zero, and this total holds nothing of it." Empty where the list is.
/// @param numbers  what leaves them out: kThisTotal
[[nodiscard]] std::string not_stated_text(std::span<const std::string> names, std::string_view numbers);

inline constexpr std::string_view kThisTotal = "this total holds", kTheseSigmas = "these sigmas hold";

/// The warnings of a sensor file and how it was read, one sentence each.
[[nodiscard]] std::vector<std::string> sensor_notes(std::span<const std::string> warnings,
                                                    std::span<const std::string> readings, std::string_view path);

}  // namespace gyrobudget::inline v0::report
