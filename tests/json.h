// SPDX-License-Identifier: MIT
// JSON in tests. Parsing and printing are compiled once, since each takes a second in every file that does it itself.
#pragma once

#include <nlohmann/json.hpp>

#include <iosfwd>
#include <string_view>

namespace gyrobudget::tests {

/// The text as nlohmann::json, keys sorted, or nlohmann::ordered_json, keys as they stand; what is no JSON becomes a
/// value that is_discarded().
template <class Json>
[[nodiscard]] Json parsed(std::string_view text);
extern template nlohmann::json parsed(std::string_view text);
extern template nlohmann::ordered_json parsed(std::string_view text);

}  // namespace gyrobudget::tests

namespace nlohmann {

// How GoogleTest prints what it compares.
void PrintTo(const json& value, std::ostream* out);
void PrintTo(const ordered_json& value, std::ostream* out);

}  // namespace nlohmann
