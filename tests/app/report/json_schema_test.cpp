// SPDX-License-Identifier: MIT
// The validator itself: each keyword accepts and rejects, and what it does not know is refused.
#include "json_schema.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "../../json.h"

namespace gyrobudget::tests {
namespace {

using Json = nlohmann::json;

constexpr const char* kId = "https://example.invalid/schema/one.schema.json";

Json with_id(Json schema) {
  schema["$id"] = kId;
  return schema;
}

using Documents = std::vector<Json>;

/// The pointers at which `value` breaks `schema`, and what is said there.
std::vector<Violation> broken(const Json& schema, const Json& value) {
  return JsonSchemas(Documents{with_id(schema)}).violations(value, kId);
}

struct Case {
  const char* keyword;
  const char* schema;
  const char* accepted;
  const char* rejected;
  const char* at;  ///< where the rejected value is
};

// Printed by a failing test.
void PrintTo(const Case& one, std::ostream* out) { *out << one.schema; }

class Keyword : public testing::TestWithParam<Case> {};

TEST_P(Keyword, AcceptsAndRejects) {
  const Case& one = GetParam();
  const Json schema = parsed<Json>(one.schema), rejected = parsed<Json>(one.rejected);
  EXPECT_NE(schema.dump().find(std::string("\"") + one.keyword + "\""), std::string::npos);
  for (const Violation& v : broken(schema, parsed<Json>(one.accepted))) ADD_FAILURE() << v.at << ": " << v.what;
  const auto violations = broken(schema, rejected);
  ASSERT_EQ(violations.size(), 1U) << one.rejected;
  EXPECT_EQ(violations[0].at, one.at);
  EXPECT_FALSE(violations[0].what.empty());
  // It is the keyword that rejects.
  Json without = schema;
  without.erase(one.keyword);
  if (std::string_view(one.keyword) == "if") without.erase("then"), without.erase("else");
  EXPECT_TRUE(broken(without, rejected).empty());
}

INSTANTIATE_TEST_SUITE_P(
    All, Keyword,
    testing::Values(
        Case{"type", R"({"type": "null"})", "null", "0", ""}, Case{"type", R"({"type": "boolean"})", "false", "0", ""},
        Case{"type", R"({"type": "integer"})", "-3", "2.5", ""},
        Case{"type", R"({"type": "integer"})", "2.0", "\"2\"", ""},
        Case{"type", R"({"type": "number"})", "2", "null", ""}, Case{"type", R"({"type": "string"})", "\"\"", "[]", ""},
        Case{"type", R"({"type": "array"})", "[]", "{}", ""}, Case{"type", R"({"type": "object"})", "{}", "[]", ""},
        Case{"type", R"({"type": ["number", "null"]})", "null", "\"\"", ""},
        Case{"enum", R"({"enum": ["a", 1]})", "1", "\"b\"", ""},
        Case{"const", R"({"const": "km"})", "\"km\"", "\"m\"", ""},
        Case{"const", R"({"const": null})", "null", "0", ""}, Case{"minimum", R"({"minimum": 2})", "2", "1.9", ""},
        Case{"exclusiveMinimum", R"({"exclusiveMinimum": 2})", "2.1", "2", ""},
        Case{"maximum", R"({"maximum": 2})", "2", "2.1", ""},
        Case{"minimum", R"({"minimum": 2})", "\"no number\"", "-1", ""},
        Case{"minItems", R"({"minItems": 2})", "[1, 2]", "[1]", ""},
        Case{"maxItems", R"({"maxItems": 2})", "[1, 2]", "[1, 2, 3]", ""},
        Case{"items", R"({"items": {"type": "number"}})", "[1, 2]", "[1, null]", "/1"},
        Case{"properties", R"({"properties": {"a": {"type": "number"}}})", R"({"a": 1, "b": ""})", R"({"a": ""})",
             "/a"},
        Case{"required", R"({"required": ["a"]})", R"({"a": null})", R"({"b": 1})", ""},
        Case{"additionalProperties", R"({"properties": {"a": {}}, "additionalProperties": false})", R"({"a": 1})",
             R"({"a": 1, "b": 2})", "/b"},
        Case{"additionalProperties", R"({"additionalProperties": {"type": "number"}})", R"({"a": 1})",
             R"({"a": 1, "b/c": ""})", "/b~1c"},
        Case{"propertyNames", R"({"propertyNames": {"enum": ["a"]}})", R"({"a": 1})", R"({"b": 1})", "/b"},
        Case{"anyOf", R"({"anyOf": [{"type": "null"}, {"minimum": 1, "type": "number"}]})", "1", "\"\"", ""},
        Case{"if", R"({"if": {"required": ["a"]}, "then": {"required": ["b"]}})", R"({"a": 1, "b": 1})", R"({"a": 1})",
             ""},
        Case{"if", R"({"if": {"required": ["a"]}, "else": {"required": ["b"]}})", R"({"a": 1})", R"({"c": 1})", ""},
        Case{"then", R"({"if": {"required": ["a"]}, "then": {"required": ["b"]}})", R"({"c": 1})", R"({"a": 1})", ""},
        Case{"else", R"({"if": {"required": ["a"]}, "else": {"required": ["b"]}})", R"({"b": 1})", R"({})", ""},
        Case{"$ref", R"({"$ref": "#/$defs/n", "$defs": {"n": {"type": "number"}}})", "1", "\"\"", ""}));

TEST(JsonSchema, DescriptionsAndAnEmptySchemaAcceptEverything) {
  const Json schema = parsed<Json>(R"({"$schema": "x", "title": "x", "description": "x", "$defs": {"n": {}}})");
  for (const Json& value : {Json(nullptr), Json(1), Json("x"), Json::array({1}), Json{{"a", 1}}})
    EXPECT_TRUE(broken(schema, value).empty()) << value;
}

TEST(JsonSchema, WhatStandsBesideAReferenceHoldsToo) {
  const Json schema =
      parsed<Json>(R"({"$ref": "#/$defs/n", "minimum": 2, "$defs": {"n": {"type": "number", "maximum": 3}}})");
  EXPECT_TRUE(broken(schema, 2.5).empty());
  EXPECT_EQ(broken(schema, 1).size(), 1U);
  EXPECT_EQ(broken(schema, 4).size(), 1U);
}

TEST(JsonSchema, ReferencesLeadIntoOtherDocumentsAndOnFromThere) {
  const JsonSchemas schemas({parsed<Json>(R"({"$id": "https://a.invalid/s/list.json", "items": {"$ref": "one.json"}})"),
                             parsed<Json>(R"({"$id": "https://a.invalid/s/one.json", "properties":
                               {"a": {"$ref": "parts.json#/$defs/big"}}})"),
                             parsed<Json>(R"({"$id": "https://a.invalid/s/parts.json", "$defs":
                               {"big": {"$ref": "#/$defs/least"}, "least": {"minimum": 7}}})")});
  const auto violations = schemas.violations(parsed<Json>(R"([{"a": 7}, {"a": 6}])"), "https://a.invalid/s/list.json");
  ASSERT_EQ(violations.size(), 1U);
  EXPECT_EQ(violations[0].at, "/1/a");
  EXPECT_EQ(violations[0].what, "minimum is 7, found 6.0");
}

TEST(JsonSchema, EveryViolationHasItsPlace) {
  const Json schema =
      parsed<Json>(R"({"required": ["c"], "properties": {"a": {"type": "number"}, "b": {"items": {"minimum": 0}}}})");
  std::vector<std::string> places;
  for (const auto& v : broken(schema, parsed<Json>(R"({"a": "", "b": [1, -1, -2]})"))) places.push_back(v.at);
  EXPECT_EQ(places, (std::vector<std::string>{"", "/a", "/b/1", "/b/2"}));
}

// "no form fits" would not help where the form that was meant is plain.
TEST(JsonSchema, AnObjectOrNullSaysWhatIsWrongInTheObject) {
  const Json schema =
      parsed<Json>(R"({"properties": {"a": {"anyOf": [{"type": "object", "required": ["b"]}, {"type": "null"}]}}})");
  EXPECT_TRUE(broken(schema, parsed<Json>(R"({"a": null})")).empty());
  const auto violations = broken(schema, parsed<Json>(R"({"a": {"c": 1}})"));
  ASSERT_EQ(violations.size(), 1U);
  EXPECT_EQ(violations[0].at, "/a");
  EXPECT_EQ(violations[0].what, "the key \"b\" is missing");
}

TEST(JsonSchema, RefusesWhatItDoesNotKnow) {
  const auto refusal = [](const char* schema) -> std::string {
    try {
      const JsonSchemas schemas(Documents{with_id(parsed<Json>(schema))});
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal(R"({"properties": {"a": {"items": {"multipleOf": 2}}}})"),
            std::string(kId) + "#/properties/a/items/multipleOf: this validator does not know the keyword");
  for (const char* schema :
       {R"({"patternProperties": {}})", R"({"$defs": {"a": {"allOf": [{}]}}})", R"({"anyOf": [{"not": {}}]})",
        R"({"type": "float"})", R"({"type": []})", R"({"enum": []})", R"({"minimum": "1"})", R"({"minItems": -1})",
        R"({"items": [{}]})", R"({"required": "a"})", R"({"properties": {"a": 1}})", R"({"anyOf": []})",
        R"({"then": {}})", R"({"properties": {"a": {"$defs": {}}}})", R"({"$ref": "#/$defs/a"})",
        R"({"$ref": "other.json#/$defs/a", "$defs": {"a": {}}})",
        R"({"$ref": "#/properties/a", "properties": {"a": {}}})"})
    EXPECT_NE(refusal(schema), "accepted") << schema;
  EXPECT_THROW(JsonSchemas(Documents{Json::object()}), std::invalid_argument);
  EXPECT_THROW(JsonSchemas(Documents{with_id(Json::object()), with_id(Json::object())}), std::invalid_argument);
  EXPECT_THROW((void)JsonSchemas(Documents{with_id(Json::object())}).violations(1, "other"), std::out_of_range);
}

}  // namespace
}  // namespace gyrobudget::tests
