// SPDX-License-Identifier: MIT
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "scene_yaml.h"

namespace gyrobudget::inline v0::files {
namespace {

using noise::Dimension;
using YAML::Node;
namespace dimension = noise::dimension;

class FlightReader {
 public:
  explicit FlightReader(const SceneYaml& yaml) : yaml_(yaml) {}

  FlightSource read(const Node& node) {
    const Node vehicle = yaml_.find(node, "flight", "vehicle");
    if (!vehicle) yaml_.fail_here(node, "flight: found no \"vehicle:\", expected the path of a vehicle file");
    read_vehicle_key(vehicle);  // others refer to it
    if (const Node bending = node["bending"]) read_bending(bending);
    yaml_.section(
        node, "flight",
        {{"vehicle", [](const Node&) {}},
         {"bending", [](const Node&) {}},
         {"pitch", [&](const Node& v) { control().pitch = table("pitch", v, dimension::kTime, dimension::kAngle); }},
         {"control", [&](const Node& v) { read_control(v); }},
         {"guidance", [&](const Node& v) { read_guidance(v); }},
         {"atmosphere", [&](const Node& v) { flight().world.atmosphere = yaml_.flag("atmosphere", v); }},
         {"wind", [&](const Node& v) { read_wind(v); }},
         {"dispersion", [&](const Node& v) { read_dispersion(v); }},
         {"faults", [&](const Node& v) { read_faults(v); }},
         {"integrator", [&](const Node& v) { read_integrator(v); }}});
    add_notch();
    flight().pitch = control().pitch(0);
    check(node);
    return std::move(result_);
  }

 private:
  flight::Flight& flight() { return result_.plan.flight; }
  flight::AttitudeControlOptions& control() { return result_.plan.control; }

  // --- Values ---

  [[nodiscard]] sensor_file::YamlKey positive(const char* key, double& value, const Dimension& d) const {
    return {key, [this, key, d, &value](const Node& v) {
              value = yaml_.quantity(key, v, d, sensor_file::Sign::above_zero);
            }};
  }
  [[nodiscard]] sensor_file::YamlKey not_negative(const char* key, double& value, const Dimension& d) const {
    return {key, [this, key, d, &value](const Node& v) {
              value = yaml_.quantity(key, v, d, sensor_file::Sign::not_negative);
            }};
  }
  [[nodiscard]] sensor_file::YamlKey any(const char* key, double& value, const Dimension& d) const {
    return {key, [this, key, d, &value](const Node& v) { value = yaml_.quantity(key, v, d, sensor_file::Sign::any); }};
  }
  /// A plain number.
  [[nodiscard]] sensor_file::YamlKey number(const char* key, double& value) const {
    return {key, [this, key, &value](const Node& v) {
              value = yaml_.number(key, v);
              yaml_.check_sign(key, v, value, sensor_file::Sign::above_zero);
            }};
  }

  /// [[8 s, 90 deg], [83 s, 50 deg]]: straight between.
  [[nodiscard]] flight::LookupTable table(std::string_view key, const Node& node, const Dimension& x,
                                          const Dimension& y) const {
    if (!node.IsSequence()) return yaml_.quantity(key, node, y, sensor_file::Sign::any);
    std::vector<flight::LookupTable::Point> points;
    for (const Node& point : node) {
      if (!point.IsSequence() || point.size() != 2)
        yaml_.fail_here(point, fmt::format("{}: found {}, expected pairs, as in [[{}, {}], ...]", key,
                                           sensor_file::YamlReader::kind(point), example(x), example(y)));
      points.emplace_back(yaml_.quantity(key, point[0], x, sensor_file::Sign::any),
                          yaml_.quantity(key, point[1], y, sensor_file::Sign::any));
      if (points.size() > 1 && !(points.back().first > points[points.size() - 2].first))
        yaml_.fail_here(point[0], fmt::format("{}: found {} behind a later one, expected them to ascend", key,
                                              text::quoted(point[0].Scalar())));
    }
    if (points.empty()) yaml_.fail_here(node, fmt::format("{}: found an empty list, expected pairs", key));
    return flight::LookupTable::linear(std::move(points));
  }
  [[nodiscard]] static std::string example(const Dimension& d) {
    if (d == dimension::kTime) return "8 s";
    if (d == dimension::kAngle) return "90 deg";
    return d == dimension::kLength ? "10 km" : "30 m/s";
  }

  // --- Vehicle and control ---

  void read_vehicle_key(const Node& node) {
    result_.vehicle.path = yaml_.path("vehicle", node);
    try {
      VehicleFile file = read_vehicle(result_.vehicle.path);
      flight().vehicle = std::move(file.vehicle);
      result_.vehicle.numbers = std::move(file.numbers);
      result_.vehicle.left_out = std::move(file.left_out);
    } catch (const text::InputError& error) {  // its own place, behind that of the line which named it
      yaml_.fail_here(node, fmt::format("vehicle: {}", error.what()));
    }
  }

