// SPDX-License-Identifier: MIT
#include "vehicle_file.h"

#include "gyrobudget/app/sensor_file/yaml_reader.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>
#include <variant>

namespace gyrobudget::inline v0::files {
namespace {

using flight::Actuator;
using flight::Bending;
using flight::LookupTable;
using flight::Origin;
using flight::Vehicle;
using noise::Dimension;
using YAML::Node;
namespace dimension = noise::dimension;

constexpr Dimension kPerAngle{-2, 0, 0}, kAnglePerLength{2, -2, 0};

// --- The keys ----------------------------------------------------------------------------------------------

using Member = std::variant<double Vehicle::*, flight::LookupTable Vehicle::*, double Actuator::*, double Bending::*,
                            flight::LookupTable Bending::*>;

/// The abscissa of a table.
struct Over {
  std::string_view name;
  double highest;  ///< the lowest is 0
};
constexpr Over kBurn{"a burn fraction", 1}, kPropellant{"a propellant fraction", 1}, kMach{"a Mach number", 1000};

struct Entry {
  std::string_view key;  ///< actuator.frequency is frequency below actuator
  Member member;
  Dimension dimension;
  sensor_file::Sign sign;
  std::string_view left_out;  ///< what leaving it out means; empty: it is needed, of bending where there is any
  Over over{};
};
constexpr std::string_view kBending = "bending";

constexpr std::array kEntries{
    Entry{"lift_off_mass", &Vehicle::lift_off_mass, dimension::kMass, sensor_file::Sign::above_zero, ""},
    Entry{"propellant", &Vehicle::propellant, dimension::kMass, sensor_file::Sign::not_negative, ""},
    Entry{"burn_time", &Vehicle::burn_time, dimension::kTime, sensor_file::Sign::above_zero, ""},
    Entry{"specific_impulse", &Vehicle::specific_impulse, dimension::kTime, sensor_file::Sign::not_negative, ""},
    Entry{"thrust_shape", &Vehicle::thrust_shape, dimension::kNumber, sensor_file::Sign::not_negative,
          "constant thrust", kBurn},
    Entry{"exit_area", &Vehicle::exit_area, dimension::kArea, sensor_file::Sign::not_negative, "no back-pressure"},
    Entry{"reference_area", &Vehicle::reference_area, dimension::kArea, sensor_file::Sign::not_negative,
          "no aerodynamic forces"},
    Entry{"axial_drag", &Vehicle::axial_drag, dimension::kNumber, sensor_file::Sign::any, "no drag", kMach},
    Entry{"normal_force_slope", &Vehicle::normal_force_slope, kPerAngle, sensor_file::Sign::any, "no normal force"},
    Entry{"pressure_ahead", &Vehicle::pressure_ahead, dimension::kLength, sensor_file::Sign::any,
          "centre of pressure at the centre of mass"},
    Entry{"centre_of_mass", &Vehicle::centre_of_mass, dimension::kLength, sensor_file::Sign::any, "", kPropellant},
    Entry{"roll_inertia", &Vehicle::roll_inertia, dimension::kInertia, sensor_file::Sign::above_zero, "", kPropellant},
    Entry{"pitch_inertia", &Vehicle::pitch_inertia, dimension::kInertia, sensor_file::Sign::above_zero, "",
          kPropellant},
    Entry{"yaw_inertia", &Vehicle::yaw_inertia, dimension::kInertia, sensor_file::Sign::above_zero, "as pitch_inertia",
          kPropellant},
    Entry{"imu_station", &Vehicle::imu_station, dimension::kLength, sensor_file::Sign::any,
          "where the centre of mass is at lift-off"},
    Entry{"actuator.frequency", &Actuator::frequency, dimension::kFrequency, sensor_file::Sign::above_zero, "4 Hz"},
    Entry{"actuator.damping", &Actuator::damping, dimension::kNumber, sensor_file::Sign::above_zero, "0.7"},
    Entry{"actuator.deflection_limit", &Actuator::deflection_limit, dimension::kAngle, sensor_file::Sign::not_negative,
          "3 deg"},
    Entry{"actuator.rate_limit", &Actuator::rate_limit, dimension::kAngularRate, sensor_file::Sign::not_negative,
          "15 deg/s"},
    Entry{"actuator.delay", &Actuator::delay, dimension::kTime, sensor_file::Sign::not_negative, "none"},
    Entry{"roll_moment_limit", &Vehicle::roll_moment_limit, dimension::kMoment, sensor_file::Sign::not_negative,
          "no roll control"},
    Entry{"bending.frequency", &Bending::frequency, dimension::kFrequency, sensor_file::Sign::above_zero, "", kBurn},
    Entry{"bending.damping", &Bending::damping, dimension::kNumber, sensor_file::Sign::not_negative, ""},
    Entry{"bending.gimbal_deflection", &Bending::gimbal_deflection, dimension::kNumber, sensor_file::Sign::any, ""},
    Entry{"bending.slope_at_imu", &Bending::slope_at_imu, kAnglePerLength, sensor_file::Sign::any, ""},
};

/// "actuator" of "actuator.frequency", empty where there is none.
std::string_view group_of(std::string_view key) {
  const std::size_t dot = key.find('.');
  return dot == std::string_view::npos ? std::string_view() : key.substr(0, dot);
}
std::string name_in_group(std::string_view key) { return std::string(key.substr(key.find('.') + 1)); }

std::size_t place_of(std::string_view key) {
  return static_cast<std::size_t>(std::ranges::find(kEntries, key, &Entry::key) - kEntries.begin());
}

/// What a member is of a vehicle, which has bending where it is one of it.
struct Of {
  Vehicle& vehicle;
  template <class T>
  T& operator()(T Vehicle::*member) const {
    return vehicle.*member;
  }
  double& operator()(double Actuator::*member) const { return vehicle.actuator.*member; }
  template <class T>
  T& operator()(T Bending::*member) const {
    return vehicle.bending.value().*member;
  }
};

/// What is said of a number.
struct Stated {
  std::optional<Origin> origin;
  std::string reason;
};

constexpr std::array kOrigins{Origin::sourced, Origin::derived, Origin::assumed};
const std::vector<std::string> kOriginNames{"sourced", "derived", "assumed"};

// --- Reading -----------------------------------------------------------------------------------------------

class VehicleReader : private sensor_file::YamlReader {
 public:
  /// @param depth  how many files are based on this one
  explicit VehicleReader(const std::string& path, int depth)
      : sensor_file::YamlReader(path, "a vehicle", "lift_off_mass: 28 t", "lift_off_mass:"),
        folder_(path == "-" ? std::filesystem::path() : std::filesystem::path(path).parent_path()),
        depth_(depth) {}

