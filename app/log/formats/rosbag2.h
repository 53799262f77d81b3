// SPDX-License-Identifier: MIT
// Bags of ROS 2: a folder of files, or one of these.
#pragma once

#include "gyrobudget/app/log/recording.h"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::log {

/// The files that a metadata.yaml names, in their order: the sequence relative_file_paths, as recorders write it.
/// @return empty where it is no metadata of a bag
[[nodiscard]] std::optional<std::vector<std::string>> rosbag2_files(std::string_view metadata);

/// Opens a folder as a bag: the files that its metadata.yaml names or, where it has none, as after a crash, all that
/// are in it, in the order of their numbers.
/// @return null where it has neither
/// @throws text::InputError where a file cannot be read, or the files are of several recordings.
[[nodiscard]] std::unique_ptr<Recording> open_rosbag2_folder(const std::string& path);

/// Opens a bare database. @throws text::InputError where it cannot be read, or is none of a bag.
[[nodiscard]] std::unique_ptr<Recording> open_rosbag2_database(const std::string& path);

/// Opens a file of a recording that is packed as a whole.
/// @throws text::InputError where it cannot be unpacked, or holds something else.
[[nodiscard]] std::unique_ptr<Recording> open_packed_recording(const std::string& path);

}  // namespace gyrobudget::inline v0::log
