// SPDX-License-Identifier: MIT
// Navigation runs for programs, and the data that navigation.js draws.
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/version.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

#include "json_text.h"
#include "navigation.h"
#include "navigation_words.h"
#include "page_parts.h"
#include "sensor_words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using navigation::Aid;
using navigation::Navigation;

using earth::kDegree;

Json local(const Vector3d& v) {
  return {{"east", number_or_null(v[0])}, {"north", number_or_null(v[1])}, {"up", number_or_null(v[2])}};
}
Json list(const Vector3d& v, int rows = 3) {
  Json out = Json::array();
  for (int i = 0; i < rows; ++i) out.push_back(number_or_null(v[i]));
  return out;
}

std::string_view status_text(Navigation::Status status) {
  switch (status) {
    case Navigation::Status::navigated:
      return "navigated";
    case Navigation::Status::recovered:
      return "recovered";
    case Navigation::Status::lost:
      return "lost";
    case Navigation::Status::no_start:
      return "no_start";
    case Navigation::Status::heading_not_observable:
      return "heading_not_observable";
    case Navigation::Status::not_at_rest:
      return "not_at_rest";
    case Navigation::Status::failed:
      return "failed";
  }
  return "failed";
}

Json final_json(const navigation::Solution& s) {
  const earth::Geodetic at = earth::to_geodetic(s.state.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
  const Vector3d v = C_en.transpose() * s.state.v_eb_e;
  Eigen::Quaterniond q = Eigen::Quaterniond(C_en).conjugate() * s.state.q_eb;
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const earth::Euler e = earth::to_euler(q);
  return {{"t_s", s.time},
          {"latitude_deg", at.latitude / kDegree},
          {"longitude_deg", at.longitude / kDegree},
          {"height_m", at.height},
          {"velocity_m_s", {{"north", v[0]}, {"east", v[1]}, {"down", v[2]}}},
          {"heading_deg", e.yaw / kDegree},
          {"pitch_deg", e.pitch / kDegree},
          {"roll_deg", e.roll / kDegree},
          {"q_nb", {q.w(), q.x(), q.y(), q.z()}}};
}

Json sigma_json(const navigation::Solution& s) {
  return {{"position_m", local(s.position_sigma)},
          {"velocity_m_s", local(s.velocity_sigma)},
          {"attitude_deg", local(s.attitude_sigma / kDegree)}};
}

Json nis_json(const NavigationResult& r) {
  Json aids = Json::array();
  for (const auto& a : r.run.aids) {
    const Aid& aid = r.scenario.aids[a.aid];
    const double unit = aid.kind == Aid::Kind::attitude ? kDegree : 1;
    const bool any = a.used > 0;
    aids.push_back({{"name", aid.name},
                    {"dof", a.rows},
                    {"used", a.used},
                    {"gated", a.gated},
                    {"not_finite", a.not_finite},
                    {"left_out", a.left_out},
                    {"mean", any ? number_or_null(a.nis_mean) : Json(nullptr)},
                    {"low", any ? number_or_null(a.nis_low) : Json(nullptr)},
                    {"high", any ? number_or_null(a.nis_high) : Json(nullptr)},
                    {"inside_95", a.used + a.gated > 0 ? number_or_null(a.inside_95) : Json(nullptr)},
                    {"unit", unit_of(aid.kind)},
                    {"residual_mean", any ? list(a.residual_mean / unit, a.rows) : Json(nullptr)},
                    {"residual_rms", any ? list(a.residual_rms / unit, a.rows) : Json(nullptr)}});
  }
  const navigation::NisSummary nis = r.run.nis();
  return {{"mean", number_or_null(nis.mean)}, {"inside_95", number_or_null(nis.inside_95)}, {"aids", aids}};
}

Json states_json(const NavigationResult& r) {
  Json out = Json::array();
  if (r.run.solutions.empty()) return out;
  const navigation::Solution& last = r.run.solutions.back();
  for (std::size_t k = 0; k < r.run.model.terms.size(); ++k) {
    const StateText t = state_text(r.scenario, r.run.model.terms[k]);
    out.push_back({{"name", t.name},
                   {"unit", t.unit},
                   {"initial_sigma", number_or_null(r.run.initial[k] / t.to_si)},
                   {"value", number_or_null(last.terms[k] / t.to_si)},
                   {"sigma", number_or_null(last.term_sigmas[k] / t.to_si)}});
  }
  return out;
}

Json reference_json(const Navigation& run) {
  if (!run.reference || run.reference->errors.empty()) return nullptr;
  const auto& ref = *run.reference;
  const auto& last = ref.errors.back();
  const auto if_there = [](bool there, Json value) { return there ? std::move(value) : Json(nullptr); };
  return {{"position_rms_m", if_there(ref.has_position, number_or_null(ref.position_rms))},
          {"velocity_rms_m_s", if_there(ref.has_velocity, number_or_null(ref.velocity_rms))},
          {"attitude_rms_deg", if_there(ref.has_attitude, number_or_null(ref.attitude_rms / kDegree))},
          {"nees", number_or_null(ref.nees_mean)},
          {"nees_dof", ref.dof},
          {"nees_low", number_or_null(ref.nees_low)},
          {"nees_high", number_or_null(ref.nees_high)},
          {"nees_inside_95", number_or_null(ref.nees_inside_95)},
          {"epochs", ref.errors.size()},
          {"final",
           {{"t_s", last.time},
            {"position_m", if_there(ref.has_position, local(last.position))},
            {"velocity_m_s", if_there(ref.has_velocity, local(last.velocity))},
            {"attitude_deg", if_there(ref.has_attitude, local(last.attitude / kDegree))}}}};
}

Json lost_json(const NavigationResult& r) {
  Json out = Json::array();
  const std::vector<std::string> texts = lost_texts(r);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const navigation::LostSpan& span = r.run.lost[i];
    out.push_back({{"from_s", span.from},
                   {"to_s", span.to},
                   {"recovered", span.recovered},
                   {"held", span.held},
                   {"why", span.why},
                   {"restarted", span.restarted},
                   {"text", texts[i]}});
  }
  return out;
}

