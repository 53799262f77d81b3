// SPDX-License-Identifier: MIT
#include "plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "information.h"

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;

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

}  // namespace

std::vector<noise::Process> planned_terms(const noise::ErrorModel& model) {
  std::vector<noise::Process> list;
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk}) {
    if (model[t] > 0) list.push_back(noise::with_coefficient(noise::unit_process(t), model[t]));
  }
  return list;
}

bool can_plan(double duration_s, double rate_hz) {
  const double dt = 1 / rate_hz;
  return duration_s >= kFewestSamples * dt && duration_s <= kMostSamples * dt;
}

Plan plan(const noise::ErrorModel& model, const PlanOptions& options) {
  const auto terms = planned_terms(model);
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

}  // namespace gyrobudget::inline v0::fit
