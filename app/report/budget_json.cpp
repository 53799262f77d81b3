// SPDX-License-Identifier: MIT
// Error budgets for programs, and the data that budget.js draws.
#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "budget.h"
#include "budget_words.h"
#include "json_text.h"
#include "page_parts.h"
#include "sensor_words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;
using budget::Component;
using navigation::CoreMatrix;

using earth::kDegree;

Json position_json(const BudgetResult& r, const CoreMatrix& P) {
  Json out;
  for (const Component component : budget::kComponents)
    if (component != Component::horizontal)
      out[std::string(to_string(component))] = number_or_null(r.study.axes.position_sigma(P, component));
  return out;
}

Json errors_json(const BudgetResult& r, const CoreMatrix& P) {
  const navigation::LocalSigmas s = navigation::local_sigmas(P, r.study.axes.C_enu);
  const Eigen::Vector3d a = s.attitude / kDegree;
  return {{"position_m", position_json(r, P)},
          {"velocity_m_s",
           {{"east", s.velocity[0]}, {"north", s.velocity[1]}, {"up", s.velocity[2]}, {"rss", s.velocity.norm()}}},
          {"attitude_deg", {{"east", a[0]}, {"north", a[1]}, {"up", a[2]}, {"total", a.norm()}}}};
}

Json sources_json(const BudgetResult& r) {
  const std::vector<double> share = budget::shares(r.study.budget, r.study.at_index);
  Json list = Json::array();
  for (std::size_t i = 0; i < r.study.budget.lines.size(); ++i) {
    const auto& line = r.study.budget.lines[i];
    Json one{{"name", line.name}, {"share", share[i]}};
    one.update(errors_json(r, r.study.line(i)));
    one["exact_position_rss_m"] = r.study.exact ? number_or_null(position_rss(r, (*r.study.exact)[i])) : Json(nullptr);
    list.push_back(std::move(one));
  }
  return list;
}

Json growth_json(const BudgetResult& r) {
  Json total = Json::array(), sources = Json::object();
  for (const CoreMatrix& P : r.study.budget.total) total.push_back(number_or_null(position_rss(r, P)));
  for (const auto& line : r.study.budget.lines) {
    Json& list = sources[line.name] = Json::array();
    for (const CoreMatrix& P : line.covariance) list.push_back(number_or_null(position_rss(r, P)));
  }
  return {{"t_s", r.study.budget.times}, {"total_position_rss_m", total}, {"sources", sources}};
}

Json left_out_json(const BudgetResult& r) {
  Json list = Json::array();
  for (const auto& l : r.study.left_out)
    list.push_back({{"name", l.name}, {"bound_position_m", number_or_null(l.position)}, {"why", why_left_out(l)}});
  return list;
}

Json not_modelled_json(const BudgetResult& r) {
  Json list = Json::array();
  for (const auto& l : r.study.not_modelled) list.push_back({{"what", l.what}, {"why", l.why}});
  return list;
}

// Ratios of one quantity: 0 position, 1 velocity, 2 attitude.
Json ratio_json(const budget::Agreement& one, std::size_t quantity) {
  Json out;
  for (std::size_t k = 0; k < 3; ++k) {
    const budget::Agreement::Axis& axis = one.axes[3 * quantity + k];
    out[kAxisNames[k]] = axis.matters && axis.first_order ? number_or_null(axis.ratio()) : Json(nullptr);
  }
  return out;
}

Json alone_json(const BudgetResult& r) {
  if (r.study.monte_carlo->sources.empty()) return nullptr;
  const auto agreements = source_agreements(r.study);
  Json list = Json::array();
  for (std::size_t i = 0; i < agreements.size(); ++i) {
    const auto& alone = r.study.monte_carlo->sources[i];
    Json one{{"name", r.study.budget.lines[i].name}, {"runs", alone ? alone->runs : 0}};
    if (alone) {
      one.update(errors_json(r, alone->covariance));
      for (std::size_t q = 0; q < kQuantities.size(); ++q)
        one[fmt::format("{}_ratio", kQuantities[q])] = ratio_json(*agreements[i], q);
    }
    list.push_back(std::move(one));
  }
  return list;
}

Json ratios_json(const BudgetResult& r) {
  if (r.study.monte_carlo->sources.empty()) return nullptr;
  const budget::AllRatios all = budget::all_ratios(r.study);
  return {{"compared", all.compared},
          {"outside", all.outside},
          {"together_low", all.together.lower},
          {"together_high", all.together.upper},
          {"far", far_words(r.study, all)}};
}

Json nees_left_out_json(const BudgetResult& r) {
  Json list = Json::array();
  for (const auto& direction : r.study.monte_carlo->nees.left_out)
    list.push_back(
        {{"direction", direction_text(direction)}, {"linear", direction.linear}, {"found", direction.found}});
  return list;
}