  VehicleFile read() {
    if (const Node base = root()["based_on"]) read_base(base);  // this file's numbers go over it
    std::vector<sensor_file::YamlKey> keys{{"name", [&](const Node& v) { vehicle().name = text("name", v); }},
                                           {"based_on", [](const Node&) {}}};
    for (const Entry& entry : kEntries) add_key(keys, entry);
    section(root(), "a vehicle", keys);
    complete();
    return std::move(result_);
  }

 private:
  Vehicle& vehicle() { return result_.vehicle; }

  void add_key(std::vector<sensor_file::YamlKey>& keys, const Entry& entry) {
    const std::string group(group_of(entry.key));
    if (group.empty())
      keys.push_back({std::string(entry.key), [&](const Node& v) { read_entry(entry, v, {}); }});
    else if (keys.back().name != group)  // its entries stand together
      keys.push_back({group, [this, group](const Node& v) { read_group(group, v); }});
  }

  void read_base(const Node& node) {
    constexpr int kDeepest = 8;
    if (depth_ == kDeepest)
      fail_here(
          node,
          fmt::format(
              "based_on: found more than {} files that are each based on the next, expected fewer; do they go round in a circle?",
              kDeepest));
    const std::string path = (folder_ / text("based_on", node)).lexically_normal().string();
    try {
      result_ = VehicleReader(path, depth_ + 1).read();
    } catch (const text::InputError& error) {  // its own place, behind that of the line which named it
      fail_here(node, fmt::format("based_on: {}", error.what()));
    }
  }

