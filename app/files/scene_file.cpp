// SPDX-License-Identifier: MIT
// Scenes: the keys of the test card.
#include "scene_file.h"

#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/vehicle/earth/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "scene_columns.h"
#include "scene_yaml.h"
#include "temperature_profile.h"
#include "trajectory_file.h"
#include "trajectory_spec.h"

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Vector3d;
using navigation::Aid;
using navigation::FromAid;
using YAML::Node;
namespace dimension = noise::dimension;

using noise::dimension::kLength;

constexpr std::string_view kIdeal = "ideal";  // in place of a sensor file

// The scene's epoch in place of the sensor file's.
void set_epoch(SceneFile& scene) {
  const auto set = [&](noise::ErrorModel& errors) {
    if (scene.powered_on_before) errors.powered_on_before = scene.powered_on_before;
    if (scene.calibrated_over) errors.calibrated_over = scene.calibrated_over;
  };
  set(scene.scenario.sensor.gyro);
  if (scene.scenario.sensor.accelerometer) set(*scene.scenario.sensor.accelerometer);
}

// The sensor of the scene's own file.
void load(SceneFile& scene) {
  sensor_file::SensorFile file = sensor_file::read_sensor_file(scene.sensor, {.rate_hz = scene.sensor_rate_hz});
  scene.scenario.sensor = std::move(file.model);
  scene.sensor_warnings = std::move(file.warnings);
  scene.sensor_notes = std::move(file.notes);
}

class SceneReader {
 public:
  SceneReader(const std::string& path, const std::string& data_folder) : yaml_(path, data_folder) {}

  SceneFile read() {
    const Node& root = yaml_.root();
    recorded_ = root["imu"].IsDefined();
    result_.path = yaml_.name();
    if (root["site"]) read_site(root["site"]);  // others refer to these two
    if (root["aids"]) read_aids(yaml_, root["aids"], result_);
    const auto done = [](const Node&) {};
    yaml_.section(
        root, "a scene",
        {{"name", [&](const Node& v) { scenario().name = text::printable(yaml_.text("name", v)); }},
         {"site", done},
         {"azimuth",
          [&](const Node& v) {
            scenario().azimuth = yaml_.quantity("azimuth", v, dimension::kAngle, sensor_file::Sign::any);
          }},
         {"trajectory", [&](const Node& v) { read_trajectory_key(v); }},
         {"flight", [&](const Node& v) { result_.flight = read_flight(yaml_, v); }},
         {"imu", [&](const Node& v) { read_imu(v); }},
         {"sensor", [&](const Node& v) { read_sensor_key(v); }},
         {"states", [&](const Node& v) { read_states(v); }},
         {"alignment", [&](const Node& v) { read_alignment(v); }},
         {"aids", done},
         {"world", [&](const Node& v) { read_world(v); }},
         {"filter", [&](const Node& v) { read_filter(v); }},
         {"until", [&](const Node& v) { scenario().until = yaml_.time("until", v, sensor_file::Sign::above_zero); }},
         {"solution", [&](const Node& v) { read_solution(v); }},
         {"reference", [&](const Node& v) { read_reference(v); }}});
    if (!result_.imu && result_.trajectory.empty() && !result_.flight)
      yaml_.fail_here(root,
                      "found none of \"imu:\", \"trajectory:\" and \"flight:\", expected one of them: what moves");
    if (result_.flight) finish_flight(root["flight"]);
    if (result_.imu && !root["alignment"])
      yaml_.fail_here(root, "found no \"alignment:\", expected one: where navigation starts from");
    return std::move(result_);
  }

 private:
  navigation::Scenario& scenario() { return result_.scenario; }

  // --- Site ---

  [[nodiscard]] earth::Geodetic place(std::string_view where, const Node& node) const {
    std::optional<double> latitude, longitude, height;
    yaml_.section(
        node, where,
        {{"latitude",
          [&](const Node& v) {
            latitude = yaml_.quantity("latitude", v, dimension::kAngle, sensor_file::Sign::any);
            if (std::abs(*latitude) > 90 * earth::kDegree)
              yaml_.fail_here(v, fmt::format("latitude: found {}, expected -90 to 90 deg", text::quoted(v.Scalar())));
          }},
         {"longitude",
          [&](const Node& v) {
            longitude = yaml_.quantity("longitude", v, dimension::kAngle, sensor_file::Sign::any);
          }},
         {"height", [&](const Node& v) { height = yaml_.quantity("height", v, kLength, sensor_file::Sign::any); }}});
    if (!latitude || !longitude || !height)
      yaml_.fail_here(node, fmt::format("{}: expected latitude, longitude and height, found not all of them", where));
    return {*latitude, *longitude, *height};
  }

