// SPDX-License-Identifier: MIT
// ROS 1 bags, version 2.0.
#pragma once

#include "gyrobudget/app/log/recording.h"

#include <memory>
#include <string>
#include <string_view>

#include "message_source.h"

namespace gyrobudget::inline v0::log {

[[nodiscard]] bool is_ros1_bag(std::string_view head);
/// A bag of an older version, which is not read.
[[nodiscard]] bool is_old_ros1_bag(std::string_view head);

/// Opens a bag, closed or not: what a killed recorder left is there up to the last whole message.
/// @param path  of the file, which may go once it is open @param name  that messages call it
/// @throws text::InputError where it cannot be read, is encrypted, or is packed with what this build leaves out.
[[nodiscard]] std::unique_ptr<MessageSource> open_ros1_bag_source(const std::string& path, const std::string& name);
[[nodiscard]] std::unique_ptr<Recording> open_ros1_bag(const std::string& path);
/// @throws text::InputError always: it says how to convert it.
[[nodiscard]] std::unique_ptr<Recording> open_old_ros1_bag(const std::string& path);

}  // namespace gyrobudget::inline v0::log
