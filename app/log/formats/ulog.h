// SPDX-License-Identifier: MIT
// Logs of PX4.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

[[nodiscard]] bool is_ulog(std::string_view head);

/// A stream for each topic and instance: "sensor_combined", "sensor_gyro[1]"; all its fields that are numbers, arrays
/// as gyro_rad[0], what is nested as outer.inner. Rows of the fifo topics are the samples of the bursts, each at its
/// own time. The clock is timestamp_sample where a topic has it.
/// @throws InputError for a header that ends early, or a log that a reader is forbidden to read.
[[nodiscard]] std::unique_ptr<Recording> open_ulog(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
