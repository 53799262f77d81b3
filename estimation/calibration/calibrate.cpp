// SPDX-License-Identifier: MIT
#include "calibrate.h"

#include "gyrobudget/estimation/fit/judgement.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <utility>

#include "detail/axis_fit.h"
#include "detail/screened.h"
#include "detail/stages.h"

namespace gyrobudget::inline v0::calibration {
namespace {

using detail::Fitted;
using detail::Job;
using detail::Screened;
using noise::Term;

void check_length(const allan::Record& record) {
  if (!(record.rate_hz > 0 && std::isfinite(record.rate_hz)))
    throw std::invalid_argument(fmt::format("rate is {} Hz, expected it positive and finite", record.rate_hz));
  for (const allan::Axis& axis : record.axes) {
    if (static_cast<std::int64_t>(axis.rate.size()) == record.samples) continue;
    throw std::invalid_argument(
        fmt::format("axis '{}' has {} samples, expected the record's {}", axis.name, axis.rate.size(), record.samples));
  }
  if (record.samples < kFewestSamples)
    throw Unusable(Unusable::Reason::too_short, fmt::format("{}: found {} samples, expected at least {}", record.source,
                                                            record.samples, kFewestSamples));
}

// Variances are of squares: beyond these they leave double, and what came out would be no answer.
void check_scale(const allan::Axis& axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low, size = 0;
  for (const double y : axis.rate) {
    if (std::isfinite(y)) low = std::min(low, y), high = std::max(high, y), size = std::max(size, std::abs(y));
  }
  const double range = 0.5 * high - 0.5 * low;
  if (!(size > kLargestSample) && (!(range > 0) || range >= kSmallestVariation)) return;
  throw Unusable(
      Unusable::Reason::out_of_scale,
      fmt::format(
          "column '{}': found samples up to {:.3g} that vary by {:.3g} (SI), expected sizes from {:g} to {:g}: the squares of others leave double",
          axis.name, size, 2 * range, kSmallestVariation, kLargestSample));
}

// The likelihood over the range of taus that the curve's fit used, and whether the two agree.
CrossChecked cross_check(const fit::Result& fit, const allan::Series& series) {
  const auto holds = [&](Term t) { return std::ranges::find(fit.fitted_terms, t) != fit.fitted_terms.end(); };
  fit::Options options;
  options.method = fit::Method::whittle;
  options.terms = fit.fitted_terms;
  options.tau_min_s = fit.tau_min_s;
  options.tau_max_s = fit.tau_max_s;
  if (holds(Term::gauss_markov)) options.correlation_time_s = fit[Term::gauss_markov].shape;
  if (holds(Term::sinusoid)) options.frequency_hz = fit[Term::sinusoid].shape;
  options.find_front_end = false;
  if (fit.front_end && fit.front_end->kind) {
    options.front_end = fit.front_end->value();
    options.fit_bandwidth = fit.front_end->fitted;
  } else {
    options.unknown_front_end = !fit.moved.empty();
  }
  CrossChecked checked;
  checked.likelihood = fit::fit_likelihood(series.rate(), series.dt(), options);
  checked.check = fit::cross_check(fit, checked.likelihood);
  return checked;
}

// A datasheet, and the error that left it without a fit where there was one.
struct Outcome {
  AxisDatasheet sheet;
  std::exception_ptr error;
};

// What adds to a fit: its faults leave the fit as it is.
void complete(AxisDatasheet& sheet, const Fitted& fitted, Screened& screened, Job& job, detail::Stages& stages) {
  const fit::Result& fit = sheet.fit;
  stages.attempt(Stage::lines, [&] { screened.look_for_lines(fit); });
  stages.attempt(Stage::intervals, [&] {
    const auto mix = fit.verdict == fit::Verdict::not_described ? std::vector<noise::Process>{} : fit.processes();
    sheet.points = allan::deviation_points(fitted.curves.display, fitted.curves.identified, mix);
  });
  if (job.options.cross_check && !fit.fitted_terms.empty())
    stages.attempt(Stage::cross_check, [&] { sheet.cross_checked = cross_check(fit, screened.series()); });
  stages.attempt(Stage::facts, [&] {
    sheet.facts = facts_of(fit, fitted.curves.octaves);
    if (!screened.findings().spoil() && !job.options.tau_min_s)
      sheet.facts.later = later_start(fit, fitted.curves, screened.series().rate(), sheet.name, job);
  });
}

Outcome calibrate_axis(const allan::Axis& axis, double rate_hz, Job& job) {
  const Options& options = job.options;
  Outcome outcome{.sheet = {.name = axis.name, .signal = axis.signal}, .error = nullptr};
  AxisDatasheet& sheet = outcome.sheet;
  sheet.mean = std::numeric_limits<double>::quiet_NaN();
  detail::Stages stages(sheet.name, job.observer, sheet.faults);
  outcome.error = stages.attempt(Stage::curve, [&] { check_scale(axis); });
  if (outcome.error) return outcome;
  Screened screened(axis.rate, 1 / rate_hz, options.minimum_fill, options.mask);
  stages.attempt(Stage::screening, [&] { screened.look_for_outliers_and_steps(); });
  Fitted fitted;
  outcome.error = stages.attempt(Stage::curve, [&] { fitted = fit_axis(screened.series(), axis.name, job, stages); });
  if (!outcome.error) {
    stages.attempt(Stage::departure, [&] {
      if (screened.look_for_departure(fitted.fit.processes()))
        fitted = fit_axis(screened.series(), axis.name, job, stages);
    });
    sheet.mean = fitted.curves.octaves.mean;
    sheet.fit = std::move(fitted.fit);
    sheet.chosen = std::move(fitted.chosen);
    complete(sheet, fitted, screened, job, stages);
    sheet.octaves = std::move(fitted.curves.octaves);
  }
  sheet.findings = screened.findings();
  return outcome;
}

// Where no axis could be fitted, what stopped the first is thrown: there is nothing that could stand.
std::vector<AxisDatasheet> sheets_of(std::vector<Outcome> outcomes) {
  const bool none = std::ranges::all_of(outcomes, [](const Outcome& o) { return o.error != nullptr; });
  if (none && !outcomes.empty()) std::rethrow_exception(outcomes.front().error);
  std::vector<AxisDatasheet> sheets;
  for (Outcome& outcome : outcomes) sheets.push_back(std::move(outcome.sheet));
  return sheets;
}

// A column of a table as a curve of the record behind it: whole averaging factors, at most n/2.
allan::Curve curve_of(const allan::DeviationTable& table, const std::vector<double>& deviation, double rate_hz,
                      std::int64_t samples) {
  constexpr double kPrinted = 0.01;  // taus in tables are rounded
  allan::Curve curve;
  curve.dt = 1 / rate_hz;
  curve.samples = samples;
  curve.mean = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    const double cluster = table.tau_s[i] * rate_hz;
    const std::int64_t m = std::llround(cluster);
    if (std::abs(cluster - static_cast<double>(m)) > kPrinted * cluster)
      throw Unusable(Unusable::Reason::between_samples,
                     fmt::format("{}: found tau = {:g} s, expected a whole number of samples at {:g} Hz", table.source,
                                 table.tau_s[i], rate_hz));
    const bool repeated = !curve.points.empty() && curve.points.back().m == m;
    if (m < 1 || 2 * m > samples || repeated) continue;
    curve.points.push_back({m, deviation[i] * deviation[i], samples - 2 * m + 1});
  }
  return curve;
}

// About an octave apart: a denser grid makes the covariance singular.
allan::Curve thinned(const allan::Curve& curve) {
  constexpr double kOctave = 1.9;
  allan::Curve thin = curve;
  thin.points.clear();
  for (const auto& p : curve.points) {
    if (thin.points.empty() || static_cast<double>(p.m) >= kOctave * static_cast<double>(thin.points.back().m))
      thin.points.push_back(p);
  }
  return thin;
}

}  // namespace

