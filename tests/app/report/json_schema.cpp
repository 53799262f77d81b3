// SPDX-License-Identifier: MIT
#include "json_schema.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <stdexcept>
#include <utility>

namespace gyrobudget::tests {
namespace {

using Json = nlohmann::json;

const std::set<std::string, std::less<>> kTypes{"null", "boolean", "integer", "number", "string", "array", "object"};

bool is_text(const Json& v) { return v.is_string(); }
bool is_number(const Json& v) { return v.is_number(); }
bool is_count(const Json& v) { return v.is_number_unsigned(); }
bool is_schema(const Json& v) { return v.is_object() || v.is_boolean(); }
bool is_map_of_schemas(const Json& v) { return v.is_object() && std::all_of(v.begin(), v.end(), is_schema); }
bool is_list_of_schemas(const Json& v) {
  return v.is_array() && !v.empty() && std::all_of(v.begin(), v.end(), is_schema);
}
bool is_list_of_texts(const Json& v) { return v.is_array() && std::all_of(v.begin(), v.end(), is_text); }
bool is_list(const Json& v) { return v.is_array() && !v.empty(); }
bool is_anything(const Json&) { return true; }
bool is_type(const Json& v) { return v.is_string() && kTypes.contains(v.get<std::string>()); }
bool is_type_or_types(const Json& v) { return is_type(v) || (is_list(v) && std::all_of(v.begin(), v.end(), is_type)); }

// All keywords that are known, and the form that the value of each must have.
const std::map<std::string, bool (*)(const Json&), std::less<>> kKeywords{
    {"$schema", is_text},
    {"$id", is_text},
    {"$ref", is_text},
    {"$defs", is_map_of_schemas},
    {"title", is_text},
    {"description", is_text},
    {"type", is_type_or_types},
    {"enum", is_list},
    {"const", is_anything},
    {"minimum", is_number},
    {"exclusiveMinimum", is_number},
    {"maximum", is_number},
    {"minItems", is_count},
    {"maxItems", is_count},
    {"items", is_schema},
    {"properties", is_map_of_schemas},
    {"required", is_list_of_texts},
    {"additionalProperties", is_schema},
    {"propertyNames", is_schema},
    {"anyOf", is_list_of_schemas},
    {"if", is_schema},
    {"then", is_schema},
    {"else", is_schema},
};

// RFC 6901: "~" and "/" in a key are escaped.
std::string escaped(std::string_view key) {
  std::string text;
  for (const char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

constexpr std::string_view kOtherType = "expected the type ";

std::string shortened(const Json& value) {
  constexpr std::size_t kMost = 80;
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= kMost ? text : text.substr(0, kMost) + "...";
}

bool has_type(const Json& value, const std::string& type) {
  if (type == "null") return value.is_null();
  if (type == "boolean") return value.is_boolean();
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "array") return value.is_array();
  if (type == "object") return value.is_object();
  // 2.0 is an integer to JSON Schema.
  if (value.is_number_float()) return std::trunc(value.get<double>()) == value.get<double>();
  return value.is_number_integer();
}

}  // namespace

// --- The form of schemas -----------------------------------------------------------------------------------------

JsonSchemas::JsonSchemas(const std::vector<Json>& documents) {
  for (const Json& document : documents) {
    const auto id = document.is_object() ? document.find("$id") : document.end();
    if (id == document.end() || !id->is_string())
      throw std::invalid_argument("a schema without \"$id\": " + shortened(document));
    if (!documents_.emplace(id->get<std::string>(), document).second)
      throw std::invalid_argument("two schemas have the \"$id\" " + id->get<std::string>());
  }
  for (const auto& [id, document] : documents_) check_form(id, document, "");
}

void JsonSchemas::check_form(const std::string& document, const Json& schema, const std::string& pointer) const {
  const auto refuse = [&](const std::string& keyword, const std::string& why) {
    throw std::invalid_argument(document + "#" + pointer + "/" + escaped(keyword) + ": " + why);
  };
  if (schema.is_boolean()) return;
  for (const auto& [keyword, value] : schema.items()) {
    const auto known = kKeywords.find(keyword);
    if (known == kKeywords.end()) refuse(keyword, "this validator does not know the keyword");
    if (!known->second(value)) refuse(keyword, "the keyword cannot have the value " + shortened(value));
    const bool at_root = keyword == "$schema" || keyword == "$id" || keyword == "$defs";
    if (at_root && !pointer.empty()) refuse(keyword, "the keyword belongs at the root of a document");
    if ((keyword == "then" || keyword == "else") && !schema.contains("if"))
      refuse(keyword, "the keyword has no \"if\" beside it");
    if (keyword == "$ref") (void)resolve(document, value.get<std::string>());
    const std::string below = pointer + "/" + escaped(keyword);
    if (known->second == is_schema) check_form(document, value, below);
    if (known->second == is_map_of_schemas)
      for (const auto& [key, item] : value.items()) check_form(document, item, below + "/" + escaped(key));
    if (known->second == is_list_of_schemas)
      for (std::size_t i = 0; i < value.size(); ++i) check_form(document, value[i], below + "/" + std::to_string(i));
  }
}

JsonSchemas::Place JsonSchemas::resolve(const std::string& document, const std::string& reference) const {
  const std::size_t hash = reference.find('#');
  const std::string file = reference.substr(0, hash);
  const std::string id = file.empty() ? document : document.substr(0, document.rfind('/') + 1) + file;
  const auto found = documents_.find(id);
  constexpr std::string_view kDefinitions = "/$defs/";
  const std::string pointer = hash == std::string::npos ? "" : reference.substr(hash + 1);
  if (found != documents_.end() && pointer.empty()) return {id, &found->second};
  if (found != documents_.end() && pointer.starts_with(kDefinitions)) {
    const Json::json_pointer at(pointer);
    if (found->second.contains(at)) return {id, &found->second[at]};
  }
  throw std::invalid_argument(document + ": the reference " + reference + " leads nowhere");
}

// --- Values --------------------------------------------------------------------------------------------------------

/// One pass over a value.
class SchemaCheck {
 public:
  explicit SchemaCheck(const JsonSchemas& schemas, std::vector<std::string> path = {})
      : schemas_(schemas), path_(std::move(path)) {}

