// SPDX-License-Identifier: MIT
#include "axis_fit.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/statistics.h"
#include "gyrobudget/estimation/fit/judgement.h"
#include "gyrobudget/estimation/fit/visual.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace gyrobudget::inline v0::calibration::detail {
namespace {

using noise::Term;

allan::Curve pick(const allan::Curve& curve, const std::vector<std::int64_t>& factors) {
  allan::Curve picked = curve;
  std::erase_if(picked.points, [&](const auto& p) { return !std::ranges::binary_search(factors, p.m); });
  return picked;
}

bool holds(const std::vector<Term>& terms, Term t) { return std::ranges::find(terms, t) != terms.end(); }

// Correlation times and frequencies are found for each axis: its covariance is of no use to others.
bool has_shape(const std::vector<Term>& terms) {
  return holds(terms, Term::gauss_markov) || holds(terms, Term::sinusoid);
}

bool same_gaps(const allan::Mask* a, const allan::Mask* b) {
  if (a == nullptr || b == nullptr) return a == b;
  return std::ranges::equal(a->runs(), b->runs(),
                            [](const auto& x, const auto& y) { return x.first == y.first && x.count == y.count; });
}

Covariances::Shared make_covariance(const allan::Curve& curve, const std::vector<Term>& terms) {
  std::vector<std::int64_t> factors;
  for (const auto& p : curve.points) factors.push_back(p.m);
  std::vector<noise::Process> processes;
  for (const Term t : terms) processes.push_back(noise::unit_process(t));
  return std::make_shared<const allan::CurveCovariance>(curve.samples, std::move(factors), curve.dt,
                                                        std::move(processes), curve.form, curve.mask.get());
}

void check_enough(const std::string& axis, const allan::Curve& curve, std::size_t terms) {
  const auto usable =
      std::ranges::count_if(curve.points, [](const auto& p) { return p.terms > 0 && std::isfinite(p.variance); });
  if (static_cast<std::size_t>(usable) > terms) return;
  const std::int64_t missing = curve.mask ? curve.mask->missing() : 0;
  throw Unusable(
      Unusable::Reason::too_few_taus,
      fmt::format(
          "column '{}': found {} usable averaging times, expected at least {} to fit {} terms; {} of {} samples are missing, and a cluster needs 95 % of its own",
          axis, usable, terms + 1, terms, missing, curve.samples));
}

bool is_silent(const allan::Curve& curve) {
  return std::ranges::all_of(curve.points, [](const auto& p) { return !(p.variance > 0); });
}

std::vector<Term> terms_for(const Options& options, const std::vector<allan::Identified>& identified) {
  if (options.terms) return *options.terms;
  std::vector<Term> terms{Term::white, Term::flicker, Term::rate_random_walk};
  if (!identified.empty() && identified.front().alpha == 2) terms.insert(terms.begin(), Term::quantization);
  return terms;
}

// The raw minimum of the curve that is shown.
void note_minimum(fit::Result& fit, const allan::Curve& display) {
  for (std::size_t i = 0; i < display.points.size(); ++i) {
    const auto& p = display.points[i];
    if (p.terms < 1 || !std::isfinite(p.variance) || p.m * 10 > display.samples) continue;
    const double deviation = std::sqrt(p.variance);
    if (!(fit.minimum_deviation > 0) || deviation < fit.minimum_deviation) {
      fit.minimum_deviation = deviation;
      fit.minimum_tau_s = display.tau(i);
    }
  }
}

// What choosing the terms saw, for the fit to begin from.
struct Seen {
  std::optional<double> correlation_time_s, frequency_hz;
  std::optional<double> tau_min_s;
};

// `rate` is empty for a table.
fit::Result fit_curves(const Curves& curves, std::span<const double> rate, const std::vector<Term>& terms,
                       const std::string& axis, Job& job, const Seen& seen = {}) {
  const Options& o = job.options;
  fit::Options options;
  options.terms = terms;
  options.method = o.method;
  options.tau_min_s = seen.tau_min_s ? seen.tau_min_s : o.tau_min_s;
  options.tau_max_s = o.tau_max_s;
  options.correlation_time_s = o.correlation_time_s;
  options.frequency_hz = o.frequency_hz;
  options.front_end = o.front_end;
  options.front_end_kind = o.front_end_kind;
  options.find_front_end = o.find_front_end;
  options.near_correlation_time_s = seen.correlation_time_s;
  options.near_frequency_hz = seen.frequency_hz;
  if (o.method != fit::Method::whittle) check_enough(axis, curves.octaves, options.terms.size());
  // Readings are made on the curve that the person sees.
  const bool reads = fit::is_reading(o.method) && !is_silent(curves.display);
  fit::Data data{.rate = rate, .dt = curves.octaves.dt, .curve = reads ? &curves.display : &curves.octaves};
  Covariances::Shared covariance;
  if (!reads && o.method != fit::Method::whittle && !has_shape(terms)) {
    covariance = job.covariances.of(curves.octaves, options.terms);
    data.covariance = covariance.get();
  }
  fit::Result result = fit::fit(data, options);
  if (!reads) note_minimum(result, curves.display);
  return result;
}

// Chooses the terms from `tau_min_s` on, and fits them there.
void fit_chosen(Fitted& f, const allan::Series& series, std::optional<double> tau_min_s, const std::string& axis,
                Job& job, Stages& stages) {
  const auto fitted = [&](const std::vector<Term>& terms, const Seen& seen) {
    return fit_curves(f.curves, series.rate(), terms, axis, job, seen);
  };
  f.chosen.reset();
  stages.attempt(Stage::choice, [&] {
    fit::SelectionOptions options{.tau_min_s = tau_min_s};
    const fit::Result plain = fitted({Term::white, Term::flicker, Term::rate_random_walk}, {.tau_min_s = tau_min_s});
    if (plain.front_end && plain.front_end->kind) options.front_end = plain.front_end->value();
    Chosen chosen{.selection = fit::choose_terms(series.rate(), series.dt(), options), .alternative_fit = {}};
    if (const auto& other = chosen.selection.alternative) {
      chosen.alternative_fit =
          fitted(other->terms, {other->correlation_time_s, chosen.selection.frequency_hz, tau_min_s});
    }
    f.chosen = std::move(chosen);
  });
  stages.enter(Stage::fit);
  const fit::Selection s = f.chosen ? f.chosen->selection : fit::Selection{};
  f.fit = fitted(s.terms.empty() ? terms_for(job.options, f.curves.identified) : s.terms,
                 {s.correlation_time_s, s.frequency_hz, tau_min_s});
}

}  // namespace