  void read_site(const Node& node) {
    if (!node.IsScalar()) {
      scenario().site = place("site", node);
      return;
    }
    std::vector<std::string> names;
    for (const earth::Site& site : earth::sites()) names.emplace_back(site.name);
    if (std::ranges::find(names, node.Scalar()) == names.end())
      yaml_.fail_here(node, fmt::format("site: found {}{}, expected {} or {{latitude, longitude, height}}",
                                        text::quoted(node.Scalar()), text::suggestion(node.Scalar(), names),
                                        text::listing(names, "or")));
    scenario().site = earth::find_site(node.Scalar()).position;
  }

  // --- What moves ---

  void read_trajectory_key(const Node& node) {
    const std::string text = yaml_.text("trajectory", node);
    try {
      result_.trajectory = is_named_trajectory(text) ? text : yaml_.path("trajectory", node);
    } catch (const std::invalid_argument& error) {
      yaml_.fail_here(node, error.what());
    }
  }

  void read_imu(const Node& node) {
    ImuSource imu;
    yaml_.section(node, "imu",
                  {{"file", [&](const Node& v) { imu.path = yaml_.data_path("file", v); }},
                   {"topic", [&](const Node& v) { imu.topic = yaml_.text("topic", v); }},
                   {"epoch", [&](const Node& v) { imu.epoch = yaml_.epoch("epoch", v); }},
                   {"columns", [&](const Node& v) { imu.columns = yaml_.columns(v, imu_column_names()); }},
                   {"axes", [&](const Node& v) { read_axes(v, imu); }},
                   {"rate",
                    [&](const Node& v) {
                      imu.rate_hz = yaml_.quantity("rate", v, dimension::kFrequency, sensor_file::Sign::above_zero);
                    }},
                   {"stamp",
                    [&](const Node& v) {
                      imu.stamp = yaml_.one_of("stamp", v, {"end", "start"}) == 0 ? navigation::StampAt::end
                                                                                  : navigation::StampAt::start;
                    }},
                   {"samples", [&](const Node& v) {
                      imu.instants = yaml_.one_of("samples", v, {"mean", "instant"}) == 1;
                    }}});
    if (imu.path.empty()) yaml_.fail_here(node, "imu: found no \"file:\", expected the log's path");
    result_.imu = std::move(imu);
  }