  void read_bending(const Node& node) {
    if (!yaml_.flag("bending", node)) {
      flight().vehicle.bending.reset();
    } else if (!flight().vehicle.bending) {
      yaml_.fail_here(node, fmt::format("bending: {} has no bending mode; write it there, or leave this out",
                                        result_.vehicle.path));
    }
  }

  void read_control(const Node& node) {
    double rate = 1 / flight().period;
    yaml_.section(node, "control",
                  {positive("frequency", control().frequency, dimension::kAngularRate),
                   number("damping", control().damping),
                   {"feedback",
                    [&](const Node& v) {
                      control().feedback = yaml_.one_of("feedback", v, {"rate_error", "rate"}) == 0
                                               ? flight::RateFeedback::rate_error
                                               : flight::RateFeedback::rate;
                    }},
                   not_negative("least_thrust", control().least_thrust, dimension::kNumber),
                   {"notch", [&](const Node& v) { read_notch(v); }},
                   positive("rate", rate, dimension::kFrequency)});
    constexpr double kFastest = 1e5;  // [Hz]
    if (rate > kFastest)
      yaml_.fail_here(node, fmt::format("control: found a rate of {:g} Hz, expected at most {:g} Hz", rate, kFastest));
    flight().period = 1 / rate;
  }

  void read_notch(const Node& node) {
    notch_given_ = true;
    if (node.IsScalar() && node.Scalar() == "none") return;
    flight::Notch notch;
    notch.frequency = mode(node);
    yaml_.section(node, "notch",
                  {{"frequency",
                    [&](const Node& v) {
                      notch.frequency =
                          yaml_.quantity("frequency", v, dimension::kFrequency, sensor_file::Sign::above_zero);
                    }},
                   number("depth", notch.depth),
                   number("width", notch.width)});
    control().notches = {notch};
  }
  [[nodiscard]] flight::LookupTable mode(const Node& node) {
    if (const auto& bending = flight().vehicle.bending) return bending->frequency;
    if (!node["frequency"])
      yaml_.fail_here(node, "notch: the vehicle has no bending mode; give the notch a frequency, or write none");
    return 1;
  }
  void add_notch() {
    // A mode above half the rate of control is out of a digital filter's reach.
    if (notch_given_ || !flight().vehicle.bending) return;
    const flight::LookupTable& mode = flight().vehicle.bending->frequency;
    if (mode.range().second < 0.5 / flight().period) control().notches = {flight::Notch{mode}};
  }

  void read_guidance(const Node& node) {
    if (node.IsScalar()) {
      if (yaml_.one_of("guidance", node, {"attitude", "trajectory"}) == 1) result_.plan.guidance.emplace();
      return;
    }
    auto& g = result_.plan.guidance.emplace();
    yaml_.section(node, "guidance",
                  {positive("frequency", g.frequency, dimension::kAngularRate), number("damping", g.damping),
                   positive("angle_limit", g.angle_limit, dimension::kAngle)});
  }

  // --- World ---

  void read_wind(const Node& node) {
    flight::Wind& wind = flight().world.wind;
    yaml_.section(
        node, "wind",
        {any("east", wind.steady.x(), dimension::kVelocity),
         any("north", wind.steady.y(), dimension::kVelocity),
         {"shear_east",
          [&](const Node& v) { wind.east = table("shear_east", v, dimension::kLength, dimension::kVelocity); }},
         {"shear_north",
          [&](const Node& v) { wind.north = table("shear_north", v, dimension::kLength, dimension::kVelocity); }},
         {"gust", [&](const Node& v) { read_gust(v, wind.gust); }}});
  }

  void read_gust(const Node& node, flight::Gust& gust) const {
    yaml_.section(
        node, "gust",
        {any("height", gust.height, dimension::kLength), positive("half_width", gust.half_width, dimension::kLength),
         any("east", gust.peak.x(), dimension::kVelocity), any("north", gust.peak.y(), dimension::kVelocity),
         any("up", gust.peak.z(), dimension::kVelocity)});
    if (!(gust.half_width > 0))
      yaml_.fail_here(
          node, "gust: found no \"half_width:\", expected one, as in {height: 9 km, half_width: 300 m, north: 9 m/s}");
  }

  void read_dispersion(const Node& node) {
    flight::Dispersion& d = result_.dispersion;
    yaml_.section(
        node, "dispersion",
        {not_negative("impulse", d.impulse, dimension::kNumber),
         not_negative("burn_time", d.burn_time, dimension::kNumber), not_negative("mass", d.mass, dimension::kNumber),
         not_negative("inertia", d.inertia, dimension::kNumber),
         not_negative("axial_drag", d.axial_drag, dimension::kNumber),
         not_negative("normal_force", d.normal_force, dimension::kNumber),
         not_negative("pressure_ahead", d.pressure_ahead, dimension::kLength),
         not_negative("centre_of_mass", d.centre_of_mass, dimension::kLength),
         not_negative("thrust_misalignment", d.thrust_misalignment, dimension::kAngle),
         not_negative("wind", d.wind, dimension::kVelocity), not_negative("gust", d.gust, dimension::kNumber)});
    try {
      d.check(flight().vehicle);
    } catch (const std::invalid_argument& error) {
      yaml_.fail_here(node, error.what());
    }
  }

