// SPDX-License-Identifier: MIT
// Closed-loop flights for programs, and the data that flight.js draws.
#include "gyrobudget/estimation/budget/error_budget.h"
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/closed_loop/flight_frame.h"
#include "gyrobudget/estimation/closed_loop/summary.h"
#include "gyrobudget/noise/version.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "flight_words.h"
#include "json_text.h"
#include "page_parts.h"
#include "sensor_words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;
using closed_loop::Difference;
using closed_loop::FlightFrame;
using closed_loop::Flights;
using closed_loop::FromPad;
using closed_loop::Outcome;
using closed_loop::Study;
using Eigen::Vector3d;
using flight::FlightPoint;
using flight::FlightRecord;
using navigation::CoreMatrix;

using earth::kDegree;

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }
Json list_of(const Vector3d& v) {
  return Json::array({number_or_null(v[0]), number_or_null(v[1]), number_or_null(v[2])});
}

// Three components by name, and their root sum square.
Json components(const std::array<const char*, 3>& axes, const Vector3d& v, const char* sum) {
  Json out;
  for (std::size_t i = 0; i < axes.size(); ++i) out[axes[i]] = number_or_null(v[static_cast<int>(i)]);
  out[sum] = number_or_null(v.norm());
  return out;
}
constexpr std::array kLaunchAxes{"downrange", "crossrange", "up"};
constexpr std::array kLocalAxes{"east", "north", "up"};
Json launch(const Vector3d& v, const char* sum = "rss") { return components(kLaunchAxes, v, sum); }

Json difference_json(const Difference& d) {
  return {{"position_m", launch(d.position)},
          {"velocity_m_s", launch(d.velocity)},
          {"attitude_deg", launch(d.attitude / kDegree, "total")}};
}

// --- Where flights end -------------------------------------------------------------------------------------

Json end_json(const FlightFrame& frame, const FlightRecord& record) {
  const FromPad end = frame.from_pad(record.end);
  return {{"t_s", end.t},
          {"height_m", end.place.height},
          {"downrange_m", end.position[0]},
          {"crossrange_m", end.position[1]},
          {"speed_m_s", end.velocity.norm()},
          {"distance_m", end.position.norm()},
          {"pitch_deg", end.attitude.pitch / kDegree}};
}

Json nominal_json(const FlightFrame& frame, const FlightRecord& record) {
  Json out = end_json(frame, record);
  out["ended"] = to_string(record.ended);
  out["account"] = record.account;
  return out;
}

// --- Dispersion ----------------------------------------------------------------------------------------------

Json flights_json(const Flights& f, double azimuth) {
  if (f.outcomes.empty()) return nullptr;
  Json out{
      {"flights", f.outcomes.size()}, {"complete", f.complete()}, {"lost", f.lost()}, {"unaligned", f.unaligned()}};
  if (f.complete() < 2) {
    for (const auto* what : {"position_m", "velocity_m_s", "attitude_deg", "mean_position_m", "ellipse"})
      out[what] = nullptr;
    return out;
  }
  const auto position = f.spread(&Outcome::position);
  const closed_loop::Ellipse e = closed_loop::ellipse(position.covariance, azimuth);
  out["position_m"] = launch(position.sigma());
  out["velocity_m_s"] = launch(f.spread(&Outcome::velocity).sigma());
  out["attitude_deg"] = launch(f.spread(&Outcome::attitude).sigma() / kDegree, "total");
  out["mean_position_m"] = launch(position.mean);
  out["ellipse"] = {
      {"semi_major_m", e.semi_major}, {"semi_minor_m", e.semi_minor}, {"azimuth_deg", e.azimuth / kDegree}};
  return out;
}

Json dispersion_json(const Study& s) {
  Json out;
  for (const FlightsOf& kind : causes(s)) out[std::string(kind.cause)] = flights_json(*kind.flights, s.azimuth);
  return out;
}

// --- Navigation error ------------------------------------------------------------------------------------------

Json errors_json(const Study& s, const CoreMatrix& P) {
  const auto enu = navigation::local_sigmas(P, s.C_enu);
  const auto plane = navigation::local_sigmas(P, s.C_launch);
  Json position = components(kLocalAxes, enu.position, "rss");
  position["downrange"] = number_or_null(plane.position[0]);
  position["crossrange"] = number_or_null(plane.position[1]);
  return {{"position_m", position},
          {"velocity_m_s", components(kLocalAxes, enu.velocity, "rss")},
          {"attitude_deg", components(kLocalAxes, enu.attitude / kDegree, "total")}};
}

