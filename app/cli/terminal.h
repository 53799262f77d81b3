// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// A line for the person at the terminal: stderr, unless --quiet.
void say(const Common&, std::string_view line);

/// The verb's result: stdout. @throws io::OutputError where it cannot be written.
void print(std::string_view text);

}  // namespace gyrobudget::inline v0::cli
