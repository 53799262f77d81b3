// SPDX-License-Identifier: MIT
#include "facts.h"

#include "gyrobudget/estimation/fit/information.h"
#include "gyrobudget/estimation/fit/judgement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace gyrobudget::inline v0::calibration {
namespace {

using fit::Status;
using noise::Term;

// The bound is of random processes: a line adds nothing to what a longer record must be, a ramp hides the walk.
std::optional<LongerRecord> longer_for(const fit::Result& fit, Term term, const allan::Curve& octaves) {
  const auto& c = fit[term];
  constexpr double kReads = 1.05;  // what reads as the wanted accuracy is as good
  if (!c.fitted || c.relative_std <= kReads * kWantedAccuracy) return std::nullopt;
  auto processes = fit.processes();
  std::erase_if(processes, [](const auto& p) { return noise::term(p) == Term::sinusoid; });
  const auto at = std::ranges::find(processes, term, [](const auto& p) { return noise::term(p); });
  const bool ramp =
      std::ranges::find(processes, Term::rate_ramp, [](const auto& p) { return noise::term(p); }) != processes.end();
  if (at == processes.end() || ramp) return std::nullopt;
  const double needed =
      fit::duration_for(processes, static_cast<std::size_t>(at - processes.begin()), kWantedAccuracy, octaves.dt);
  const double have = static_cast<double>(octaves.samples) * octaves.dt;
  if (!(needed > have)) return std::nullopt;
  return LongerRecord{.term = term,
                      .relative_std = c.relative_std,
                      .identified = c.status == Status::identified,
                      .duration_s = have,
                      .needed_s = needed};
}

bool all_equal(const allan::Curve& curve) {
  return std::ranges::all_of(curve.points, [](const auto& p) { return !(p.variance > 0); });
}

}  // namespace

bool holds_no_answer(const fit::Result& fit) {
  constexpr std::array kAnswers{Term::white, Term::flicker, Term::rate_random_walk, Term::gauss_markov};
  return std::ranges::none_of(kAnswers, [&](Term t) {
    const auto c = std::ranges::find(fit.coefficients, t, &fit::Coefficient::term);
    return c != fit.coefficients.end() && c->fitted && c->status == Status::identified;
  });
}

Facts facts_of(const fit::Result& fit, const allan::Curve& octaves) {
  Facts facts{.all_equal = all_equal(octaves), .no_answer = holds_no_answer(fit)};
  if (facts.all_equal) return facts;
  facts.only_quantization = facts.no_answer && fit[Term::quantization].status == Status::identified;
  if (fit.verdict == fit::Verdict::not_described) {
    facts.untested = fit::has_p_value(fit.method) && fit.dof < 1;
    facts.misfit = fit::has_p_value(fit.method) && !facts.untested;
    return facts;
  }
  const auto& walk = fit[Term::rate_random_walk];
  facts.walk_unresolved = walk.fitted && walk.status != Status::identified;
  for (const Term term : {Term::flicker, Term::rate_random_walk})
    if (auto longer = longer_for(fit, term, octaves)) facts.longer.push_back(*longer);
  return facts;
}

}  // namespace gyrobudget::inline v0::calibration
