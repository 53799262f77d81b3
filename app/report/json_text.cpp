// SPDX-License-Identifier: MIT
#include "json_text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kJsonWidth = 200;

void write(const Json& value, std::size_t indent, std::string& out) {
  const bool nested = std::any_of(value.begin(), value.end(), [](const Json& v) { return v.is_structured(); });
  if (!value.is_structured() || value.empty()) {
    out += compact_json(value);
    return;
  }
  if (!nested) {
    const std::string line = compact_json(value);
    if (indent + line.size() <= kJsonWidth || (value.is_array() && value.front().is_number())) {
      out += line;
      return;
    }
  }
  out += value.is_array() ? '[' : '{';
  bool first = true;
  for (const auto& [key, item] : value.items()) {
    out += first ? "\n" : ",\n";
    first = false;
    out.append(indent + 2, ' ');
    if (value.is_object()) out += compact_json(Json(key)) + ": ";
    write(item, indent + 2, out);
  }
  out += '\n';
  out.append(indent, ' ');
  out += value.is_array() ? ']' : '}';
}

}  // namespace

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string compact_json(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string dense_json(const Json& value) {
  std::string out;
  write(value, 0, out);
  return out + '\n';
}

}  // namespace gyrobudget::inline v0::report
