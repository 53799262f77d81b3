// SPDX-License-Identifier: MIT
// MCAP files.
#pragma once

#include "gyrobudget/app/log/recording.h"

#include <memory>
#include <string>
#include <string_view>

#include "message_source.h"

namespace gyrobudget::inline v0::log {

[[nodiscard]] bool is_mcap(std::string_view head);

/// One file of a recording, or all of it: closed or not, with chunks or without.
/// @param path  of the file, which may go once it is open @param name  that messages call it
/// @throws text::InputError where it cannot be read, is of another version, or is packed with what this build leaves
/// out.
[[nodiscard]] std::unique_ptr<MessageSource> open_mcap_source(const std::string& path, const std::string& name);
[[nodiscard]] std::unique_ptr<Recording> open_mcap(const std::string& path);

}  // namespace gyrobudget::inline v0::log
