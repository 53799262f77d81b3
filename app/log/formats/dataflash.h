// SPDX-License-Identifier: MIT
// Logs of ArduPilot.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

[[nodiscard]] bool is_dataflash(std::string_view head);
/// The same log turned into text.
[[nodiscard]] bool is_dataflash_text(std::string_view head);

/// A stream for each message and instance: "IMU[0]" where a field says which sensor it is, "IMU2" where the name does.
/// Batches of raw samples (ISBH and ISBD) are streams of single samples beside the messages that carry them: "gyroscope
/// batches[0]". Numbers are in the unit that the log tells (UNIT, MULT, FMTU), or that ArduPilot documents for the
/// message. The clock is SampleUS, TimeUS or TimeMS, what is there first.
[[nodiscard]] std::unique_ptr<Recording> open_dataflash(std::shared_ptr<const Bytes> bytes);
[[nodiscard]] std::unique_ptr<Recording> open_dataflash_text(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
