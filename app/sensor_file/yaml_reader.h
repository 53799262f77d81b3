// SPDX-License-Identifier: MIT
// YAML with a place for every complaint. The one header that includes yaml-cpp.
#pragma once

#include "gyrobudget/noise/units.h"

#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::sensor_file {

/// What a number may be.
enum class Sign { any, not_negative, above_zero };

/// Bytes of the largest file that is read: 1 MiB.
inline constexpr std::size_t kLargestFile = std::size_t{1} << 20;

/// A key and what reads its value.
struct YamlKey {
  std::string name;
  std::function<void(const YAML::Node& value)> read;
};

/// A YAML file whose root is a map. What it hands out refers to it.
class YamlReader {
 public:
  /// @param what  "a scene", for messages
  /// @param line  a line that such a file has, for messages: "site: alcantara"
  /// @param key   a key of its root: "site:"
  /// @throws InputError where the file cannot be read, has more than 1 MiB, is no YAML or no map.
  YamlReader(const std::string& path, std::string_view what, std::string_view line, std::string_view key);
  /// Of a text that was read already. @param name  of its file, for messages
  struct Text {
    std::string name, text;
  };
  YamlReader(Text text, std::string_view line, std::string_view key);

  [[nodiscard]] const YAML::Node& root() const { return root_; }
  [[nodiscard]] const std::string& name() const { return name_; }

  /// @throws InputError with the place of the node.
  [[noreturn]] void fail_here(const YAML::Node&, const std::string& message) const;
  [[noreturn]] void fail_unknown_key(const YAML::Node& key, std::string_view where,
                                     const std::vector<std::string>& known) const;

  /// "keys and values", "a list", "nothing" or the text in quotes.
  [[nodiscard]] static std::string kind(const YAML::Node&);

  /// The value of a key, or none, before all are read: of what should be a map.
  [[nodiscard]] YAML::Node find(const YAML::Node& map, std::string_view what, const char* key) const;

  /// Calls visit(key, value) for each entry of a map, each key once.
  void for_each(const YAML::Node& map, std::string_view what,
                const std::function<void(const YAML::Node& key, const YAML::Node& value)>& visit) const;

  /// Reads each entry of a map with the one of `keys` that has its name; others are refused.
  void section(const YAML::Node& map, std::string_view what, const std::vector<YamlKey>& keys) const;

  /// The value of a key as text.
  [[nodiscard]] std::string text(std::string_view key, const YAML::Node& value) const;
  /// true or false (yes and no too).
  [[nodiscard]] bool flag(std::string_view key, const YAML::Node& value) const;
  /// A whole number from `lowest` to `highest`.
  [[nodiscard]] int whole(std::string_view key, const YAML::Node& value, int lowest, int highest) const;
  /// A plain number.
  [[nodiscard]] double number(std::string_view key, const YAML::Node& value) const;
  /// One of `words`, as its place among them.
  [[nodiscard]] std::size_t one_of(std::string_view key, const YAML::Node& value,
                                   const std::vector<std::string>& words) const;
  /// "10 ms" in SI.
  [[nodiscard]] double quantity(std::string_view key, const YAML::Node& value, const noise::Dimension&, Sign) const;
  void check_sign(std::string_view key, const YAML::Node& value, double number, Sign) const;

 private:
  std::string name_;
  YAML::Node root_;
};

}  // namespace gyrobudget::inline v0::sensor_file