bool AxisDatasheet::has_answer() const {
  const bool described = fit.verdict != fit::Verdict::not_described || !fit::has_p_value(fit.method);
  return described && fit.converged && !holds_no_answer(fit);
}

bool Datasheet::is_complete() const {
  return std::ranges::all_of(axes, [](const auto& axis) {
    return axis.has_answer() && axis.is_confirmed() && !axis.is_spoilt() && axis.faults.empty();
  });
}

Datasheet calibrate(const allan::Record& record, const Options& options) {
  return detail::calibrate(record, options, {});
}

Datasheet detail::calibrate(const allan::Record& record, const Options& options, const Observer& observer) {
  check_length(record);
  std::vector<Outcome> outcomes(record.axes.size());
  Job job{options, observer};
  tbb::parallel_for(std::size_t{0}, record.axes.size(),
                    [&](std::size_t i) { outcomes[i] = calibrate_axis(record.axes[i], record.rate_hz, job); });
  return {.source = record.source,
          .rate_hz = record.rate_hz,
          .samples = record.samples,
          .missing_samples = record.missing_samples,
          .axes = sheets_of(std::move(outcomes))};
}

Datasheet calibrate(const allan::DeviationTable& table, double rate_hz, std::int64_t samples, const Options& options) {
  if (!(rate_hz > 0 && std::isfinite(rate_hz)))
    throw std::invalid_argument(fmt::format("rate is {} Hz, expected it positive and finite", rate_hz));
  Job job{options};
  std::vector<Outcome> outcomes;
  for (const auto& column : table.columns) {
    Outcome& outcome = outcomes.emplace_back();
    AxisDatasheet& axis = outcome.sheet;
    axis = {.name = column.name, .signal = column.signal, .mean = std::numeric_limits<double>::quiet_NaN()};
    detail::Stages stages(axis.name, job.observer, axis.faults);
    detail::Curves curves;
    outcome.error = stages.attempt(Stage::curve, [&] {
      curves.display = curve_of(table, column.deviation, rate_hz, samples);
      curves.octaves = thinned(curves.display);
      stages.enter(Stage::fit);
      axis.fit = fit_table(curves, column.name, job);
    });
    if (outcome.error) continue;
    stages.attempt(Stage::intervals,
                   [&] { axis.points = allan::deviation_points(curves.display, {}, axis.fit.processes()); });
    stages.attempt(Stage::facts, [&] {
      axis.facts = facts_of(axis.fit, curves.octaves);
      if (!options.tau_min_s) axis.facts.later = later_start(axis.fit, curves, {}, column.name, job);
    });
    axis.octaves = std::move(curves.octaves);
  }
  return {.source = table.source,
          .rate_hz = rate_hz,
          .samples = samples,
          .missing_samples = 0,
          .axes = sheets_of(std::move(outcomes))};
}

}  // namespace gyrobudget::inline v0::calibration
