// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace gyrobudget::inline v0::report {

/// The number, or null where it is none that JSON has.
[[nodiscard]] nlohmann::ordered_json number_or_null(double value);

/// On one line. Invalid UTF-8 in names of columns and files is replaced, never an error.
[[nodiscard]] std::string compact_json(const nlohmann::ordered_json&);
/// Readable and still dense: a list or object without lists or objects inside stands on one line where it fits, numbers
/// in a list always. Ends with a line feed.
[[nodiscard]] std::string dense_json(const nlohmann::ordered_json&);

}  // namespace gyrobudget::inline v0::report
