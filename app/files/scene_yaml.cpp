// SPDX-License-Identifier: MIT
#include "scene_yaml.h"

#include "gyrobudget/app/log/calendar.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Vector3d;
using YAML::Node;

std::string path_from(const std::filesystem::path& folder, const std::string& path) {
  if (path == "-" || std::filesystem::path(path).is_absolute()) return path;
  return (folder / path).lexically_normal().string();
}

}  // namespace

SceneYaml::SceneYaml(const std::string& path, const std::string& data_folder)
    : sensor_file::YamlReader(path, "a scene", "site: alcantara", "imu:"),
      folder_(path == "-" ? std::filesystem::path() : std::filesystem::path(path).parent_path()),
      data_folder_(data_folder.empty() ? folder_ : std::filesystem::path(data_folder)) {}

double SceneYaml::time(std::string_view key, const Node& value, sensor_file::Sign sign) const {
  return quantity(key, value, noise::dimension::kTime, sign);
}

Vector3d SceneYaml::triple(std::string_view key, const Node& value, const noise::Dimension& d,
                           sensor_file::Sign sign) const {
  if (!value.IsSequence()) return Vector3d::Constant(quantity(key, value, d, sign));
  if (value.size() != 3)
    fail_here(value, fmt::format("{}: found a list of {}, expected one value or three", key, value.size()));
  return {quantity(key, value[0], d, sign), quantity(key, value[1], d, sign), quantity(key, value[2], d, sign)};
}

ClockEpoch SceneYaml::epoch(std::string_view key, const Node& node) const {
  const std::string written = text(key, node);
  std::string_view instant = text::trim(written);
  ClockEpoch epoch;
  for (const std::string_view scale : {"GPST", "UTC", "JST"}) {
    if (!instant.ends_with(scale)) continue;
    epoch.scale = scale;
    instant = text::trim(instant.substr(0, instant.size() - scale.size()));
  }
  const auto form = log::calendar_form(instant);
  const bool is_instant = form == log::StampForm::date_time || form == log::StampForm::date;
  if (!is_instant || log::parse_calendar(instant, *form, epoch.ns) != text::Cell::number)
    fail_here(node, fmt::format("{}: found {}, expected a date and a time of day, as in 2025-08-28 17:30:39 GPST", key,
                                text::quoted(written)));
  return epoch;
}

std::string SceneYaml::path(std::string_view key, const Node& value) const {
  return path_from(folder_, text(key, value));
}
std::string SceneYaml::data_path(std::string_view key, const Node& value) const {
  return path_from(data_folder_, text(key, value));
}

std::map<std::string, std::string> SceneYaml::columns(const Node& node, const std::vector<std::string>& known) const {
  std::map<std::string, std::string> result;
  for_each(node, "columns", [&](const Node& key, const Node& value) {
    if (std::ranges::find(known, key.Scalar()) == known.end()) fail_unknown_key(key, "columns", known);
    result[key.Scalar()] = text(key.Scalar(), value);
  });
  return result;
}

}  // namespace gyrobudget::inline v0::files