Json suspects_json(const NavigationResult& r) {
  Json out = Json::array();
  for (const navigation::Suspect& s : r.suspects) {
    Json aids = Json::array();
    for (const std::size_t aid : s.aids) aids.push_back(r.scenario.aids[aid].name);
    out.push_back({{"kind", name(s.kind)},
                   {"text", suspect_text(r, s)},
                   {"aids", aids},
                   {"explained", number_or_null(s.explained)},
                   {"mend", suspect_mend(r, s)}});
  }
  return out;
}

Json document(const NavigationResult& r) {
  const auto& imu = r.recording.imu;
  const bool any = !r.run.solutions.empty();
  Json left_out = Json::array();
  for (const auto& l : r.run.left_out) left_out.push_back({{"what", l.what}, {"why", l.why}});
  return {
      {"schema", "gyrobudget.navigation/1"},
      {"version", kVersion},
      {"command", r.command},
      {"scene", r.scene},
      {"name", r.scenario.name},
      {"sensor", r.scenario.sensor.name},
      {"status", status_text(r.run.status)},
      {"why", r.run.why},
      {"lost", lost_json(r)},
      {"suspects", suspects_json(r)},
      {"advice", innovation_texts(r)},
      {"imu",
       {{"source", r.source},
        {"samples", imu.increments.size()},
        {"duration_s", static_cast<double>(imu.stamps.back() - imu.stamps.front()) * noise::kNanosecond},
        {"interval_s", imu.typical_interval},
        {"gaps", imu.gaps},
        {"bridged_s", imu.bridged_seconds}}},
      {"alignment", {{"from_s", r.run.alignment.from}, {"to_s", r.run.alignment.to}, {"words", r.run.alignment.words}}},
      {"smoothed", r.scenario.smooth},
      {"epochs", r.run.solutions.size()},
      {"final", any ? final_json(r.run.solutions.back()) : Json(nullptr)},
      {"sigma", any ? sigma_json(r.run.solutions.back()) : Json(nullptr)},
      {"nis", nis_json(r)},
      {"states", states_json(r)},
      {"reference", reference_json(r.run)},
      {"left_out", left_out},
      {"not_stated", r.not_stated},
      {"notes", r.notes}};
}

