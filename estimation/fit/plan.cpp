// SPDX-License-Identifier: MIT
#include "plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "information.h"

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;

constexpr std::array kPlanned{Term::quantization, Term::white, Term::flicker, Term::rate_random_walk};
constexpr double kFewestSamples = 16, kMostSamples = 1e15;

Plan::Row row_for(const std::vector<noise::Process>& terms, double duration_s, double dt) {
  const auto samples = static_cast<std::int64_t>(std::llround(duration_s / dt));
  const Eigen::VectorXd bound = relative_bound(terms, samples, dt);
  return {duration_s, {bound.data(), bound.data() + bound.size()}};
}

std::vector<Plan::Row> rows_of(const std::vector<noise::Process>& terms, const PlanOptions& o) {
  const double dt = 1 / o.rate_hz;
  if (o.duration_s) return {row_for(terms, *o.duration_s, dt)};
  if (!o.wishes.empty()) return {};
  constexpr double kHour = 3600;
  std::vector<Plan::Row> rows;
  for (const double hours : {0.5, 1.0, 2.0, 5.0, 10.0, 24.0, 48.0, 100.0, 300.0}) {
    rows.push_back(row_for(terms, hours * kHour, dt));
  }
  return rows;
}

std::vector<PlanOptions::Wish> wishes_of(const Plan& plan, const PlanOptions& o) {
  if (!o.wishes.empty() || o.duration_s) return o.wishes;
  constexpr double kDefaultAccuracy = 0.10;
  std::vector<PlanOptions::Wish> wishes;
  for (const auto& t : plan.terms) wishes.push_back({t.term, kDefaultAccuracy});
  return wishes;
}

bool alike(const noise::ErrorModel& model, std::size_t a, std::size_t b) {
  return std::ranges::all_of(kPlanned, [&](Term t) { return model[t][a] == model[t][b]; });
}

// What one plan has of a term is taken where another knows it worse, or not at all.
Plan worst_of(const std::vector<AxesPlan::Part>& parts) {
  Plan all;
  for (const Term t : kPlanned) {
    double largest = 0;
    for (const auto& part : parts)
      for (const auto& term : part.plan.terms)
        if (term.term == t) largest = std::max(largest, term.value);
    if (largest > 0) all.terms.push_back({t, largest});
  }
  for (std::size_t r = 0; r < parts.front().plan.rows.size(); ++r) {
    Plan::Row& row = all.rows.emplace_back(Plan::Row{parts.front().plan.rows[r].duration_s, {}});
    for (const auto& term : all.terms) {
      double worst = 0;
      for (const auto& part : parts)
        for (std::size_t i = 0; i < part.plan.terms.size(); ++i)
          if (part.plan.terms[i].term == term.term) worst = std::max(worst, part.plan.rows[r].relative_std[i]);
      row.relative_std.push_back(worst);
    }
  }
  for (const auto& part : parts) {
    for (const auto& answer : part.plan.answers) {
      const auto same = std::ranges::find_if(all.answers, [&](const Plan::Answer& a) {
        return a.term == answer.term && a.relative_std == answer.relative_std;
      });
      if (same == all.answers.end())
        all.answers.push_back(answer);
      else
        same->duration_s = std::max(same->duration_s, answer.duration_s);
    }
  }
  return all;
}

}  // namespace

std::vector<noise::Process> planned_terms(const noise::ErrorModel& model, std::size_t axis) {
  std::vector<noise::Process> list;
  for (const Term t : kPlanned) {
    if (const double c = model[t][axis]; c > 0) list.push_back(noise::with_coefficient(noise::unit_process(t), c));
  }
  return list;
}

bool can_plan(double duration_s, double rate_hz) {
  const double dt = 1 / rate_hz;
  return duration_s >= kFewestSamples * dt && duration_s <= kMostSamples * dt;
}

Plan plan(const noise::ErrorModel& model, const PlanOptions& options) {
  const auto terms = planned_terms(model, options.axis);
  if (terms.empty()) throw std::invalid_argument("a sensor without Q, N, B and K has no record to plan");
  if (options.duration_s && !can_plan(*options.duration_s, options.rate_hz)) {
    throw std::invalid_argument(fmt::format("a record of {:g} s at {:g} Hz; one of {:g} to {:g} samples is expected",
                                            *options.duration_s, options.rate_hz, kFewestSamples, kMostSamples));
  }
  Plan plan;
  for (const auto& process : terms) plan.terms.push_back({noise::term(process), noise::coefficient(process)});
  plan.rows = rows_of(terms, options);
  for (const auto& wish : wishes_of(plan, options)) {
    const auto at = std::ranges::find(plan.terms, wish.term, &Plan::Term::term);
    if (at == plan.terms.end()) {
      throw std::invalid_argument(fmt::format("the model has no {} above zero that a record could be planned for",
                                              static_cast<char>(wish.term)));
    }
    const auto index = static_cast<std::size_t>(at - plan.terms.begin());
    plan.answers.push_back(
        {wish.term, wish.relative_std, duration_for(terms, index, wish.relative_std, 1 / options.rate_hz)});
  }
  return plan;
}

AxesPlan plan_axes(const noise::ErrorModel& model, const PlanOptions& options) {
  AxesPlan result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto terms = planned_terms(model, axis);
    const auto known = std::ranges::find_if(
        result.parts, [&](const AxesPlan::Part& part) { return alike(model, part.axes.front(), axis); });
    if (known != result.parts.end()) {
      known->axes.push_back(axis);
      continue;
    }
    PlanOptions own = options;
    own.axis = axis;
    std::erase_if(own.wishes,
                  [&](const auto& wish) { return std::ranges::find(terms, wish.term, noise::term) == terms.end(); });
    if (terms.empty() || (own.wishes.empty() && !options.wishes.empty())) continue;
    result.parts.push_back({{axis}, plan(model, own)});
  }
  if (result.parts.empty()) return {{{{0, 1, 2}, plan(model, options)}}, {}};  // which says why there is none
  result.all = worst_of(result.parts);
  return result;
}

}  // namespace gyrobudget::inline v0::fit