Json monte_carlo_json(const BudgetResult& r) {
  if (!r.study.monte_carlo) return nullptr;
  const auto& mc = *r.study.monte_carlo;
  const CoreMatrix& linear = r.study.total();
  const budget::Agreement total = total_agreement(r.study);
  Json ratio = ratio_json(total, 0);
  for (const Component component : {Component::downrange, Component::crossrange})
    ratio[std::string(to_string(component))] = number_or_null(r.study.axes.position_sigma(mc.covariance, component) /
                                                              r.study.axes.position_sigma(linear, component));
  const navigation::Band band = budget::ratio_band(r.study), nees = budget::nees_band(r.study);
  return {{"runs", mc.runs},
          {"seed", mc.seed},
          {"position_rss_ratio", number_or_null(position_rss(r, mc.covariance) / position_rss(r, linear))},
          {"position_ratio", ratio},
          {"velocity_ratio", ratio_json(total, 1)},
          {"attitude_ratio", ratio_json(total, 2)},
          {"ratio_low", band.lower},
          {"ratio_high", band.upper},
          {"nees", number_or_null(mc.nees.mean)},
          {"nees_dof", mc.nees.dof},
          {"nees_low", nees.lower},
          {"nees_high", nees.upper},
          {"nees_left_out", nees_left_out_json(r)},
          {"saturated", mc.saturated.sum()},
          {"saturated_axes", {{"gyro", mc.saturated.gyro}, {"accelerometer", mc.saturated.accelerometer}}},
          {"contradictions", contradiction_words(r.study)},
          {"sources", alone_json(r)},
          {"ratios", ratios_json(r)}};
}

Json alignment_json(const std::optional<budget::AlignmentTime>& alignment) {
  if (!alignment) return nullptr;
  return {{"met", alignment->met}, {"duration_s", alignment->duration}, {"found_m", number_or_null(alignment->sigma)}};
}

Json limit_json(const BudgetResult& r) {
  if (!r.study.limit) return nullptr;
  Json factors = Json::object();  // of a budget without sources too
  for (std::size_t i = 0; i < r.study.budget.lines.size(); ++i)
    factors[r.study.budget.lines[i].name] = number_or_null(r.study.limit->factors[i]);
  return {{"text", r.limit},
          {"component", to_string(r.study.limit->component)},
          {"limit_m", r.study.limit->limit},
          {"found_m", number_or_null(r.study.limit->found)},
          {"met", r.study.limit->met()},
          {"allowed_factor", factors},
          {"alignment", alignment_json(r.study.limit->alignment)}};
}

Json result_json(const BudgetResult& r) {
  return {{"schema", "gyrobudget.budget/1"},
          {"version", kVersion},
          {"command", r.command},
          {"scene", r.scene},
          {"name", r.name},
          {"sensor", r.sensor.empty() ? Json(nullptr) : Json(r.sensor)},
          {"at_s", r.study.at},
          {"total", errors_json(r, r.study.total())},
          {"claimed", r.study.budget.claimed.empty() ? Json(nullptr) : errors_json(r, r.study.claimed())},
          {"sources", sources_json(r)},
          {"left_out", left_out_json(r)},
          {"tolerance", r.study.tolerance},
          {"not_modelled", not_modelled_json(r)},
          {"not_stated", r.not_stated},
          {"growth", growth_json(r)},
          {"steps", r.study.budget.steps},
          {"flicker_states", r.study.flicker_states},
          {"limit", limit_json(r)},
          {"monte_carlo", monte_carlo_json(r)},
          {"notes", budget_notes(r)}};
}

Json results_json(const std::vector<BudgetResult>& results) {
  if (results.size() == 1) return result_json(results[0]);
  Json list = Json::array();
  for (const auto& r : results) list.push_back(result_json(r));
  return {{"schema", "gyrobudget.budgets/1"}, {"version", kVersion}, {"budgets", list}};
}

// 2 x 2 covariance of a pair of components, for the ellipses.
Json ellipse_json(const Eigen::Matrix3d& local, int i, int j) { return {local(i, i), local(i, j), local(j, j)}; }

Json drawing(const BudgetResult& r) {
  Json out = result_json(r);
  Json ellipses = Json::object();
  const auto add = [&](const std::string& name, const CoreMatrix& P) {
    const Eigen::Matrix3d local = r.study.axes.C_enu.transpose() *
                                  P.block<3, 3>(navigation::kPosition, navigation::kPosition) * r.study.axes.C_enu;
    ellipses[name] = {{"east_north", ellipse_json(local, 0, 1)}, {"east_up", ellipse_json(local, 0, 2)}};
  };
  add("total", r.study.total());
  for (const auto& line : r.study.budget.lines) add(line.name, line.covariance[r.study.at_index]);
  out["ellipses"] = ellipses;
  out["not_stated_text"] = not_stated_text(r.not_stated, kThisTotal);
  Json cloud = Json::array();
  if (r.study.monte_carlo)
    for (const auto& p : r.study.monte_carlo->points) cloud.push_back({p[0], p[1], p[2]});
  out["cloud"] = cloud;
  Json claimed = Json::array();
  for (const CoreMatrix& P : r.study.budget.claimed) claimed.push_back(number_or_null(position_rss(r, P)));
  out["claimed_growth"] = claimed;
  return out;
}

}  // namespace

std::string budget_json(const std::vector<BudgetResult>& results) { return results_json(results).dump(2) + "\n"; }

std::string budget_data(const std::vector<BudgetResult>& results) {
  Json list = Json::array();
  for (const auto& r : results) list.push_back(drawing(r));
  return without_markup(Json{{"budgets", list}}.dump());
}

}  // namespace gyrobudget::inline v0::report
