// SPDX-License-Identifier: MIT
#include "published_schemas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "../../json.h"

namespace gyrobudget::tests {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kEnding = ".schema.json", kShared = "common.schema.json", kPrefix = "gyrobudget.";

std::vector<std::filesystem::path> files() {
  std::vector<std::filesystem::path> list;
  for (const auto& entry : std::filesystem::directory_iterator(GYROBUDGET_SCHEMAS)) list.push_back(entry);
  std::sort(list.begin(), list.end());
  return list;
}

}  // namespace

const JsonSchemas& published_schemas() {
  static const JsonSchemas kSchemas = [] {
    std::vector<Json> documents;
    for (const auto& path : files()) {
      std::ifstream in(path);
      const std::string text{std::istreambuf_iterator<char>(in), {}};
      documents.push_back(parsed<Json>(text));
    }
    return JsonSchemas(documents);
  }();
  return kSchemas;
}

const std::set<std::string>& published_names() {
  static const std::set<std::string> kNames = [] {
    std::set<std::string> names;
    for (const auto& path : files()) {
      const std::string file = path.filename().string();
      if (file == kShared) continue;
      std::string name = file.substr(0, file.size() - std::min(file.size(), kEnding.size()));
      if (const auto dash = name.rfind('-'); dash != std::string::npos) name[dash] = '/';
      names.insert(std::string(kPrefix) + name);
    }
    return names;
  }();
  return kNames;
}

std::string schema_id(const std::string& name) {
  std::string file = name.substr(std::min(name.size(), kPrefix.size()));
  std::replace(file.begin(), file.end(), '/', '-');
  return "https://gyrobudget.invalid/schema/" + file + std::string(kEnding);
}

void expect_schema(const Json& object) {
  const std::string name = object.is_object() ? object.value("schema", "") : "";
  if (!published_names().contains(name)) {
    ADD_FAILURE() << "no schema is published for \"" << name << "\"";
    return;
  }
  constexpr std::size_t kMost = 20;
  std::string text;
  const auto violations = published_schemas().violations(object, schema_id(name));
  for (std::size_t i = 0; i < std::min(violations.size(), kMost); ++i)
    text += "  " + violations[i].at + ": " + violations[i].what + "\n";
  EXPECT_TRUE(violations.empty()) << "the output breaks the schema of " << name << " at " << violations.size()
                                  << " places:\n"
                                  << text;
}

}  // namespace gyrobudget::tests