  void check(const Json& value, const std::string& document, const Json& schema) {
    if (schema.is_boolean()) {
      if (!schema.get<bool>()) fail("nothing may stand here, found " + shortened(value));
      return;
    }
    if (const auto ref = schema.find("$ref"); ref != schema.end()) {
      const auto [id, target] = schemas_.resolve(document, ref->get<std::string>());
      check(value, id, *target);
    }
    check_type(value, schema);
    check_choice(value, schema);
    if (value.is_number()) check_number(value.get<double>(), schema);
    if (value.is_array()) check_array(value, document, schema);
    if (value.is_object()) check_object(value, document, schema);
    check_alternatives(value, document, schema);
  }

  [[nodiscard]] std::vector<Violation> take() { return std::move(violations_); }

 private:
  [[nodiscard]] std::string here() const {
    std::string at;
    for (const std::string& part : path_) at.append("/").append(escaped(part));
    return at;
  }

  void fail(std::string what) { violations_.push_back({here(), std::move(what)}); }

  [[nodiscard]] std::vector<Violation> apart(const Json& value, const std::string& document, const Json& schema) const {
    SchemaCheck inner(schemas_, path_);
    inner.check(value, document, schema);
    return inner.take();
  }

  void check_type(const Json& value, const Json& schema) {
    const auto type = schema.find("type");
    if (type == schema.end()) return;
    const auto fits = [&](const Json& one) { return has_type(value, one.get_ref<const std::string&>()); };
    if (type->is_array() ? std::any_of(type->begin(), type->end(), fits) : fits(*type)) return;
    fail(std::string(kOtherType) + type->dump() + ", found " + shortened(value));
  }