  // --- Groups ---

  void read_group(const std::string& group, const Node& node) {
    if (group == kBending && node.IsScalar() && node.Scalar() == "none") {
      vehicle().bending.reset();
      std::erase_if(result_.numbers, [&](const VehicleNumber& n) { return group_of(n.key) == group; });
      return;
    }
    if (!node.IsMap())
      fail_here(node, fmt::format("{}: found {}, expected keys and values below it{}", group, kind(node),
                                  group == kBending ? ", or none" : ""));
    places_.emplace(group, node);
    if (group == kBending && !vehicle().bending) vehicle().bending.emplace();
    const Stated stated = read_stated(group, node);
    std::vector<sensor_file::YamlKey> keys = stated_keys();
    for (const Entry& entry : kEntries) {
      if (group_of(entry.key) == group)
        keys.push_back({name_in_group(entry.key), [&](const Node& v) { read_entry(entry, v, stated); }});
    }
    section(node, group, keys);
  }

  // --- Origin and reason ---

  [[nodiscard]] static std::vector<sensor_file::YamlKey> stated_keys() {
    const auto read_before = [](const Node&) {};
    return {{"origin", read_before}, {"reason", read_before}};
  }

  [[nodiscard]] Stated read_stated(std::string_view where, const Node& map) const {
    for (const auto& entry : map) {
      if (entry.first.IsScalar() && entry.second.IsNull())
        fail_here(entry.first,
                  fmt::format("{}: found {} without a value; a reason with a comma or colon needs quotes around it",
                              where, text::quoted(entry.first.Scalar())));
    }
    const Node origin = map["origin"], reason = map["reason"];
    if (origin && !reason)
      fail_here(origin, fmt::format("{}: found an origin without its \"reason:\", expected both", where));
    if (reason && !origin)
      fail_here(reason, fmt::format("{}: found a reason without its \"origin:\" ({}), expected both", where,
                                    text::listing(kOriginNames, "or")));
    if (!origin) return {};
    const std::string key = fmt::format("{}, origin", where);
    Stated stated{kOrigins.at(one_of(key, origin, kOriginNames)), text("reason", reason)};
    if (text::trim(stated.reason).empty())
      fail_here(reason, fmt::format("{}: found an empty reason, expected where its value comes from", where));
    return stated;
  }

  // --- One number or table ---

  /// @param group  what is said of all of its group
  void read_entry(const Entry& entry, const Node& node, const Stated& group) {
    Stated own;
    if (node.IsMap()) own = read_stated(entry.key, node);
    std::string value;
    std::visit([&](auto member) { value = read_value(entry, node, Of{vehicle()}(member)); }, entry.member);
    note({std::string(entry.key), value, own.origin ? own.origin : group.origin,
          own.origin ? own.reason : group.reason});
    places_.emplace(entry.key, node);
  }

  void note(VehicleNumber number) {
    const auto at = std::ranges::find(result_.numbers, number.key, &VehicleNumber::key);
    if (at == result_.numbers.end())
      result_.numbers.push_back(std::move(number));
    else
      *at = std::move(number);
  }