  // --- What fails ---

  void read_faults(const Node& node) {
    flight::Faults& f = flight().faults;
    flight::NavigatorFaults& n = result_.plan.navigator_faults;
    yaml_.section(node, "faults",
                  {not_negative("thrust_cut", f.thrust_cut_at, dimension::kTime),
                   {"nozzle_stuck", [&](const Node& v) { read_stuck(v, f); }},
                   {"thrust_misalignment",
                    [&](const Node& v) {
                      yaml_.section(v, "thrust_misalignment",
                                    {any("pitch", f.thrust_misalignment.x(), dimension::kAngle),
                                     any("yaw", f.thrust_misalignment.y(), dimension::kAngle)});
                    }},
                   {"dead_gyro", [&](const Node& v) { read_dead_gyro(v, n); }},
                   not_negative("navigation_delay", n.delay, dimension::kTime)});
  }

  void read_stuck(const Node& node, flight::Faults& f) {
    f.nozzle_stuck_at = 0;
    if (node.IsScalar()) {
      f.nozzle_stuck_at = yaml_.quantity("nozzle_stuck", node, dimension::kTime, sensor_file::Sign::not_negative);
      return;
    }
    yaml_.section(node, "nozzle_stuck",
                  {not_negative("at", f.nozzle_stuck_at, dimension::kTime),
                   any("pitch", f.nozzle_stuck_offset.x(), dimension::kAngle),
                   any("yaw", f.nozzle_stuck_offset.y(), dimension::kAngle)});
    const double limit = flight().vehicle.actuator.deflection_limit;
    if (f.nozzle_stuck_offset.cwiseAbs().maxCoeff() > limit)
      yaml_.fail_here(node, fmt::format("nozzle_stuck: expected an offset within the nozzle's limit of {:.4g} deg",
                                        limit / earth::kDegree));
  }

  void read_dead_gyro(const Node& node, flight::NavigatorFaults& n) const {
    const auto axis = [&](const Node& v) {
      n.dead_gyro = static_cast<int>(yaml_.one_of("dead_gyro", v, {"x", "y", "z"}));
    };
    if (node.IsScalar()) return axis(node);
    yaml_.section(node, "dead_gyro", {{"axis", axis}, not_negative("at", n.dead_gyro_at, dimension::kTime)});
    if (!n.dead_gyro)
      yaml_.fail_here(node, "dead_gyro: found no \"axis:\", expected x, y or z, as in {axis: y, at: 5 s}");
  }

  void read_integrator(const Node& node) {
    using enum flight::Method;
    constexpr std::array kMethods{automatic, exact, runge_kutta4, dormand_prince, fehlberg78, rosenbrock};
    std::vector<std::string> names;
    for (const flight::Method m : kMethods) names.emplace_back(to_string(m));
    flight::Integration& i = flight().integration;
    const auto method = [&](const Node& v) { i.method = kMethods.at(yaml_.one_of("integrator", v, names)); };
    if (node.IsScalar()) return method(node);
    yaml_.section(node, "integrator",
                  {{"method", method},
                   {"step",
                    [&](const Node& v) {
                      constexpr double kFinest = 1e-5;  // [s]: 83 s take a minute
                      i.step = yaml_.quantity("step", v, dimension::kTime, sensor_file::Sign::above_zero);
                      if (i.step < kFinest)
                        yaml_.fail_here(v,
                                        fmt::format("step: found {:g} s, expected at least {:g} s", i.step, kFinest));
                    }},
                   {"tolerance", [&](const Node& v) {
                      i.tolerance = yaml_.number("tolerance", v);
                      yaml_.check_sign("tolerance", v, i.tolerance, sensor_file::Sign::not_negative);
                    }}});
  }

  // What the controller refuses of all that together.
  void check(const Node& node) {
    try {
      auto options = control();
      options.period = flight().period;
      (void)flight::AttitudeControl(flight().vehicle, flight().world.site, options);
      (void)flight::check(result_.plan.navigator_faults, flight().period);
    } catch (const std::invalid_argument& error) {
      yaml_.fail_here(node, fmt::format("flight: {}", error.what()));
    }
  }

  const SceneYaml& yaml_;
  FlightSource result_;
  bool notch_given_ = false;
};

}  // namespace

FlightSource read_flight(const SceneYaml& yaml, const Node& node) { return FlightReader(yaml).read(node); }

void place_flight(FlightSource& source, const navigation::Scenario& scenario) {
  flight::Plan& plan = source.plan;
  plan.flight.world.site = *scenario.site;
  plan.flight.azimuth = plan.control.azimuth = scenario.azimuth;
  if (std::isfinite(scenario.until)) plan.flight.duration = scenario.until;
}

}  // namespace gyrobudget::inline v0::files