Curves curves_of(const allan::Series& series, const Options& options) {
  const auto display = allan::factors_of(options.taus, series.samples());
  const auto octaves = allan::octave_factors(series.samples());
  std::vector<std::int64_t> both;
  std::ranges::set_union(display, octaves, std::back_inserter(both));
  const allan::Curve curve = allan::overlapped_variance(series, both, options.form);
  allan::Curve shown = pick(curve, display);
  auto identified = allan::identify_noise(series, shown);
  return {std::move(shown), pick(curve, octaves), std::move(identified)};
}

Covariances::Shared Covariances::of(const allan::Curve& curve, const std::vector<Term>& terms) {
  const std::scoped_lock lock(mutex_);
  for (const auto& known : known_) {
    if (known.terms == terms && known.samples == curve.samples && same_gaps(known.mask.get(), curve.mask.get()))
      return known.covariance;
  }
  // Isolated: a thread that waits in here must not take up another axis, which would want the lock.
  tbb::this_task_arena::isolate([&] {
    known_.push_back({terms, curve.samples, curve.mask, make_covariance(curve, terms)});
  });
  return known_.back().covariance;
}

Fitted fit_axis(const allan::Series& series, const std::string& name, Job& job, Stages& stages) {
  const Options& o = job.options;
  stages.enter(Stage::curve);
  Fitted f{.curves = curves_of(series, o), .fit = {}, .chosen = {}};
  if (!o.choose_terms) {
    stages.enter(Stage::fit);
    f.fit = fit_curves(f.curves, series.rate(), terms_for(o, f.curves.identified), name, job);
    return f;
  }
  fit_chosen(f, series, o.tau_min_s, name, job, stages);
  // What was chosen does not describe the shortest taus: it may owe terms to them, so it is chosen again without.
  const double shortest = o.tau_min_s.value_or(0);
  if (f.chosen && !f.fit.moved.empty() && f.fit.tau_min_s > shortest)
    fit_chosen(f, series, f.fit.tau_min_s, name, job, stages);
  return f;
}

fit::Result fit_table(const Curves& curves, const std::string& name, Job& job) {
  return fit_curves(curves, {}, terms_for(job.options, {}), name, job);
}

std::optional<LaterStart> later_start(const fit::Result& fit, const Curves& curves, std::span<const double> rate,
                                      const std::string& name, Job& job) {
  constexpr int kSpare = 2;  // a start must leave this many tested taus more than terms
  if (fit.method != fit::Method::gls || fit.verdict == fit::Verdict::described || fit.fitted_terms.empty()) return {};
  const auto terms = static_cast<int>(fit.fitted_terms.size());
  Seen seen;
  if (const auto* g = fit::find(fit, Term::gauss_markov)) seen.correlation_time_s = g->shape;
  if (const auto* line = fit::find(fit, Term::sinusoid)) seen.frequency_hz = line->shape;
  std::optional<LaterStart> found;
  int tested = fit.dof + terms;  // at most: those with 16 clusters
  for (const fit::Residual& r : fit.residuals) {
    if (r.tau_s <= fit.tau_min_s) continue;
    if (--tested < std::max(terms + kSpare, (fit.dof + terms) / 2)) break;
    seen.tau_min_s = r.tau_s;
    const fit::Result from_here = fit_curves(curves, rate, fit.fitted_terms, name, job, seen);
    const bool described = from_here.verdict == fit::Verdict::described && !holds_no_answer(from_here);
    if (!described)
      found.reset();
    else if (found)
      return found;
    else
      found = LaterStart{r.tau_s, from_here.p_value};
  }
  return {};
}

}  // namespace gyrobudget::inline v0::calibration::detail