  /// @return the value as written
  std::string read_value(const Entry& entry, const Node& node, double& out) const {
    if (!node.IsMap()) {
      out = quantity_of(entry, node);
      return node.Scalar();
    }
    std::string written;
    std::vector<sensor_file::YamlKey> keys = stated_keys();
    keys.push_back({"value", [&](const Node& v) { written = read_value(entry, scalar(entry, v), out); }});
    section(node, entry.key, keys);
    if (written.empty())
      fail_here(node,
                fmt::format("{}: found no \"value:\", expected one, as in {{value: {}, origin: ..., reason: ...}}",
                            entry.key, example(entry)));
    return written;
  }

  std::string read_value(const Entry& entry, const Node& node, flight::LookupTable& out) const {
    std::vector<flight::LookupTable::Point> points;
    std::string written;
    bool smooth = false;
    const auto take = [&](const Node& v) {
      if (!points.empty()) fail_here(v, fmt::format("{}: found both value and points", entry.key));
      points = read_points(entry, v, written);
    };
    if (node.IsMap()) {
      std::vector<sensor_file::YamlKey> keys = stated_keys();
      keys.push_back({"value", [&](const Node& v) { take(scalar(entry, v)); }});
      keys.push_back({"points", [&](const Node& v) { take(list(entry, v)); }});
      keys.push_back({"interpolation", [&](const Node& v) {
                        smooth = one_of(fmt::format("{}, interpolation", entry.key), v, {"linear", "smooth"}) == 1;
                      }});
      section(node, entry.key, keys);
      if (points.empty())
        fail_here(node,
                  fmt::format("{}: found neither \"points:\" nor \"value:\", expected one of them, as in points: {}",
                              entry.key, example_points(entry)));
    } else {
      take(node);
    }
    if (smooth) written += ", smooth";
    try {
      out = smooth ? flight::LookupTable::smooth(std::move(points)) : flight::LookupTable::linear(std::move(points));
    } catch (const std::invalid_argument& error) {
      fail_here(node, fmt::format("{}: {}", entry.key, error.what()));
    }
    return written;
  }

  /// Points, or one value for all abscissae.
  [[nodiscard]] std::vector<flight::LookupTable::Point> read_points(const Entry& entry, const Node& node,
                                                                    std::string& written) const {
    if (!node.IsSequence()) {
      const double value = quantity_of(entry, node);
      written = node.Scalar();
      return {{0, value}};
    }
    std::vector<flight::LookupTable::Point> points;
    for (const Node& point : node) {
      if (!point.IsSequence() || point.size() != 2)
        fail_here(point, fmt::format("{}: found {}, expected points {}, as in {}", entry.key,
                                     point.IsSequence() ? fmt::format("a list of {}", point.size()) : kind(point),
                                     fmt::format("of {} and value", entry.over.name), example_points(entry)));
      const double x = abscissa(entry, point[0]);
      if (!points.empty() && !(x > points.back().first))
        fail_here(point[0], fmt::format("{}: found {} behind {}, expected abscissae that ascend", entry.key, x,
                                        points.back().first));
      points.emplace_back(x, quantity_of(entry, point[1]));
      written += fmt::format("{}{}: {}", written.empty() ? "" : ", ", point[0].Scalar(), point[1].Scalar());
    }
    if (points.empty())
      fail_here(node,
                fmt::format("{}: found an empty list, expected points as in {}", entry.key, example_points(entry)));
    return points;
  }

  [[nodiscard]] double abscissa(const Entry& entry, const Node& node) const {
    const double x = number(entry.key, node);
    if (x >= 0 && x <= entry.over.highest) return x;
    fail_here(node, fmt::format("{}: found {}, expected {} from 0 to {}", entry.key, text::quoted(node.Scalar()),
                                entry.over.name, entry.over.highest));
  }

  /// With its unit; where it has no dimension also without.
  [[nodiscard]] double quantity_of(const Entry& entry, const Node& node) const {
    double plain = 0;
    if (entry.dimension != dimension::kNumber || !node.IsScalar() ||
        text::parse_number(node.Scalar(), false, plain) != text::Cell::number)
      return quantity(entry.key, node, entry.dimension, entry.sign);
    check_sign(entry.key, node, plain, entry.sign);
    return plain;
  }

