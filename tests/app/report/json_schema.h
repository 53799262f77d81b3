// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <string_view>
#include <vector>

// A validator of JSON Schema 2020-12 for tests. It knows the keywords that the schemas of this project use and refuses
// all others, so that a schema never promises what nobody checks.
namespace gyrobudget::tests {

/// One place at which a value breaks its schema.
struct Violation {
  std::string at;    ///< JSON pointer into the value: "/axes/0/points/3/edf"; empty for the whole value
  std::string what;  ///< what was found there and what the schema expects
};

/// Schema documents that may refer to one another.
///
/// The keywords are those of kKeywords in json_schema.cpp, with the meaning of the specification. "$ref" is
/// "#/$defs/NAME" or "FILE#/$defs/NAME", where FILE replaces what follows the last slash in the document's "$id"; the
/// keywords beside it hold as well. "$defs" stand at the root of a document alone.
class JsonSchemas {
 public:
  /// @param documents one schema each, with an "$id".
  /// @throws std::invalid_argument for an unknown keyword, a keyword whose value has the wrong form, a reference to
  /// what is not there, or an "$id" that is missing or given twice; the message has the document and the JSON pointer.
  explicit JsonSchemas(const std::vector<nlohmann::json>& documents);

  /// Where `value` breaks the document named `id`, in the order of the value; empty where it conforms.
  /// @throws std::out_of_range where no document has this "$id".
  [[nodiscard]] std::vector<Violation> violations(const nlohmann::json& value, std::string_view id) const;

 private:
  friend class SchemaCheck;
  struct Place {
    std::string document;  ///< its "$id"
    const nlohmann::json* schema;
  };
  [[nodiscard]] Place resolve(const std::string& document, const std::string& reference) const;
  void check_form(const std::string& document, const nlohmann::json& schema, const std::string& pointer) const;

  std::map<std::string, nlohmann::json, std::less<>> documents_;
};

}  // namespace gyrobudget::tests