  // [y, x, -z]: a turn of the axes, no mirror.
  void read_axes(const Node& node, ImuSource& imu) const {
    const auto refuse = [&](const std::string& found) {
      yaml_.fail_here(
          node,
          fmt::format(
              "axes: found {}, expected the log's axes that point forward, right, down, as in [x, y, z] or [y, x, -z]",
              found));
    };
    if (!node.IsSequence() || node.size() != 3) refuse(sensor_file::YamlReader::kind(node));
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string word = yaml_.text("axes", node[i]);
      const bool negative = word.starts_with('-');
      const std::string letter = word.substr(negative || word.starts_with('+') ? 1 : 0);
      if (letter != "x" && letter != "y" && letter != "z") refuse(text::quoted(word));
      imu.axis[i] = letter[0] - 'x';
      imu.sign[i] = negative ? -1 : 1;
      turn(static_cast<Eigen::Index>(i), imu.axis[i]) = imu.sign[i];
    }
    if (turn.determinant() == 0) refuse("an axis twice");
    if (turn.determinant() < 0) refuse("a mirror (left-handed axes; a sign or an order is wrong)");
  }

  void finish_flight(const Node& node) {
    if (!result_.trajectory.empty())
      yaml_.fail_here(node, "found \"flight:\" and \"trajectory:\", expected one of them: what moves");
    if (!scenario().site)
      yaml_.fail_here(node, "found no site, expected \"site:\" in the scene: where the flight begins");
    constexpr double kLongest = 3600;  // [s] of one stage
    if (std::isfinite(scenario().until) && scenario().until > kLongest)
      yaml_.fail_here(yaml_.root()["until"],
                      fmt::format("until: a flight lasts at most {:g} s, found {:g} s", kLongest, scenario().until));
    place_flight(*result_.flight, scenario());
  }

  // --- Sensor and states ---

  void read_sensor_key(const Node& node) {
    if (node.IsScalar()) {
      load_sensor(node);
      return;
    }
    if (!yaml_.find(node, "sensor", "file"))
      yaml_.fail_here(node, "sensor: found no \"file:\", expected the sensor file's path");
    yaml_.section(node, "sensor",
                  {{"file", [](const Node&) {}},  // behind what tells how to read it
                   {"rate",
                    [&](const Node& v) {
                      result_.sensor_rate_hz =
                          yaml_.quantity("rate", v, dimension::kFrequency, sensor_file::Sign::above_zero);
                    }},
                   {"powered_on_before",
                    [&](const Node& v) {
                      result_.powered_on_before = yaml_.time("powered_on_before", v, sensor_file::Sign::not_negative);
                    }},
                   {"calibrated_over",
                    [&](const Node& v) {
                      result_.calibrated_over = yaml_.time("calibrated_over", v, sensor_file::Sign::above_zero);
                    }},
                   {"temperature", [&](const Node& v) { read_temperature(v); }},
                   {"vibration", [&](const Node& v) {
                      scenario().states.vibration =
                          yaml_.quantity("vibration", v, dimension::kSpecificForce, sensor_file::Sign::not_negative);
                    }}});
    load_sensor(node["file"]);
    set_epoch(result_);
  }

  void read_temperature(const Node& node) {
    std::string text = yaml_.text("temperature", node);
    const bool words = text.find('=') != std::string::npos || text.find_first_of("0123456789+-") == 0;
    if (!words) text = yaml_.path("temperature", node);
    try {
      scenario().states.temperature = temperature_profile(text);
    } catch (const std::invalid_argument& error) {
      yaml_.fail_here(node, fmt::format("temperature: {}", error.what()));
    }
  }

  void load_sensor(const Node& node) {
    const std::string text = yaml_.text("sensor", node);
    if (text == kIdeal) return;
    result_.sensor = yaml_.path("sensor", node);
    try {
      load(result_);
    } catch (const text::InputError& error) {  // its own place, behind that of the line which named it
      yaml_.fail_here(node, fmt::format("sensor: {}", error.what()));
    }
  }

  void read_states(const Node& node) {
    auto& states = scenario().states;
    const auto use = [this](std::string_view key, const Node& v) {
      constexpr std::array kUses{navigation::Use::estimated, navigation::Use::considered, navigation::Use::left_out};
      return kUses.at(yaml_.one_of(key, v, {"estimated", "considered", "left_out"}));
    };
    constexpr int kMostFlickerStates = 6;
    yaml_.section(
        node, "states",
        {{"flicker", [&](const Node& v) { states.flicker_states = yaml_.whole("flicker", v, 0, kMostFlickerStates); }},
         {"tolerance",
          [&](const Node& v) {
            states.tolerance = yaml_.quantity("tolerance", v, dimension::kNumber, sensor_file::Sign::above_zero);
          }},
         {"scale_factor", [&](const Node& v) { states.scale_factor = use("scale_factor", v); }},
         {"misalignment", [&](const Node& v) { states.misalignment = use("misalignment", v); }},
         {"g_sensitivity", [&](const Node& v) { states.g_sensitivity = use("g_sensitivity", v); }}});
  }

  void read_world(const Node& node) {
    yaml_.section(node, "world",
                  {{"gravity",
                    [&](const Node& v) {
                      scenario().gravity_sigma =
                          yaml_.quantity("gravity", v, dimension::kSpecificForce, sensor_file::Sign::not_negative);
                    }},
                   {"deflection", [&](const Node& v) {
                      scenario().deflection_sigma =
                          yaml_.quantity("deflection", v, dimension::kAngle, sensor_file::Sign::not_negative);
                    }}});
  }

  // --- Alignment ---

  // The aid of a device that measures this.
  [[nodiscard]] FromAid aid_named(std::string_view key, const Node& node, Aid::Kind kind) const {
    const std::string name = fmt::format("{}.{}", node.Scalar(), navigation::name(kind));
    std::vector<std::string> devices;
    for (std::size_t i = 0; i < result_.scenario.aids.size(); ++i) {
      const Aid& aid = result_.scenario.aids[i];
      if (aid.name == name) return {i};
      if (aid.kind == kind) devices.push_back(aid.name.substr(0, aid.name.rfind('.')));
    }
    yaml_.fail_here(node, fmt::format("{}: {} is no aid that measures {}{}; {}", key, text::quoted(node.Scalar()),
                                      navigation::name(kind), text::suggestion(node.Scalar(), devices),
                                      devices.empty() ? "there is none" : "there are " + text::listing(devices)));
  }

  void read_alignment(const Node& node) {
    auto& a = scenario().alignment;
    const auto sigma = [this](std::string_view key, const Node& v) {
      return yaml_.quantity(key, v, dimension::kAngle, sensor_file::Sign::above_zero);
    };
    std::optional<double> duration, heading;
    bool self = false;
    yaml_.section(
        node, "alignment",
        {{"start", [&](const Node& v) { a.start = yaml_.time("start", v, sensor_file::Sign::any); }},
         {"position", [&](const Node& v) { read_position(v); }},
         {"position_sigma",
          [&](const Node& v) {
            a.position_sigma = yaml_.triple("position_sigma", v, kLength, sensor_file::Sign::not_negative);
          }},
         {"velocity", [&](const Node& v) { read_velocity(v); }},
         {"velocity_sigma",
          [&](const Node& v) {
            a.velocity_sigma = yaml_.triple("velocity_sigma", v, dimension::kVelocity, sensor_file::Sign::not_negative);
          }},
         {"attitude", [&](const Node& v) { self = read_attitude(v); }},
         {"duration", [&](const Node& v) { duration = yaml_.time("duration", v, sensor_file::Sign::above_zero); }},
         {"heading",
          [&](const Node& v) { heading = yaml_.quantity("heading", v, dimension::kAngle, sensor_file::Sign::any); }},
         {"level_sigma", [&](const Node& v) { a.level_sigma = sigma("level_sigma", v); }},
         {"heading_sigma", [&](const Node& v) { a.heading_sigma = sigma("heading_sigma", v); }}});
    if (!self && (duration || heading))
      yaml_.fail_here(node, "alignment: duration and heading belong to \"attitude: self\"");
    if (heading && !a.heading_sigma) yaml_.fail_here(node, "alignment: a heading needs its heading_sigma beside it");
    if (self) {
      navigation::SelfAlignment with;
      with.duration = duration.value_or(with.duration);
      with.heading = heading;
      a.attitude = with;
    }
    if (!recorded_) return;  // a trajectory knows its start; what has no sigma is exact
    if (!node["position"]) position_from_site(node);
    if (!node["attitude"])
      yaml_.fail_here(
          node, "alignment: found no \"attitude:\", expected self, the name of an aid, or {heading, pitch, roll}");
    check_sigmas(node);
  }

  // Nothing that a person states is exact.
  void check_sigmas(const Node& node) {
    const auto& a = scenario().alignment;
    const auto need = [&](bool there, bool needed, const char* what, const char* example) {
      if (needed && !there)
        yaml_.fail_here(node, fmt::format("alignment: found no \"{0}:\", expected how well it is known, as in {0}: {1}",
                                          what, example));
    };
    const auto is_given = [](const auto& v) { return !std::holds_alternative<FromAid>(v); };
    need(a.position_sigma.has_value(), is_given(a.position), "position_sigma", "5 m");
    need(a.velocity_sigma.has_value(), is_given(a.velocity), "velocity_sigma", "1 cm/s");
    const bool euler = std::holds_alternative<earth::Euler>(a.attitude);
    need(a.level_sigma.has_value(), euler, "level_sigma", "0.1 deg");
    need(a.heading_sigma.has_value(), euler, "heading_sigma", "1 deg");
  }

  void position_from_site(const Node& node) {
    if (!scenario().site)
      yaml_.fail_here(node, "found no site, expected \"site:\" in the scene, or a position in the alignment");
    scenario().alignment.position = *scenario().site;
  }

  void read_position(const Node& v) {
    auto& position = scenario().alignment.position;
    if (!v.IsScalar())
      position = place("position", v);
    else if (v.Scalar() == "site")
      position_from_site(v);
    else
      position = aid_named("position", v, Aid::Kind::position);
  }

  void read_velocity(const Node& node) {
    auto& velocity = scenario().alignment.velocity;
    if (node.IsScalar() && node.Scalar() == "rest") {
      velocity = Vector3d(0, 0, 0);
      return;
    }
    if (node.IsScalar()) {
      velocity = aid_named("velocity", node, Aid::Kind::velocity);
      return;
    }
    Vector3d v = Vector3d::Zero();
    const auto component = [&](const char* key, Eigen::Index i) {
      return sensor_file::YamlKey{key, [this, key, i, &v](const Node& value) {
                                    v[i] = yaml_.quantity(key, value, dimension::kVelocity, sensor_file::Sign::any);
                                  }};
    };
    yaml_.section(node, "velocity", {component("north", 0), component("east", 1), component("down", 2)});
    velocity = v;
  }

  // True for self-alignment.
  bool read_attitude(const Node& node) {
    auto& attitude = scenario().alignment.attitude;
    if (node.IsScalar() && node.Scalar() == "self") return true;
    if (node.IsScalar()) {
      attitude = aid_named("attitude", node, Aid::Kind::attitude);
      return false;
    }
    earth::Euler euler;
    const auto angle = [&](const char* key, double& value) {
      return sensor_file::YamlKey{key, [this, key, &value](const Node& v) {
                                    value = yaml_.quantity(key, v, dimension::kAngle, sensor_file::Sign::any);
                                  }};
    };
    yaml_.section(node, "attitude",
                  {angle("heading", euler.yaw), angle("pitch", euler.pitch), angle("roll", euler.roll)});
    attitude = euler;
    return false;
  }

  // --- Filter, solution, reference ---

  void read_filter(const Node& node) {
    auto& filter = scenario().filter;
    constexpr std::array kForms{navigation::Form::automatic, navigation::Form::plain, navigation::Form::joseph,
                                navigation::Form::square_root};
    yaml_.section(
        node, "filter",
        {{"form",
          [&](const Node& v) {
            filter.form = kForms.at(yaml_.one_of("form", v, {"automatic", "plain", "joseph", "square_root"}));
          }},
         {"gate",
          [&](const Node& v) {
            filter.gate_false_alarm = yaml_.number("gate", v);
            if (!(filter.gate_false_alarm >= 0 && filter.gate_false_alarm < 1))
              yaml_.fail_here(
                  v, fmt::format("gate: found {}, expected a share from 0 to below 1", text::quoted(v.Scalar())));
          }},
         {"covariance_interval",
          [&](const Node& v) {
            filter.covariance_interval = yaml_.time("covariance_interval", v, sensor_file::Sign::not_negative);
          }},
         {"robust", [&](const Node& v) { read_robust(v); }},
         {"recovery", [&](const Node& v) { scenario().recovery = yaml_.flag("recovery", v); }},
         {"order",
          [&](const Node& v) {
            filter.strapdown.order = yaml_.whole("order", v, 1, navigation::Strapdown::kHighestOrder);
          }},
         {"earth_rate",
          [&](const Node& v) { filter.strapdown.earth_rate_in_attitude = yaml_.flag("earth_rate", v); }}});
  }

  // none, or {huber: 1.5}, or {student: 4}.
  void read_robust(const Node& node) {
    navigation::Robust& robust = scenario().filter.robust;
    if (node.IsScalar() && node.Scalar() == "none") return;
    if (!node.IsMap() || node.size() != 1)
      yaml_.fail_here(node, fmt::format("robust: found {}, expected none, {{huber: 1.5}} or {{student: 4}}",
                                        sensor_file::YamlReader::kind(node)));
    const auto read = [&](navigation::Robust::Kind kind) {
      return [this, &robust, kind](const Node& v) {
        robust = {kind, yaml_.number("robust", v)};
        if (!(robust.parameter > 0 && std::isfinite(robust.parameter)))
          yaml_.fail_here(v, fmt::format("robust: found {}, expected a number above 0", text::quoted(v.Scalar())));
      };
    };
    yaml_.section(
        node, "robust",
        {{"huber", read(navigation::Robust::Kind::huber)}, {"student", read(navigation::Robust::Kind::student)}});
  }

  void read_solution(const Node& node) {
    yaml_.section(node, "solution",
                  {{"rate",
                    [&](const Node& v) {
                      scenario().solution_interval =
                          1 / yaml_.quantity("rate", v, dimension::kFrequency, sensor_file::Sign::above_zero);
                    }},
                   {"smooth",
                    [&](const Node& v) {
                      scenario().smooth = yaml_.one_of("smooth", v, {"no", "yes"}) == 1;
                    }},
                   {"at", [&](const Node& v) {
                      if (!v.IsSequence()) {
                        scenario().at = {yaml_.time("at", v, sensor_file::Sign::any)};
                        return;
                      }
                      scenario().at.clear();
                      for (const Node& one : v) scenario().at.push_back(yaml_.time("at", one, sensor_file::Sign::any));
                    }}});
  }

  void read_reference(const Node& node) {
    constexpr std::array kCompared{Aid::Kind::position, Aid::Kind::velocity, Aid::Kind::attitude};
    auto& reference = scenario().reference;
    if (node.IsScalar()) {
      std::vector<std::string> devices;
      for (std::size_t i = 0; i < scenario().aids.size(); ++i) {
        const Aid& aid = scenario().aids[i];
        devices.push_back(aid.name.substr(0, aid.name.rfind('.')));
        const bool compared = std::ranges::find(kCompared, aid.kind) != kCompared.end();
        if (compared && devices.back() == node.Scalar()) reference.push_back(i);
      }
      if (reference.empty())
        yaml_.fail_here(
            node,
            fmt::format(
                "reference: {} is no aid that measures position, velocity or attitude{}; a file goes below it: {{file: truth.csv}}",
                text::quoted(node.Scalar()), text::suggestion(node.Scalar(), devices)));
      return;
    }
    AidSource source;
    yaml_.section(node, "reference",
                  {{"file", [&](const Node& v) { source.path = yaml_.data_path("file", v); }},
                   {"columns", [&](const Node& v) { source.columns = yaml_.columns(v, aid_column_names()); }}});
    if (source.path.empty()) yaml_.fail_here(node, "reference: found no \"file:\", expected the path of a CSV");
    for (const Aid::Kind kind : kCompared) {
      Aid aid;
      aid.kind = kind;
      aid.name = fmt::format("reference.{}", navigation::name(kind));
      aid.used = false;
      reference.push_back(scenario().aids.size());
      scenario().aids.push_back(aid);
      result_.aids.push_back(source);
    }
  }

  SceneYaml yaml_;
  bool recorded_ = false;  ///< an IMU log, not a trajectory
  SceneFile result_;
};

}  // namespace