Json check_json(const Study& s) {
  const auto check = navigation_check(s);
  if (!check) return nullptr;
  Json ratio;
  for (int i = 0; i < 3; ++i)
    ratio[kLaunchAxes[static_cast<std::size_t>(i)]] = number_or_null(check->position_ratio[i]);
  Json out{{"runs", check->runs},
           {"position_rss_ratio", number_or_null(check->position)},
           {"velocity_rss_ratio", number_or_null(check->velocity)},
           {"attitude_rss_ratio", number_or_null(check->attitude)},
           {"position_ratio", ratio},
           {"ratio_low", check->low},
           {"ratio_high", check->high}};
  out.update(errors_json(s, s.sensors.navigation_error()));
  return out;
}

Json navigation_error_json(const FlightFrame& frame, const Study& s) {
  if (!s.budget) return nullptr;
  const std::size_t last = s.budget->times.size() - 1;
  const std::vector<double> share = budget::shares(*s.budget, last);
  Json out = errors_json(s, s.budget->total[last]);
  out["claimed"] = s.budget->claimed.empty() ? Json(nullptr) : errors_json(s, s.budget->claimed[last]);
  Json& sources = out["sources"] = Json::array();
  for (std::size_t i = 0; i < share.size(); ++i) {
    Json one{{"name", s.budget->lines[i].name}, {"share", share[i]}};
    one.update(errors_json(s, s.budget->lines[i].covariance[last]));
    sources.push_back(std::move(one));
  }
  Json& left = out["not_modelled"] = Json::array();
  for (const auto& l : s.left_out) left.push_back({{"what", l.what}, {"why", l.why}});
  out["flown"] = s.flown ? difference_json(frame.navigation_error(s.flown->end)) : Json(nullptr);
  out["monte_carlo"] = check_json(s);
  return out;
}

// --- Margins, limits, integrator ---------------------------------------------------------------------------------

Json margins_json(const closed_loop::MarginsAt& margins) {
  Json least = Json::array();
  for (const closed_loop::LeastMargins& m : closed_loop::least_margins(margins)) {
    least.push_back({{"mode_factor", m.mode_factor},
                     {"gain_up_db", number_or_null(m.gain_up_db)},
                     {"gain_down_db", number_or_null(m.gain_down_db)},
                     {"phase_deg", number_or_null(m.phase_deg)},
                     {"stable", m.stable}});
  }
  Json points;
  for (const auto* key : {"t_s", "mode_factor", "gain_up_db", "gain_down_db", "phase_deg", "stable"})
    points[key] = Json::array();
  for (const flight::Margins& m : margins.points) {
    points["t_s"].push_back(m.t);
    points["mode_factor"].push_back(m.mode_factor);
    points["gain_up_db"].push_back(number_or_null(closed_loop::decibel(m.gain_up)));
    points["gain_down_db"].push_back(number_or_null(-closed_loop::decibel(m.gain_down)));
    points["phase_deg"].push_back(number_or_null(m.phase / kDegree));
    points["stable"].push_back(m.stable);
  }
  return {{"until_s", margins.until},
          {"gain_demand_db", closed_loop::kGainDemandDb},
          {"phase_demand_deg", closed_loop::kPhaseDemandDeg},
          {"met", closed_loop::margins_met(margins)},
          {"least", least},
          {"points", points}};
}

Json limits_json(const FlightResult& r) {
  const closed_loop::LimitsUsed u = closed_loop::limits_used(r.plan.flight.vehicle, r.study.shown());
  return {{"dynamic_pressure_pa", u.pressure},
          {"dynamic_pressure_at_s", u.pressure_at},
          {"mach_at_it", u.mach},
          {"pressure_angle_pa_rad", u.pressure_angle},
          {"nozzle_deg", u.deflection / kDegree},
          {"nozzle_limit_deg", u.deflection_limit / kDegree},
          {"nozzle_limited", u.limited}};
}

Json integrator_json(const FlightResult& r) {
  const auto& work = r.study.nominal.work;
  const flight::Integration& asked = r.plan.flight.integration;
  return {{"method", to_string(work.method)},
          {"asked", to_string(asked.method)},
          {"step_s", asked.step},
          {"tolerance", asked.tolerance},
          {"steps", work.steps},
          {"rejected", work.rejected},
          {"evaluations", work.evaluations}};
}

// --- Trajectories --------------------------------------------------------------------------------------------------

struct Instant {
  FlightPoint point;
  FromPad from_pad;
  Difference navigation;
  std::optional<Difference> departure;
};

struct Column {
  const char* name;
  std::function<double(const Instant&)> value;
};

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

