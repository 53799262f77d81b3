// SPDX-License-Identifier: MIT
#include "time_tags.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "runner.h"

namespace gyrobudget::inline v0::navigation::detail {
namespace {

constexpr int kMostRuns = 5;
constexpr double kStill = 0.1;   // sigma
constexpr double kLearnt = 0.5;  // of its sigma at the start
constexpr double kWide = 10;     // times the aids' sigmas, to get through where they are too sharp

// The same with wider fixes, to find the tags by: a filter that refuses them learns nothing.
Navigation run_wide(Scenario scenario, const Recording& recording) {
  for (Aid& aid : scenario.aids) aid.sigma_factor *= kWide;
  scenario.smooth = false;
  scenario.solution_interval = std::max(scenario.solution_interval, 1.0);
  return run(scenario, recording);
}

// Estimates of the last solution, of the terms that are time tags and were learnt; else 0. What the fixes hardly tell
// is as good as what was told before: shifted again and again it would leave that behind.
struct Tags {
  std::vector<double> values;
  double in_sigmas = 0;  ///< the largest
};
Tags tags(const Navigation& found) {
  Tags result;
  result.values.assign(found.model.terms.size(), 0);
  if (found.solutions.empty()) return result;
  const Solution& last = found.solutions.back();
  for (std::size_t k = 0; k < result.values.size(); ++k) {
    const bool learnt = last.term_sigmas[k] < kLearnt * found.initial[k];
    if (found.model.terms[k].effect != Effect::time_tag || !learnt) continue;
    result.values[k] = last.terms[k];
    result.in_sigmas = std::max(result.in_sigmas, std::abs(last.terms[k]) / last.term_sigmas[k]);
  }
  return result;
}

void shift_stamps(const std::vector<ErrorTerm>& terms, const std::vector<double>& tags, std::vector<Aid>& aids) {
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (terms[k].effect != Effect::time_tag) continue;
    for (int i = terms[k].aid; i < terms[k].aid + terms[k].aids; ++i)
      aids[static_cast<std::size_t>(i)].time_tag += tags[k];
  }
}

}  // namespace

Navigation run_with_time_tags(const Scenario& scenario, const Recording& recording) {
  Navigation found = run(scenario, recording);
  const std::vector<ErrorTerm> terms = found.model.terms;
  const auto is_tag = [](const ErrorTerm& term) { return term.effect == Effect::time_tag; };
  if (std::ranges::none_of(terms, is_tag)) return found;
  Scenario shifted = scenario;
  std::vector<double> shifts(terms.size(), 0);
  for (int runs = 1; runs < kMostRuns; ++runs) {
    const Tags moved = tags(found.usable() ? found : run_wide(shifted, recording));
    if (moved.in_sigmas < kStill) break;
    shift_stamps(terms, moved.values, shifted.aids);
    for (std::size_t k = 0; k < shifts.size(); ++k) shifts[k] += moved.values[k];
    found = run(shifted, recording);
  }
  for (Solution& s : found.solutions)
    for (std::size_t k = 0; k < shifts.size(); ++k) s.terms[k] += shifts[k];
  return found;
}

}  // namespace gyrobudget::inline v0::navigation::detail
