// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include <set>
#include <string>

#include "json_schema.h"

// The schemas of app/report/schema, which are installed with the program.
namespace gyrobudget::tests {

/// Every document of the folder, read once.
[[nodiscard]] const JsonSchemas& published_schemas();
/// The names of the objects that have a schema, as their field "schema" has them: "gyrobudget.allan/1".
[[nodiscard]] const std::set<std::string>& published_names();
/// The "$id" of the schema of such a name, whether or not there is one.
[[nodiscard]] std::string schema_id(const std::string& name);

/// Fails the running test for each place at which an object breaks the schema that its field "schema" names.
void expect_schema(const nlohmann::json& object);

}  // namespace gyrobudget::tests
