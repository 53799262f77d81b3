// SPDX-License-Identifier: MIT
// Databases of rosbag2, of any of its layouts: columns are found by their names.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "message_source.h"

namespace gyrobudget::inline v0::log {

[[nodiscard]] bool is_sqlite(std::string_view head);

/// Opens a database without writing beside it. A journal that its recorder left is applied to a copy.
/// @param path  of the file, which may go once it is open @param name  that messages call it
/// @throws text::InputError where it cannot be read, or has no messages of ROS, or this build leaves SQLite out.
[[nodiscard]] std::unique_ptr<MessageSource> open_sqlite_source(const std::string& path, const std::string& name);

}  // namespace gyrobudget::inline v0::log
