// SPDX-License-Identifier: MIT
// What a flight was given, in units for people.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "flight_words.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using earth::kDegree;
constexpr int kDigits = 6;

// As short as six digits allow: these numbers were typed, not computed.
std::string typed(double value) { return fmt::format("{:.{}g}", value, kDigits); }

// "8: 90, 83: 50"
std::string typed(const flight::LookupTable& table, double unit = 1) {
  const auto& points = table.points();
  if (points.size() == 1) return typed(points[0].second / unit);
  std::string out;
  for (const auto& [x, y] : points) out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", typed(x), typed(y / unit));
  return out;
}

class List {
 public:
  void group(std::string name) { group_ = std::move(name); }
  void add(std::string name, std::string value, std::string unit = "") {
    list_.push_back({group_, std::move(name), std::move(value), std::move(unit)});
  }
  void add(std::string name, double value, std::string unit) { add(std::move(name), typed(value), std::move(unit)); }
  /// What is 0 says nothing.
  void add_some(std::string name, double value, std::string unit) {
    if (value != 0) add(std::move(name), value, std::move(unit));
  }
  [[nodiscard]] std::vector<Input> take() { return std::move(list_); }

 private:
  std::string group_;
  std::vector<Input> list_;
};

void add_flight(List& list, const flight::Flight& f) {
  list.group("flight");
  list.add("vehicle", printable(f.vehicle.name));
  list.add("latitude", f.world.site.latitude / kDegree, "deg");
  list.add("longitude", f.world.site.longitude / kDegree, "deg");
  list.add("height of the pad", f.world.site.height, "m");
  list.add("azimuth of the belly on the pad", f.azimuth / kDegree, "deg");
  list.add("pitch on the pad", f.pitch / kDegree, "deg");
  list.add("duration", std::isnan(f.duration) ? f.vehicle.burn_time : f.duration, "s");
  list.add("period of control and navigation", f.period, "s");
  list.add("limit of the rate of turn", f.rate_limit, "rad/s");
  if (std::isfinite(f.pressure_angle_limit))
    list.add("limit of dynamic pressure times angle of attack", f.pressure_angle_limit / kDegree, "Pa deg");
  if (!f.world.atmosphere) list.add("atmosphere", "none");
}

void add_control(List& list, const flight::Plan& plan) {
  const flight::AttitudeControlOptions& c = plan.control;
  list.group("control");
  list.add("pitch over time", typed(c.pitch, kDegree), "s: deg");
  list.add("azimuth of the launch plane", c.azimuth / kDegree, "deg");
  list.add("frequency of the attitude loop", c.frequency, "rad/s");
  list.add("damping", c.damping, "");
  list.add("damping acts on",
           c.feedback == flight::RateFeedback::rate ? "the body's rate" : "the rate against the program's");
  list.add("least thrust that gains follow, of the mean", 100 * c.least_thrust, "%");
  for (const flight::Notch& n : c.notches) {
    list.add("notch over burn fraction", typed(n.frequency), "Hz");
    list.add("depth and width of the notch", fmt::format("{}, {}", typed(n.depth), typed(n.width)));
  }
  list.group("guidance");
  if (!plan.guidance) return list.add("guidance", "none: the program of attitude alone");
  list.add("frequency of the guidance loop", plan.guidance->frequency, "rad/s");
  list.add("damping", plan.guidance->damping, "");
  list.add("largest angle off the program", plan.guidance->angle_limit / kDegree, "deg");
}

void add_wind(List& list, const flight::Wind& w) {
  if (w.calm()) return;
  list.group("wind");
  const char* const axes[] = {"east", "north", "up"};
  for (int i = 0; i < 3; ++i) list.add_some(fmt::format("steady, {}", axes[i]), w.steady[i], "m/s");
  const auto shear = [&](const char* axis, const flight::LookupTable& table) {
    if (table.range() != std::pair(0.0, 0.0))
      list.add(fmt::format("shear over height, {}", axis), typed(table), "m: m/s");
  };
  shear("east", w.east);
  shear("north", w.north);
  if (w.gust.half_width <= 0) return;
  list.add("gust's height", w.gust.height, "m");
  list.add("gust's half width", w.gust.half_width, "m");
  for (int i = 0; i < 3; ++i) list.add_some(fmt::format("gust's peak, {}", axes[i]), w.gust.peak[i], "m/s");
}

void add_dispersion(List& list, const flight::Dispersion& d) {
  constexpr double kPercent = 0.01;
  list.group("dispersion, one sigma");
  list.add_some("total impulse", d.impulse / kPercent, "%");
  list.add_some("burn time", d.burn_time / kPercent, "%");
  list.add_some("mass at lift-off", d.mass / kPercent, "%");
  list.add_some("moments of inertia", d.inertia / kPercent, "%");
  list.add_some("axial drag", d.axial_drag / kPercent, "%");
  list.add_some("slope of the normal force", d.normal_force / kPercent, "%");
  list.add_some("centre of pressure", d.pressure_ahead, "m");
  list.add_some("centre of mass", d.centre_of_mass, "m");
  list.add_some("misalignment of the thrust, each plane", d.thrust_misalignment / kDegree, "deg");
  list.add_some("steady wind, east and north", d.wind, "m/s");
  list.add_some("peak of the gust", d.gust / kPercent, "%");
}

void add_faults(List& list, const flight::Plan& plan) {
  const flight::Faults& f = plan.flight.faults;
  list.group("faults");
  const auto at = [&](const char* what, double t) {
    if (std::isfinite(t)) list.add(what, t, "s");
  };
  at("thrust cut at", f.thrust_cut_at);
  at("nozzle stuck at", f.nozzle_stuck_at);
  const char* const planes[] = {"pitch", "yaw"};
  for (int i = 0; i < 2; ++i) {
    list.add_some(fmt::format("nozzle stuck off by, {}", planes[i]), f.nozzle_stuck_offset[i] / kDegree, "deg");
    list.add_some(fmt::format("misalignment of the thrust, {}", planes[i]), f.thrust_misalignment[i] / kDegree, "deg");
  }
  const flight::NavigatorFaults& n = plan.navigator_faults;
  if (n.dead_gyro) {
    list.add("dead gyro", std::string(1, "xyz"[*n.dead_gyro]));
    list.add("dead from", n.dead_gyro_at, "s");
  }
  list.add_some("navigation is told late by", n.delay, "s");
}

void add_integration(List& list, const flight::Integration& i) {
  list.group("integration");
  list.add("method asked for", std::string(to_string(i.method)));
  list.add("longest step", i.step, "s");
  list.add("tolerance of adaptive methods", i.tolerance, "");
}

}  // namespace

std::vector<Input> inputs(const FlightResult& r) {
  List list;
  add_flight(list, r.plan.flight);
  add_control(list, r.plan);
  add_wind(list, r.plan.flight.world.wind);
  add_dispersion(list, r.dispersion);
  add_faults(list, r.plan);
  add_integration(list, r.plan.flight.integration);
  return list.take();
}

}  // namespace gyrobudget::inline v0::report
