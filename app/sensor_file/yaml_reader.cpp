// SPDX-License-Identifier: MIT
#include "yaml_reader.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::sensor_file {

using YAML::Node;

YamlReader::YamlReader(const std::string& path, std::string_view what, std::string_view line, std::string_view key)
    : YamlReader({text::input_name(path), text::read_text(path, kLargestFile, what)}, line, key) {}

namespace {

/// The line, from 1, of the first content behind a `---` that ends a document; 0 for none. At the head of a line these
/// three are nothing else in YAML. (YAML::LoadAll has no end on some damaged files.)
std::int64_t second_document(std::string_view text) {
  bool content = false, ended = false;
  for (std::int64_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const bool mark = line.starts_with("---") && text::trim(line.substr(0, 4)).size() == 3;
    const bool filling = text::trim(line).empty() || text::trim(line).starts_with('#') || line.starts_with('%');
    if (mark)
      ended = content;
    else if (!filling && ended)
      return number;
    else if (!filling)
      content = true;
  }
  return 0;
}

}  // namespace

YamlReader::YamlReader(Text read, std::string_view line, std::string_view key) : name_(std::move(read.name)) {
  std::string& text = read.text;
  if (text.starts_with("%YAML:")) text[0] = '#';  // OpenCV's own first line is not YAML
  try {
    root_ = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    text::fail_at(name(), error.mark.line + 1, error.mark.column + 1,
                  fmt::format("no YAML: {}; expected lines like \"{}\"", error.msg, line));
  }
  if (const std::int64_t at = second_document(text); at > 0)
    text::fail_at(name(), at, 1, "found a second document, expected one; take out the line --- above it");
  if (!root_.IsMap()) fail_here(root_, fmt::format("found {}, expected keys like \"{}\"", kind(root_), key));
}

void YamlReader::fail_here(const Node& node, const std::string& message) const {
  const YAML::Mark mark = node.Mark();
  text::fail_at(name(), std::max(mark.line, 0) + 1, std::max(mark.column, 0) + 1, message);
}

void YamlReader::fail_unknown_key(const Node& key, std::string_view where,
                                  const std::vector<std::string>& known) const {
  fail_here(key, fmt::format("{} is no key of {}{}; there are {}", text::quoted(key.Scalar()), where,
                             text::suggestion(key.Scalar(), known), text::listing(known)));
}

std::string YamlReader::kind(const Node& node) {
  if (node.IsMap()) return "keys and values";
  if (node.IsSequence()) return "a list";
  return node.IsScalar() ? text::quoted(node.Scalar()) : "nothing";
}

Node YamlReader::find(const Node& map, std::string_view what, const char* key) const {
  if (!map.IsMap()) fail_here(map, fmt::format("{}: found {}, expected keys and values below it", what, kind(map)));
  return map[key];
}

void YamlReader::for_each(const Node& map, std::string_view what,
                          const std::function<void(const Node& key, const Node& value)>& visit) const {
  if (!map.IsMap()) fail_here(map, fmt::format("{}: found {}, expected keys and values below it", what, kind(map)));
  std::vector<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) fail_here(entry.first, fmt::format("found {}, expected a key", kind(entry.first)));
    const std::string& key = entry.first.Scalar();
    if (std::ranges::find(seen, key) != seen.end())
      fail_here(entry.first, fmt::format("{} is given twice", text::quoted(key)));
    seen.push_back(key);
    visit(entry.first, entry.second);
  }
}

void YamlReader::section(const Node& map, std::string_view what, const std::vector<YamlKey>& keys) const {
  for_each(map, what, [&](const Node& key, const Node& value) {
    const auto at = std::ranges::find(keys, key.Scalar(), &YamlKey::name);
    if (at == keys.end()) {
      std::vector<std::string> known;
      for (const YamlKey& k : keys) known.push_back(k.name);
      fail_unknown_key(key, what, known);
    }
    at->read(value);
  });
}

std::string YamlReader::text(std::string_view key, const Node& value) const {
  if (!value.IsScalar()) fail_here(value, fmt::format("{}: found {}, expected text", key, kind(value)));
  return value.Scalar();
}

bool YamlReader::flag(std::string_view key, const Node& value) const {
  const std::vector<std::string> words{"true", "false", "yes", "no", "on", "off"};
  return one_of(key, value, words) % 2 == 0;
}

int YamlReader::whole(std::string_view key, const Node& value, int lowest, int highest) const {
  const std::string words = text(key, value);
  int number = 0;
  const auto [end, error] = std::from_chars(words.data(), words.data() + words.size(), number);
  const bool read = error == std::errc{} && end == words.data() + words.size();
  if (read && number >= lowest && number <= highest) return number;
  fail_here(value, fmt::format("{}: found {}, expected a whole number from {} to {}", key, text::quoted(words), lowest,
                               highest));
}

double YamlReader::number(std::string_view key, const Node& value) const {
  double result = 0;
  if (text::parse_number(text(key, value), false, result) == text::Cell::number) return result;
  fail_here(value, fmt::format("{}: found {}, expected a plain number", key, text::quoted(value.Scalar())));
}

std::size_t YamlReader::one_of(std::string_view key, const Node& value, const std::vector<std::string>& words) const {
  const std::string word = text(key, value);
  const auto at = std::ranges::find(words, word);
  if (at != words.end()) return static_cast<std::size_t>(at - words.begin());
  fail_here(value, fmt::format("{}: found {}{}, expected {}", key, text::quoted(word), text::suggestion(word, words),
                               text::listing(words, "or")));
}

double YamlReader::quantity(std::string_view key, const Node& value, const noise::Dimension& expected,
                            Sign sign) const {
  if (!value.IsScalar()) {
    fail_here(value, fmt::format("{}: found {}, expected a number and a unit ({})", key, kind(value),
                                 noise::example_units(expected)));
  }
  double result = 0;
  try {
    result = noise::parse_quantity(value.Scalar(), expected);
  } catch (const std::invalid_argument& error) {
    fail_here(value, fmt::format("{}: {}", key, error.what()));
  }
  check_sign(key, value, result, sign);
  return result;
}

void YamlReader::check_sign(std::string_view key, const Node& value, double number, Sign sign) const {
  if (sign == Sign::any || number > 0 || (number == 0 && sign == Sign::not_negative)) return;
  fail_here(value, fmt::format("{}: found {}, expected a value {}", key, text::quoted(value.Scalar()),
                               sign == Sign::above_zero ? "above 0" : "of 0 or more"));
}

}  // namespace gyrobudget::inline v0::sensor_file
