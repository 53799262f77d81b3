// SPDX-License-Identifier: MIT
// Inside the reading of a scene's logs: the IMU's samples, and the fixes of an aid.
#pragma once

#include <string>
#include <vector>

#include "scene_file.h"

namespace gyrobudget::inline v0::files {

/// @param with_temperature  reads that of the sensor too, where the log has it
/// @param notes  gets what a person should know of how it was read, one sentence each
/// @throws InputError for a log that is missing, malformed, or recorded with samples left out between its rows.
[[nodiscard]] navigation::ImuSamples read_samples(const ImuSource& imu, bool with_temperature,
                                                  std::vector<std::string>& notes);

/// The fixes of one aid, on the clock of their own file.
struct AidFixes {
  std::vector<navigation::Fix> fixes;
  std::string time_scale;  ///< "GPST", "UTC", "JST" where the file says it
};
/// @param is_optional  a file without the columns gives no fixes
/// @param notes  as of read_samples
/// @throws InputError for a file that is missing or malformed, or has not what the scene asks of it.
[[nodiscard]] AidFixes read_fixes(const navigation::Aid& aid, const AidSource& source, bool is_optional,
                                  std::vector<std::string>& notes);

}  // namespace gyrobudget::inline v0::files