std::string text_of(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

// --- The page ------------------------------------------------------------------------------------------------

/// At most so many of n, evenly, the last included.
std::vector<std::size_t> thinned(std::size_t n, std::size_t most) {
  std::vector<std::size_t> out;
  if (n <= most) {
    for (std::size_t i = 0; i < n; ++i) out.push_back(i);
    return out;
  }
  for (std::size_t i = 0; i < most; ++i) out.push_back((n - 1) * i / (most - 1));
  return out;
}

constexpr std::size_t kMostPoints = 800;

// Components over time with one sigma: {"t", "value": [3 lists], "sigma": [3 lists]}.
template <typename Item>
Json series(const std::vector<Item>& items, double unit,
            const std::function<std::pair<Vector3d, Vector3d>(const Item&)>& of) {
  Json t = Json::array(), value = Json::array({Json::array(), Json::array(), Json::array()}), sigma = value;
  for (const std::size_t i : thinned(items.size(), kMostPoints)) {
    t.push_back(items[i].time);
    const auto [v, s] = of(items[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      value[k].push_back(number_or_null(v[static_cast<Eigen::Index>(k)] / unit));
      sigma[k].push_back(number_or_null(s[static_cast<Eigen::Index>(k)] / unit));
    }
  }
  return {{"t", t}, {"value", value}, {"sigma", sigma}};
}

Json errors_json(const Navigation& run) {
  if (!run.reference) return nullptr;
  using E = navigation::ReferenceError;
  const auto& ref = *run.reference;
  Json out = Json::object();
  if (ref.has_position)
    out["position"] = series<E>(ref.errors, 1, [](const E& e) { return std::pair(e.position, e.position_sigma); });
  if (ref.has_velocity)
    out["velocity"] = series<E>(ref.errors, 1, [](const E& e) { return std::pair(e.velocity, e.velocity_sigma); });
  if (ref.has_attitude)
    out["attitude"] =
        series<E>(ref.errors, kDegree, [](const E& e) { return std::pair(e.attitude, e.attitude_sigma); });
  return out;
}

// What the filter claims, where nothing tells the error.
Json claims_json(const Navigation& run) {
  using S = navigation::Solution;
  const Vector3d zero = Vector3d::Zero();
  return {
      {"position", series<S>(run.solutions, 1, [&](const S& s) { return std::pair(zero, s.position_sigma); })},
      {"velocity", series<S>(run.solutions, 1, [&](const S& s) { return std::pair(zero, s.velocity_sigma); })},
      {"attitude", series<S>(run.solutions, kDegree, [&](const S& s) { return std::pair(zero, s.attitude_sigma); })}};
}

Json biases_json(const Navigation& run) {
  using S = navigation::Solution;
  constexpr double kDegreePerHour = kDegree / 3600, kMilliG = 1e-3 * noise::kStandardGravity;
  const auto has = [&](navigation::Carrier carrier) {
    return std::ranges::any_of(run.model.terms, [&](const navigation::ErrorTerm& t) {
      return t.carrier == carrier && t.effect == navigation::Effect::bias;
    });
  };
  Json out = Json::object();
  if (has(navigation::Carrier::gyro))
    out["gyro"] =
        series<S>(run.solutions, kDegreePerHour, [](const S& s) { return std::pair(s.gyro_bias, s.gyro_bias_sigma); });
  if (has(navigation::Carrier::accelerometer))
    out["accelerometer"] = series<S>(
        run.solutions, kMilliG, [](const S& s) { return std::pair(s.accelerometer_bias, s.accelerometer_bias_sigma); });
  return out;
}

Json nis_points(const NavigationResult& r) {
  Json out = Json::array();
  for (const auto& a : r.run.aids) {
    std::vector<const navigation::InnovationAt*> mine;
    for (const auto& i : r.run.innovations)
      if (i.aid == a.aid) mine.push_back(&i);
    Json t = Json::array(), nis = Json::array(), gated = Json::array();
    for (const std::size_t k : thinned(mine.size(), kMostPoints)) {
      t.push_back(mine[k]->time);
      nis.push_back(number_or_null(mine[k]->innovation.nis));
      gated.push_back(mine[k]->innovation.status != navigation::Innovation::Status::used);
    }
    out.push_back({{"name", r.scenario.aids[a.aid].name}, {"t", t}, {"nis", nis}, {"gated", gated}});
  }
  return out;
}

Json track_json(const NavigationResult& r) {
  if (r.run.solutions.empty()) return nullptr;
  const earth::Geodetic origin = r.scenario.site.value_or(earth::to_geodetic(r.run.solutions.front().state.p_eb_e));
  const auto frame = earth::LocalFrame::east_north_up(origin);
  const auto add = [&](Json& to, const Vector3d& p_eb_e) {
    const Vector3d p = frame.from_ecef(p_eb_e);
    to.push_back({p[0], p[1], p[2]});
  };
  Json track = Json::array(), fixes = Json::array();
  for (const std::size_t i : thinned(r.run.solutions.size(), kMostPoints)) add(track, r.run.solutions[i].state.p_eb_e);
  for (std::size_t a = 0; a < r.scenario.aids.size(); ++a) {
    if (r.scenario.aids[a].kind != Aid::Kind::position) continue;
    Json points = Json::array();
    const auto& list = r.recording.fixes[a];
    for (const std::size_t i : thinned(list.size(), kMostPoints)) add(points, list[i].value);
    fixes.push_back({{"name", r.scenario.aids[a].name}, {"points", points}});
  }
  return {{"latitude_deg", origin.latitude / kDegree},
          {"longitude_deg", origin.longitude / kDegree},
          {"track", track},
          {"fixes", fixes}};
}

}  // namespace

std::string navigation_json(const NavigationResult& r) { return text_of(document(r), 2) + "\n"; }

std::string navigation_data(const NavigationResult& r) {
  const Json data{{"navigation", document(r)},
                  {"errors", errors_json(r.run)},
                  {"claims", claims_json(r.run)},
                  {"biases", biases_json(r.run)},
                  {"innovations", nis_points(r)},
                  {"track", track_json(r)},
                  {"not_stated_text", not_stated_text(r.not_stated, kTheseSigmas)}};
  return without_markup(text_of(data, -1));
}

}  // namespace gyrobudget::inline v0::report