SceneFile read_scene(const std::string& path, const std::string& data_folder) {
  return SceneReader(path, data_folder).read();
}

void change_sensor(SceneFile& scene, const std::string& path) {
  scene.sensor = path == kIdeal ? std::string() : path;
  scene.scenario.sensor = {};
  scene.sensor_warnings.clear();
  scene.sensor_notes.clear();
  if (!scene.sensor.empty()) load(scene);
  set_epoch(scene);
}

earth::Trajectory planned_trajectory(const SceneFile& scene) {
  if (!scene.flight && scene.trajectory.empty())
    throw text::InputError(fmt::format(
        "{}: found neither a trajectory nor a flight, expected 'trajectory: ascent', the path of a CSV, or 'flight: {{vehicle: vlm1.yaml}}'",
        scene.path));
  if (!scene.flight) return read_trajectory(scene.trajectory);
  const flight::FlightRecord nominal = fly_nominal(scene.flight->plan);
  if (!flight::makes_a_trajectory(nominal))
    throw text::InputError(fmt::format("{}: the flight of {} is too short for a trajectory: it {}", scene.path,
                                       scene.flight->vehicle.path, nominal.account));
  return trajectory(nominal);
}

bool is_scene(std::string_view path) { return path.ends_with(".yaml") || path.ends_with(".yml"); }

earth::Trajectory scene_or_trajectory(const std::string& name_or_path) {
  return is_scene(name_or_path) ? planned_trajectory(read_scene(name_or_path)) : read_trajectory(name_or_path);
}

}  // namespace gyrobudget::inline v0::files
