// SPDX-License-Identifier: MIT
#include "fitting.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/app/report/words.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/estimation/fit/selection.h"
#include "gyrobudget/estimation/fit/visual.h"
#include "gyrobudget/estimation/fit/whittle.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "advice.h"
#include "analysis.h"
#include "prepared.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

allan::Curve pick(const allan::Curve& curve, const std::vector<std::int64_t>& factors) {
  allan::Curve picked = curve;
  std::erase_if(picked.points, [&](const auto& p) { return !std::binary_search(factors.begin(), factors.end(), p.m); });
  return picked;
}

bool holds(const std::vector<Term>& terms, Term t) { return std::find(terms.begin(), terms.end(), t) != terms.end(); }

// Correlation times and frequencies are found for each axis: its covariance is of no use to others.
bool has_shape(const std::vector<Term>& terms) {
  return holds(terms, Term::gauss_markov) || holds(terms, Term::sinusoid);
}

bool same_gaps(const allan::Mask* a, const allan::Mask* b) {
  if (a == nullptr || b == nullptr) return a == b;
  return std::equal(a->runs().begin(), a->runs().end(), b->runs().begin(), b->runs().end(),
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

void check_enough(const allan::Axis& axis, const allan::Curve& curve, std::size_t terms) {
  const auto usable = std::count_if(curve.points.begin(), curve.points.end(),
                                    [](const auto& p) { return p.terms > 0 && std::isfinite(p.variance); });
  if (static_cast<std::size_t>(usable) > terms) return;
  const std::int64_t missing = curve.mask ? curve.mask->missing() : 0;
  throw text::InputError(fmt::format(
      "column '{}': found {} usable averaging times, expected at least {} to fit {} terms; {} of {} samples are missing, and a cluster needs 95 % of its own; fit fewer terms (--terms) or use a part of the log without gaps",
      axis.name, usable, terms + 1, terms, missing, curve.samples));
}

// Variances are of squares: beyond these they leave double, and what came out would be no answer.
void check_scale(const allan::Axis& axis) {
  constexpr double kLeast = 1e-120, kMost = 1e120;
  double low = std::numeric_limits<double>::infinity(), high = -low, size = 0;
  for (const double y : axis.rate) {
    if (std::isfinite(y)) low = std::min(low, y), high = std::max(high, y), size = std::max(size, std::abs(y));
  }
  const double range = 0.5 * high - 0.5 * low;
  if (!(size > kMost) && (!(range > 0) || range >= kLeast)) return;
  throw text::InputError(fmt::format(
      "column '{}': found samples up to {:.3g} that vary by {:.3g} (SI), expected sizes from {:g} to {:g}: the squares of others leave double; give their unit, or bring them there with --scale",
      axis.name, size, 2 * range, kLeast, kMost));
}

bool is_silent(const allan::Curve& curve) {
  return std::all_of(curve.points.begin(), curve.points.end(), [](const auto& p) { return !(p.variance > 0); });
}

// The likelihood over the range of taus that the curve's fit used, and whether the two agree.
report::CrossChecked cross_check(const fit::Result& fit, const Prepared& prepared) {
  fit::Options options;
  options.method = fit::Method::whittle;
  options.terms = fit.fitted_terms;
  options.tau_min_s = fit.tau_min_s;
  options.tau_max_s = fit.tau_max_s;
  if (holds(options.terms, Term::gauss_markov)) options.correlation_time_s = fit[Term::gauss_markov].shape;
  if (holds(options.terms, Term::sinusoid)) options.frequency_hz = fit[Term::sinusoid].shape;
  report::CrossChecked checked;
  checked.likelihood = fit::fit_likelihood(prepared.record().rate(), prepared.record().dt(), options);
  checked.check = fit::cross_check(fit, checked.likelihood);
  return checked;
}

// Everything about one axis that is made again where a part of the record is masked.
struct Fitted {
  Curves curves;
  fit::Result fit;
  std::optional<report::Chosen> chosen;
};

// Chooses the terms from `tau_min_s` on, and fits them there.
void fit_chosen(Fitted& f, const allan::Series& record, std::optional<double> tau_min_s, const allan::Axis& axis,
                const CalibrateArguments& a, Covariances& covariances) {
  f.chosen.emplace();
  f.chosen->selection = fit::choose_terms(record.rate(), record.dt(), {.tau_min_s = tau_min_s});
  const fit::Selection& s = f.chosen->selection;
  const auto fitted = [&](const std::vector<Term>& terms, std::optional<double> time) {
    return fit_curves(f.curves, record.rate(), terms, axis, a, covariances, {time, s.frequency_hz, tau_min_s});
  };
  if (s.alternative) f.chosen->alternative_fit = fitted(s.alternative->terms, s.alternative->correlation_time_s);
  f.fit = fitted(s.terms.empty() ? terms_for(a, f.curves.identified) : s.terms, s.correlation_time_s);
}

Fitted fit_axis(const Prepared& prepared, const allan::Axis& axis, const CalibrateArguments& a,
                Covariances& covariances) {
  const auto& record = prepared.record();
  Fitted f{.curves = curves_of(record, a.curve)};
  if (!a.choose_terms) {
    f.fit = fit_curves(f.curves, record.rate(), terms_for(a, f.curves.identified), axis, a, covariances);
    return f;
  }
  fit_chosen(f, record, a.tau_min_s, axis, a, covariances);
  // What was chosen does not describe the shortest taus: it may owe terms to them, so it is chosen again without.
  const double shortest = a.tau_min_s.value_or(0);
  if (!f.fit.moved.empty() && f.fit.tau_min_s > shortest) fit_chosen(f, record, f.fit.tau_min_s, axis, a, covariances);
  return f;
}

}  // namespace

std::vector<Term> terms_for(const CalibrateArguments& a, const std::vector<allan::Identified>& identified) {
  if (a.terms) return *a.terms;
  std::vector<Term> terms{Term::white, Term::flicker, Term::rate_random_walk};
  if (!identified.empty() && identified.front().alpha == 2) terms.insert(terms.begin(), Term::quantization);
  return terms;
}

Curves curves_of(const allan::Series& record, const CurveArguments& a) {
  const auto display = factors_for(a, record.samples());
  const auto octaves = allan::octave_factors(record.samples());
  std::vector<std::int64_t> both;
  std::set_union(display.begin(), display.end(), octaves.begin(), octaves.end(), std::back_inserter(both));
  const allan::Curve curve = allan::overlapped_variance(record, both, form_of(a));
  return {pick(curve, display), pick(curve, octaves), allan::identify_noise(record, display)};
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

fit::Result fit_curves(const Curves& curves, std::span<const double> rate, const std::vector<Term>& terms,
                       const allan::Axis& axis, const CalibrateArguments& a, Covariances& covariances,
                       const Seen& seen) {
  fit::Options options;
  options.terms = terms;
  options.method = a.method;
  options.tau_min_s = seen.tau_min_s ? seen.tau_min_s : a.tau_min_s;
  options.tau_max_s = a.tau_max_s;
  options.correlation_time_s = a.correlation_time_s;
  options.frequency_hz = a.frequency_hz;
  options.near_correlation_time_s = seen.correlation_time_s;
  options.near_frequency_hz = seen.frequency_hz;
  if (a.method != fit::Method::whittle) check_enough(axis, curves.octaves, options.terms.size());
  // Readings are made on the curve that the person sees.
  const bool reads = report::is_reading(a.method) && !is_silent(curves.display);
  fit::Data record{.rate = rate, .dt = curves.octaves.dt, .curve = reads ? &curves.display : &curves.octaves};
  Covariances::Shared covariance;
  if (!reads && a.method != fit::Method::whittle && !has_shape(terms)) {
    covariance = covariances.of(curves.octaves, options.terms);
    record.covariance = covariance.get();
  }
  fit::Result result = fit::fit(record, options);
  if (!reads) note_minimum(result, curves.display);
  return result;
}

report::AxisResult calibrate_axis(const allan::Axis& axis, double rate_hz, const CalibrateArguments& a,
                                  Covariances& covariances) {
  check_scale(axis);
  Prepared prepared(axis, 1 / rate_hz, a);
  Fitted fitted = fit_axis(prepared, axis, a, covariances);
  if (prepared.look_for_departure(fitted.fit.processes())) fitted = fit_axis(prepared, axis, a, covariances);
  auto& [curves, fit, chosen] = fitted;
  prepared.look_for_lines(fit);
  report::AxisResult result{.name = axis.name, .signal = axis.signal, .mean = curves.octaves.mean};
  const auto mix = fit.verdict == fit::Verdict::not_described ? std::vector<noise::Process>{} : fit.processes();
  result.points = allan::deviation_points(curves.display, curves.identified, mix);
  if (a.cross_check && !fit.fitted_terms.empty()) result.cross_checked = cross_check(fit, prepared);
  result.advice = advise(fit, axis, curves.octaves, describe(prepared.findings(), axis, 1 / rate_hz));
  result.findings = prepared.findings();
  result.chosen = std::move(chosen);
  result.fit = std::move(fit);
  return result;
}

}  // namespace gyrobudget::inline v0::cli