  void check_choice(const Json& value, const Json& schema) {
    if (const auto list = schema.find("enum");
        list != schema.end() && std::find(list->begin(), list->end(), value) == list->end())
      fail("expected one of " + list->dump() + ", found " + shortened(value));
    if (const auto only = schema.find("const"); only != schema.end() && *only != value)
      fail("expected " + shortened(*only) + ", found " + shortened(value));
  }

  void check_number(double value, const Json& schema) {
    const auto limit = [&](const char* keyword, auto holds) {
      const auto at = schema.find(keyword);
      if (at != schema.end() && !holds(value, at->get<double>()))
        fail(std::string(keyword) + " is " + at->dump() + ", found " + Json(value).dump());
    };
    limit("minimum", std::greater_equal{});
    limit("exclusiveMinimum", std::greater{});
    limit("maximum", std::less_equal{});
  }

  void check_array(const Json& value, const std::string& document, const Json& schema) {
    const auto limit = [&](const char* keyword, auto holds) {
      const auto at = schema.find(keyword);
      if (at != schema.end() && !holds(value.size(), at->get<std::size_t>()))
        fail(std::string(keyword) + " is " + at->dump() + ", found " + std::to_string(value.size()));
    };
    limit("minItems", std::greater_equal{});
    limit("maxItems", std::less_equal{});
    const auto items = schema.find("items");
    if (items == schema.end()) return;
    for (std::size_t i = 0; i < value.size(); ++i) {
      path_.push_back(std::to_string(i));
      check(value[i], document, *items);
      path_.pop_back();
    }
  }

  void check_object(const Json& value, const std::string& document, const Json& schema) {
    if (const auto required = schema.find("required"); required != schema.end()) {
      for (const Json& key : *required)
        if (!value.contains(key.get_ref<const std::string&>())) fail("the key " + key.dump() + " is missing");
    }
    const auto properties = schema.find("properties"), additional = schema.find("additionalProperties"),
               names = schema.find("propertyNames");
    for (const auto& [key, item] : value.items()) {
      path_.push_back(key);
      if (names != schema.end()) check(key, document, *names);
      if (properties != schema.end() && properties->contains(key)) {
        check(item, document, properties->at(key));
      } else if (additional != schema.end()) {
        check(item, document, *additional);
      }
      path_.pop_back();
    }
  }

  void check_alternatives(const Json& value, const std::string& document, const Json& schema) {
    if (const auto any = schema.find("anyOf"); any != schema.end()) check_any(value, document, *any);
    const auto condition = schema.find("if");
    if (condition == schema.end()) return;
    const auto branch = schema.find(apart(value, document, *condition).empty() ? "then" : "else");
    if (branch != schema.end()) check(value, document, *branch);
  }

  // Where one form alone has the value's type, its violations are told.
  void check_any(const Json& value, const std::string& document, const Json& forms) {
    std::vector<std::vector<Violation>> meant;
    for (const Json& form : forms) {
      std::vector<Violation> found = apart(value, document, form);
      if (found.empty()) return;
      const bool other_type = std::any_of(found.begin(), found.end(), [&](const Violation& v) {
        return v.at == here() && v.what.starts_with(kOtherType);
      });
      if (!other_type) meant.push_back(std::move(found));
    }
    if (meant.size() != 1) return fail("no form of anyOf fits " + shortened(value));
    violations_.insert(violations_.end(), meant.front().begin(), meant.front().end());
  }

  const JsonSchemas& schemas_;
  std::vector<std::string> path_;
  std::vector<Violation> violations_;
};

std::vector<Violation> JsonSchemas::violations(const Json& value, std::string_view id) const {
  const auto document = documents_.find(id);
  if (document == documents_.end()) throw std::out_of_range("no schema has the \"$id\" " + std::string(id));
  SchemaCheck check(*this);
  check.check(value, document->first, document->second);
  return check.take();
}

}  // namespace gyrobudget::tests
