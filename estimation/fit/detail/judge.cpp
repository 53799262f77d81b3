// SPDX-License-Identifier: MIT
#include "judge.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFailedModelLevel = 1e-3;  // of the F test that a term must pass where the model fails its own
constexpr std::array kOrder{Term::quantization, Term::white,        Term::flicker, Term::rate_random_walk,
                            Term::rate_ramp,    Term::gauss_markov, Term::sinusoid};
constexpr std::size_t kAlwaysListed = 5;  // Q N B K R

std::ptrdiff_t place(Term t) { return std::find(kOrder.begin(), kOrder.end(), t) - kOrder.begin(); }

}  // namespace

std::vector<Term> in_order(std::span<const Term> asked) {
  std::vector<Term> terms;
  for (const Term t : kOrder) {
    const auto count = std::count(asked.begin(), asked.end(), t);
    if (count > 1) throw std::invalid_argument(fmt::format("term {} is asked for twice", static_cast<char>(t)));
    if (count == 1) terms.push_back(t);
  }
  if (terms.size() != asked.size() || terms.empty()) {
    throw std::invalid_argument("the terms to fit must be one or more of Q, N, B, K, R, G, S");
  }
  return terms;
}

noise::Process shaped_process(Term t, const Options& options) {
  if (t == Term::white && options.front_end) return noise::FilteredWhite{1, *options.front_end};
  noise::Process process = noise::unit_process(t);
  if (auto* g = std::get_if<noise::GaussMarkov>(&process))
    g->correlation_time = options.correlation_time_s.value_or(g->correlation_time);
  if (auto* s = std::get_if<noise::Sinusoid>(&process)) s->frequency = options.frequency_hz.value_or(s->frequency);
  return process;
}

double chi_square_tail(double chi2, double dof) {
  const double hopeless = 2000 + 100 * dof;  // below 1e-300, where the series of gamma_q fail
  return chi2 < hopeless ? boost::math::gamma_q(0.5 * dof, 0.5 * chi2) : 0;
}

Cuts cuts_of(double p_value, double chi2, int dof, const Options& options) {
  if (p_value >= options.p_value_limit || dof < 1) return {};
  const double excess = std::max(1.0, chi2 / dof);
  const boost::math::fisher_f_distribution<> F(1, dof);
  return {excess * boost::math::quantile(complement(F, kFailedModelLevel)), excess * kBoundaryCut,
          excess * kIntervalCut};
}

Coefficient judge(Term term, double theta, double deviation, double scale, const Cuts& cuts, const HeldTest& test,
                  bool intervals) {
  Coefficient c;
  c.term = term;
  c.fitted = true;
  c.value = std::sqrt(theta * scale);
  c.relative_std = theta > 0 ? 0.5 * deviation / theta : kInfinity;
  c.lower = c.upper = c.upper_two_sided = c.value;
  c.status = theta > 0 ? Status::identified : Status::upper_bound;
  if (!intervals) return c;
  c.boundary_test = theta > 0 ? test(0) : 0;
  const bool identified = c.boundary_test > cuts.boundary;
  c.status = identified ? Status::identified : Status::upper_bound;
  const ProfileInterval interval = profile_interval(test, theta, deviation, cuts.two_sided);
  c.lower = identified ? std::sqrt(interval.lower * scale) : 0;
  c.upper = c.upper_two_sided = std::sqrt(interval.upper * scale);
  if (!identified) c.upper = std::sqrt(profile_interval(test, theta, deviation, cuts.one_sided).upper * scale);
  return c;
}

Coefficient without_answer(Term term, double theta, double scale) {
  Coefficient c;
  c.term = term;
  c.fitted = true;
  c.value = std::sqrt(theta * scale);
  c.upper = c.upper_two_sided = c.relative_std = kInfinity;
  c.status = Status::upper_bound;
  return c;
}

void complete(std::vector<Coefficient>& list) {
  for (const Term t : std::span(kOrder).first(kAlwaysListed)) {
    const bool listed = std::any_of(list.begin(), list.end(), [=](const auto& c) { return c.term == t; });
    if (!listed) list.push_back({.term = t});
  }
  std::sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return place(a.term) < place(b.term); });
}

Result no_answer(Method method, std::span<const Term> asked) {
  Result result;
  result.method = method;
  for (const Term t : asked) result.coefficients.push_back({.term = t, .relative_std = kInfinity});
  complete(result.coefficients);
  return result;
}

void add_beta(Result& result) {
  const double N = result[Term::white].value, B = result[Term::flicker].value, K = result[Term::rate_random_walk].value;
  result.beta = N > 0 && K > 0 ? (B / N) * (B / K) : 0;
}

Verdict verdict_of(const Result& result, const Options& options) {
  if (result.dof >= 1 && result.p_value >= options.p_value_limit) return Verdict::described;
  const bool near = result.dof >= 1 && result.worst_misfit <= options.misfit_limit;
  return near ? Verdict::described_within : Verdict::not_described;
}

void rescale(Result& result, double factor) {
  for (Coefficient& c : result.coefficients) {
    for (double* value : {&c.value, &c.lower, &c.upper, &c.upper_two_sided}) *value *= factor;
  }
  result.covariance *= factor;
  result.covariance *= factor;
  for (Residual& r : result.residuals) r.measured *= factor, r.model *= factor;
  for (Move& move : result.moved) move.from *= factor, move.to *= factor;
  result.minimum_deviation *= factor;
}

}  // namespace gyrobudget::inline v0::fit