const std::vector<Column>& columns() {
  const auto departure = [](int axis) {
    return [axis](const Instant& i) { return i.departure ? i.departure->position[axis] : kNothing; };
  };
  const auto position = [](int axis) { return [axis](const Instant& i) { return i.from_pad.position[axis]; }; };
  const auto told = [](Vector3d Difference::*member, int axis, double unit) {
    return [=](const Instant& i) { return (i.navigation.*member)[axis] / unit; };
  };
  static const std::vector<Column> kColumns{
      {"t_s", [](const Instant& i) { return i.from_pad.t; }},
      {"downrange_m", position(0)},
      {"crossrange_m", position(1)},
      {"up_m", position(2)},
      {"height_m", [](const Instant& i) { return i.from_pad.place.height; }},
      {"latitude_deg", [](const Instant& i) { return i.from_pad.place.latitude / kDegree; }},
      {"longitude_deg", [](const Instant& i) { return i.from_pad.place.longitude / kDegree; }},
      {"speed_m_s", [](const Instant& i) { return i.from_pad.velocity.norm(); }},
      {"pitch_deg", [](const Instant& i) { return i.from_pad.attitude.pitch / kDegree; }},
      {"yaw_deg", [](const Instant& i) { return i.from_pad.attitude.yaw / kDegree; }},
      {"roll_deg", [](const Instant& i) { return i.from_pad.attitude.roll / kDegree; }},
      {"dynamic_pressure_pa", [](const Instant& i) { return i.point.flow.dynamic_pressure; }},
      {"mach", [](const Instant& i) { return i.point.flow.mach; }},
      {"angle_of_attack_deg", [](const Instant& i) { return i.point.flow.angle_of_attack / kDegree; }},
      {"thrust_n", [](const Instant& i) { return i.point.flow.thrust; }},
      {"nozzle_pitch_deg", [](const Instant& i) { return i.point.deflection[0] / kDegree; }},
      {"nozzle_yaw_deg", [](const Instant& i) { return i.point.deflection[1] / kDegree; }},
      {"departure_downrange_m", departure(0)},
      {"departure_crossrange_m", departure(1)},
      {"departure_up_m", departure(2)},
      {"navigation_downrange_m", told(&Difference::position, 0, 1)},
      {"navigation_crossrange_m", told(&Difference::position, 1, 1)},
      {"navigation_up_m", told(&Difference::position, 2, 1)},
      {"navigation_downrange_m_s", told(&Difference::velocity, 0, 1)},
      {"navigation_crossrange_m_s", told(&Difference::velocity, 1, 1)},
      {"navigation_up_m_s", told(&Difference::velocity, 2, 1)},
      {"navigation_about_downrange_deg", told(&Difference::attitude, 0, kDegree)},
      {"navigation_about_crossrange_deg", told(&Difference::attitude, 1, kDegree)},
      {"navigation_about_up_deg", told(&Difference::attitude, 2, kDegree)},
  };
  return kColumns;
}

// One in so many that there are no more than `most`; the last is always one.
Json trajectory_json(const FlightFrame& frame, const FlightRecord& record, std::size_t most) {
  const auto& points = record.points;
  Json out;
  for (const Column& column : columns()) out[column.name] = Json::array();
  const std::size_t every = std::max<std::size_t>(1, (points.size() + most - 1) / most);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % every != 0 && i + 1 != points.size()) continue;
    const Instant instant{points[i], frame.from_pad(points[i]), frame.navigation_error(points[i]),
                          frame.departure(points[i])};
    for (const Column& column : columns()) out[column.name].push_back(number_or_null(column.value(instant)));
  }
  return out;
}

// --- Vehicle and other inputs ---------------------------------------------------------------------------------------

Json vehicle_json(const FlightResult& r) {
  Json counts, numbers = Json::array(), left_out = Json::array();
  for (const OriginCount& c : origins(r)) counts[std::string(c.origin)] = c.numbers;
  for (const auto& n : r.vehicle_numbers)
    numbers.push_back(
        {{"key", n.key}, {"value", n.value}, {"origin", files::to_string(n.origin)}, {"reason", n.reason}});
  for (const auto& l : r.vehicle_left_out) left_out.push_back({{"key", l.key}, {"meaning", l.meaning}});
  return {{"file", text_or_null(r.vehicle)},
          {"name", r.plan.flight.vehicle.name},
          {"origins", counts},
          {"numbers", numbers},
          {"left_out", left_out}};
}

Json inputs_json(const FlightResult& r) {
  Json list = Json::array();
  for (const Input& i : inputs(r))
    list.push_back({{"group", i.group}, {"name", i.name}, {"value", i.value}, {"unit", i.unit}});
  return list;
}

Json notes_json(const FlightResult& r) {
  Json list = Json::array();
  for (const auto& note : notes_of(r)) list.push_back(note);
  return list;
}

