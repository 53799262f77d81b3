// SPDX-License-Identifier: MIT
// Scenes: the aids.
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <utility>

#include "scene_columns.h"
#include "scene_yaml.h"

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Vector3d;
using navigation::Aid;
using navigation::Span;
using noise::Dimension;
using YAML::Node;
namespace dimension = noise::dimension;

using noise::dimension::kLength;

constexpr std::array kKinds{Aid::Kind::position, Aid::Kind::velocity, Aid::Kind::height, Aid::Kind::attitude,
                            Aid::Kind::rest};

Dimension dimension_of(Aid::Kind kind) {
  switch (kind) {
    case Aid::Kind::position:
    case Aid::Kind::height:
      return kLength;
    case Aid::Kind::attitude:
      return dimension::kAngle;
    case Aid::Kind::velocity:
    case Aid::Kind::rest:
      break;
  }
  return dimension::kVelocity;
}

/// Whether a name can be that of a file in a folder, which `simulate --fixes` makes of it.
bool is_file_name(const std::string& name) {
  constexpr std::size_t kLongest = 100;
  return !name.empty() && name.size() <= kLongest && !name.starts_with('.') &&
         std::ranges::none_of(name, [](char c) { return c == '/' || (c >= 0 && c < ' ') || c == '\x7f'; });
}

class AidsReader {
 public:
  AidsReader(const SceneYaml& yaml, SceneFile& scene) : yaml_(yaml), scene_(scene) {}

  void read(const Node& node) {
    yaml_.for_each(node, "aids", [&](const Node& key, const Node& value) {
      const std::string where = "aids." + key.Scalar();
      Device device;
      device.common.name = key.Scalar();
      if (!is_file_name(device.common.name))
        yaml_.fail_here(key, fmt::format("aids: found the name {}, expected one that a file can have, such as gnss",
                                         text::quoted(device.common.name)));
      Aid& common = device.common;
      std::vector<sensor_file::YamlKey> keys = use_keys(common);
      const auto add = [&](const char* name, std::function<void(const Node&)> read) {
        keys.push_back({name, std::move(read)});
      };
      add("file", [&](const Node& v) { device.source.path = yaml_.data_path("file", v); });
      add("topic", [&](const Node& v) { device.source.topic = yaml_.text("topic", v); });
      add("geoid_separation", [&](const Node& v) {
        device.source.geoid_separation = yaml_.quantity("geoid_separation", v, kLength, sensor_file::Sign::any);
      });
      add("quality", [&](const Node& v) { device.source.quality = numbers("quality", v); });
      add("columns", [&](const Node& v) { device.source.columns = yaml_.columns(v, aid_column_names()); });
      add("rate", [&](const Node& v) {
        common.rate = yaml_.quantity("rate", v, dimension::kFrequency, sensor_file::Sign::above_zero);
      });
      add("lever_arm", [&](const Node& v) { common.lever_arm = lever_arm(v); });
      add("lever_arm_sigma", [&](const Node& v) {
        common.lever_arm_sigma = yaml_.triple("lever_arm_sigma", v, kLength, sensor_file::Sign::not_negative);
      });
      add("time_tag", [&](const Node& v) { common.time_tag = yaml_.time("time_tag", v, sensor_file::Sign::any); });
      add("time_tag_sigma", [&](const Node& v) {
        common.time_tag_sigma = yaml_.time("time_tag_sigma", v, sensor_file::Sign::not_negative);
      });
      add("clocks", [&](const Node& v) { device.one_clock = yaml_.one_of("clocks", v, {"one", "each"}) == 0; });
      for (const Aid::Kind kind : kKinds) {
        keys.push_back({std::string(navigation::name(kind)),
                        [&device, kind](const Node& v) { device.measures.emplace_back(kind, v); }});
      }
      yaml_.section(value, where, keys);
      if (device.measures.empty())
        yaml_.fail_here(
            value,
            fmt::format("{}: found nothing that it measures, expected position, velocity, height, attitude or rest",
                        where));
      for (const auto& [kind, v] : device.measures) add_aid(device, kind, v);
    });
  }

 private:
  // What a device says once for all it measures.
  struct Device {
    AidSource source;
    Aid common;
    bool one_clock = true;
    std::vector<std::pair<Aid::Kind, Node>> measures;
  };

  std::vector<sensor_file::YamlKey> use_keys(Aid& aid) const {
    return {{"from", [this, &aid](const Node& v) { aid.valid.from = yaml_.time("from", v, sensor_file::Sign::any); }},
            {"until", [this, &aid](const Node& v) { aid.valid.to = yaml_.time("until", v, sensor_file::Sign::any); }},
            {"outages", [this, &aid](const Node& v) { aid.outages = spans("outages", v); }},
            {"used", [this, &aid](const Node& v) { aid.used = yaml_.flag("used", v); }}};
  }