  [[nodiscard]] const Node& scalar(const Entry& entry, const Node& node) const {
    if (!node.IsScalar())
      fail_here(node, fmt::format("{}, value: found {}, expected one like {}", entry.key, kind(node), example(entry)));
    return node;
  }
  [[nodiscard]] const Node& list(const Entry& entry, const Node& node) const {
    if (!node.IsSequence())
      fail_here(node, fmt::format("{}, points: found {}, expected a list like {}", entry.key, kind(node),
                                  example_points(entry)));
    return node;
  }

  /// "1 kg".
  [[nodiscard]] static std::string example(const Entry& entry) {
    if (entry.dimension == dimension::kNumber) return "1";
    const std::string units = noise::example_units(entry.dimension);
    return "1 " + units.substr(0, units.find(','));
  }
  [[nodiscard]] static std::string example_points(const Entry& entry) {
    return fmt::format("[[0, {0}], [1, {0}]]", example(entry));
  }

  // --- The whole ---

  void complete() {
    refuse_incomplete();
    std::ranges::sort(result_.numbers, {}, [](const VehicleNumber& n) { return place_of(n.key); });
    if (!given("yaw_inertia")) vehicle().yaw_inertia = vehicle().pitch_inertia;
    if (!given("imu_station")) vehicle().imu_station = vehicle().centre_of_mass(0);
    try {
      vehicle().check();
    } catch (const flight::VehicleError& error) {
      fail_here(place(error.number), error.what());
    }
    list_omissions();
  }

  [[nodiscard]] bool given(std::string_view key) const {
    return std::ranges::find(result_.numbers, key, &VehicleNumber::key) != result_.numbers.end();
  }

  void refuse_incomplete() const {
    std::vector<std::string> missing;
    const Entry* first = nullptr;
    for (const Entry& entry : kEntries) {
      const bool needed = entry.left_out.empty() && (group_of(entry.key) != kBending || result_.vehicle.bending);
      if (!needed || given(entry.key)) continue;
      if (!first) first = &entry;
      missing.emplace_back(entry.key);
    }
    if (first) {
      const bool bends = group_of(first->key) == kBending;
      fail_here(bends ? place(kBending) : root(),
                fmt::format("found no {}, which {} needs; write \"{}: {}\"", text::listing(missing, "and no"),
                            bends ? "bending" : "a vehicle", name_in_group(first->key), example(*first)));
    }
    for (const std::string_view key : {"axial_drag", "normal_force_slope"}) {
      if (given(key) && !given("reference_area"))
        fail_here(place(key),
                  fmt::format("{}: found no \"reference_area:\", expected one, to which the coefficient refers", key));
    }
  }

  /// Where it is said: in this file, or where this file names the one it is based on.
  [[nodiscard]] Node place(std::string_view key) const {
    const auto at = places_.find(std::string(key));
    if (at != places_.end()) return at->second;
    return root()["based_on"] ? root()["based_on"] : root();
  }

  void list_omissions() {
    result_.left_out.clear();
    for (const Entry& entry : kEntries) {
      if (!given(entry.key) && !entry.left_out.empty()) result_.left_out.push_back({entry.key, entry.left_out});
    }
    if (!vehicle().bending) result_.left_out.push_back({kBending, "rigid"});
  }

  std::filesystem::path folder_;
  int depth_;
  std::map<std::string, Node> places_;  ///< of what this file gives
  VehicleFile result_;
};

}  // namespace

std::string_view to_string(const std::optional<Origin>& origin) {
  if (!origin) return "not stated";
  const auto at = std::ranges::find(kOrigins, *origin);
  return kOriginNames.at(static_cast<std::size_t>(at - kOrigins.begin()));
}

VehicleFile read_vehicle(const std::string& path) { return VehicleReader(path, 0).read(); }

}  // namespace gyrobudget::inline v0::files