Json flight_document(const FlightResult& r, const FlightFrame& frame, std::size_t most_points) {
  const Study& s = r.study;
  const auto departure = s.flown ? frame.departure(s.flown->end) : std::nullopt;
  return {{"schema", "gyrobudget.flight/1"},
          {"version", kVersion},
          {"command", r.command},
          {"scene", r.scene},
          {"name", r.name},
          {"sensor", text_or_null(r.sensor)},
          {"vehicle", vehicle_json(r)},
          {"seed", s.seed},
          {"runs", s.runs},
          {"aided", s.aided},
          {"aligned_over_s", s.pad},
          {"ended", s.flown ? to_string(s.flown->ended) : "not_flown"},
          {"account", s.flown ? s.flown->account : not_flown(s)},
          {"burnout", s.flown ? end_json(frame, *s.flown) : Json(nullptr)},
          {"nominal", nominal_json(frame, s.nominal)},
          {"departure", departure ? difference_json(*departure) : Json(nullptr)},
          {"dispersion", dispersion_json(s)},
          {"navigation_error", navigation_error_json(frame, s)},
          {"not_stated", r.not_stated},
          {"margins", margins_json(s.margins)},
          {"limits", limits_json(r)},
          {"integrator", integrator_json(r)},
          {"trajectory", s.flown ? trajectory_json(frame, *s.flown, most_points) : Json(nullptr)},
          {"inputs", inputs_json(r)},
          {"notes", notes_json(r)}};
}

// --- What the page draws beside ------------------------------------------------------------------------------------

// One sigma along downrange, crossrange and up over time.
Json growth_json(const Study& s) {
  if (!s.budget) return nullptr;
  std::array<Json, 3> position, velocity, attitude;
  for (const CoreMatrix& P : s.budget->total) {
    const auto sigma = navigation::local_sigmas(P, s.C_launch);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<int>(i);
      position[i].push_back(number_or_null(sigma.position[k]));
      velocity[i].push_back(number_or_null(sigma.velocity[k]));
      attitude[i].push_back(number_or_null(sigma.attitude[k] / kDegree));
    }
  }
  return {{"t_s", s.budget->times}, {"position", position}, {"velocity", velocity}, {"attitude", attitude}};
}

// Departures at the end of every complete flight, their mean and their covariance, downrange, crossrange, up.
Json clouds_json(const Study& s) {
  Json out;
  for (const FlightsOf& kind : causes(s)) {
    Json points = Json::array(), covariance = Json::array();
    for (const Outcome& o : kind.flights->outcomes)
      if (o.counts()) points.push_back(list_of(o.position));
    const auto spread = kind.flights->spread(&Outcome::position);
    for (int i = 0; i < 3; ++i) covariance.push_back(list_of(spread.covariance.col(i)));
    out[std::string(kind.cause)] = {{"points", points}, {"mean", list_of(spread.mean)}, {"covariance", covariance}};
  }
  return out;
}

Json nominal_trajectory_json(const FlightResult& r, const FlightFrame& frame, std::size_t most) {
  Json out = trajectory_json(frame, r.study.nominal, most);
  Json& program = out["program_deg"] = Json::array();
  for (const double t : out["t_s"]) program.push_back(number_or_null(r.plan.control.pitch(t) / kDegree));
  return out;
}

}  // namespace

std::string flight_json(std::span<const FlightResult> results) {
  constexpr auto kAllPoints = std::numeric_limits<std::size_t>::max() / 2;
  Json list = Json::array();
  for (const auto& r : results) list.push_back(flight_document(r, FlightFrame(r.plan, r.study.nominal), kAllPoints));
  if (list.size() == 1) return dense_json(list[0]);
  return dense_json({{"schema", "gyrobudget.flights/1"}, {"version", kVersion}, {"flights", list}});
}

std::string flight_data(std::span<const FlightResult> results) {
  constexpr std::size_t kPoints = 420;
  const std::vector<std::string> names = flight_names(results);
  Json list = Json::array();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const FlightFrame frame(results[i].plan, results[i].study.nominal);
    Json one = flight_document(results[i], frame, kPoints);
    one["label"] = names[i];
    one["not_stated_text"] = not_stated_text(results[i].not_stated, kThisTotal);
    one["navigation_words"] = navigation_words(results[i].study);
    one["growth"] = growth_json(results[i].study);
    one["clouds"] = clouds_json(results[i].study);
    one["nominal_trajectory"] = nominal_trajectory_json(results[i], frame, kPoints);
    list.push_back(std::move(one));
  }
  return without_markup(
      compact_json(Json{{"one_nominal", one_nominal(results)}, {"notes", flight_notes(results)}, {"flights", list}}));
}

}  // namespace gyrobudget::inline v0::report
