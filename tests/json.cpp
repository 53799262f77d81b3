// SPDX-License-Identifier: MIT
#include "json.h"

#include <ostream>

namespace gyrobudget::tests {

template <class Json>
Json parsed(std::string_view text) {
  return Json::parse(text, nullptr, false);
}
template nlohmann::json parsed(std::string_view text);
template nlohmann::ordered_json parsed(std::string_view text);

}  // namespace gyrobudget::tests

namespace nlohmann {

void PrintTo(const json& value, std::ostream* out) { *out << value; }
void PrintTo(const ordered_json& value, std::ostream* out) { *out << value; }

}  // namespace nlohmann