  [[nodiscard]] std::vector<Span> spans(std::string_view key, const Node& node) const {
    const auto refuse = [&](const Node& at) {
      yaml_.fail_here(at, fmt::format("{}: found {}, expected pairs of times as in [[60 s, 120 s]]", key,
                                      sensor_file::YamlReader::kind(at)));
    };
    if (!node.IsSequence()) refuse(node);
    std::vector<Span> result;
    for (const Node& pair : node) {
      if (!pair.IsSequence() || pair.size() != 2) refuse(pair);
      const Span span{yaml_.time(key, pair[0], sensor_file::Sign::any),
                      yaml_.time(key, pair[1], sensor_file::Sign::any)};
      if (span.to < span.from)
        yaml_.fail_here(pair, fmt::format("{}: ends at {:g} s, before it begins at {:g} s", key, span.to, span.from));
      result.push_back(span);
    }
    return result;
  }

  /// One, or a list.
  [[nodiscard]] std::vector<double> numbers(std::string_view key, const Node& node) const {
    if (!node.IsSequence()) return {yaml_.number(key, node)};
    std::vector<double> result;
    for (const Node& one : node) result.push_back(yaml_.number(key, one));
    if (result.empty()) yaml_.fail_here(node, fmt::format("{}: found an empty list, expected numbers", key));
    return result;
  }

  [[nodiscard]] Vector3d lever_arm(const Node& v) const {
    if (!v.IsSequence())
      yaml_.fail_here(v, fmt::format("lever_arm: found {}, expected [forward, right, down] as in [0.2 m, 0 m, -1 m]",
                                     sensor_file::YamlReader::kind(v)));
    return yaml_.triple("lever_arm", v, kLength, sensor_file::Sign::any);
  }

  void add_aid(const Device& device, Aid::Kind kind, const Node& node) {
    Aid aid = device.common;
    aid.kind = kind;
    aid.name = fmt::format("{}.{}", device.common.name, navigation::name(kind));
    const Dimension d = dimension_of(kind);
    bool sigma = true;
    AidSource source = device.source;
    const auto read_sigma = [&](const Node& v) {
      sigma = true;
      source.sigma_from_file = v.IsScalar() && v.Scalar() == "file";
      if (source.sigma_from_file) return check_sigma_of_file(aid, source, v);
      aid.sigma = yaml_.triple("sigma", v, d, sensor_file::Sign::above_zero);
    };
    if (node.IsMap()) {
      sigma = false;
      std::vector<sensor_file::YamlKey> keys = use_keys(aid);
      keys.push_back({"sigma", read_sigma});
      keys.push_back({"bias_sigma", [&](const Node& v) {
                        aid.bias_sigma = yaml_.triple("bias_sigma", v, d, sensor_file::Sign::not_negative);
                      }});
      keys.push_back({"correlated", [&](const Node& v) { read_correlated(v, d, aid); }});
      yaml_.section(node, "aids." + aid.name, keys);
    } else {
      read_sigma(node);
    }
    if (!sigma) yaml_.fail_here(node, fmt::format("aids.{}: found no \"sigma:\", expected its white noise", aid.name));
    if (device.one_clock && kind != Aid::Kind::rest) aid.clock = device.common.name;
    if (kind == Aid::Kind::rest) source = {};
    scene_.scenario.aids.push_back(std::move(aid));
    scene_.aids.push_back(std::move(source));
  }

  // Errors that each fix has of its own are there where it was recorded.
  void check_sigma_of_file(const Aid& aid, const AidSource& source, const Node& node) const {
    const bool can =
        aid.kind == Aid::Kind::position || aid.kind == Aid::Kind::velocity || aid.kind == Aid::Kind::height;
    const Node& root = yaml_.root();
    const bool is_planned = !root["imu"] || root["trajectory"] || root["flight"];
    if (can && !source.path.empty() && !is_planned) return;
    yaml_.fail_here(node, fmt::format("aids.{}: found sigma: file, expected {}", aid.name,
                                      !can ? "numbers: only positions, heights and velocities have theirs in a file"
                                      : is_planned ? "numbers: where nothing was recorded there is no file with them"
                                                   : "\"file:\" in the aid, whose columns have them"));
  }

  void read_correlated(const Node& node, const Dimension& d, Aid& aid) const {
    bool both[2] = {false, false};
    yaml_.section(node, "correlated",
                  {{"sigma",
                    [&](const Node& v) {
                      aid.correlated_sigma = yaml_.triple("sigma", v, d, sensor_file::Sign::not_negative);
                      both[0] = true;
                    }},
                   {"time", [&](const Node& v) {
                      aid.correlation_time = yaml_.time("time", v, sensor_file::Sign::above_zero);
                      both[1] = true;
                    }}});
    if (!both[0] || !both[1]) yaml_.fail_here(node, "correlated: expected both, as in {sigma: 1 m, time: 5 min}");
  }

  const SceneYaml& yaml_;
  SceneFile& scene_;
};

}  // namespace

void read_aids(const SceneYaml& yaml, const Node& node, SceneFile& scene) { AidsReader(yaml, scene).read(node); }

}  // namespace gyrobudget::inline v0::files
