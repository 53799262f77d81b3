// SPDX-License-Identifier: MIT
#include "calibrate.h"

#include "gyrobudget/estimation/fit/judgement.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "detail/axis_fit.h"
#include "detail/screened.h"

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
  CrossChecked checked;
  checked.likelihood = fit::fit_likelihood(series.rate(), series.dt(), options);
  checked.check = fit::cross_check(fit, checked.likelihood);
  return checked;
}

AxisDatasheet calibrate_axis(const allan::Axis& axis, double rate_hz, Job& job) {
  check_scale(axis);
  const Options& options = job.options;
  Screened screened(axis.rate, 1 / rate_hz, options.minimum_fill, options.mask);
  Fitted fitted = fit_axis(screened.series(), axis.name, job);
  if (screened.look_for_departure(fitted.fit.processes())) fitted = fit_axis(screened.series(), axis.name, job);
  auto& [curves, fit, chosen] = fitted;
  screened.look_for_lines(fit);
  AxisDatasheet sheet{.name = axis.name, .signal = axis.signal, .mean = curves.octaves.mean};
  const auto mix = fit.verdict == fit::Verdict::not_described ? std::vector<noise::Process>{} : fit.processes();
  sheet.points = allan::deviation_points(curves.display, curves.identified, mix);
  if (options.cross_check && !fit.fitted_terms.empty()) sheet.cross_checked = cross_check(fit, screened.series());
  sheet.facts = facts_of(fit, curves.octaves);
  sheet.findings = screened.findings();
  sheet.chosen = std::move(chosen);
  sheet.fit = std::move(fit);
  return sheet;
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
  return std::ranges::all_of(
      axes, [](const auto& axis) { return axis.has_answer() && axis.is_confirmed() && !axis.is_spoilt(); });
}

Datasheet calibrate(const allan::Record& record, const Options& options) {
  check_length(record);
  Datasheet sheet{.source = record.source,
                  .rate_hz = record.rate_hz,
                  .samples = record.samples,
                  .missing_samples = record.missing_samples,
                  .axes = std::vector<AxisDatasheet>(record.axes.size())};
  Job job{options};
  tbb::parallel_for(std::size_t{0}, record.axes.size(),
                    [&](std::size_t i) { sheet.axes[i] = calibrate_axis(record.axes[i], record.rate_hz, job); });
  return sheet;
}

Datasheet calibrate(const allan::DeviationTable& table, double rate_hz, std::int64_t samples, const Options& options) {
  if (!(rate_hz > 0 && std::isfinite(rate_hz)))
    throw std::invalid_argument(fmt::format("rate is {} Hz, expected it positive and finite", rate_hz));
  Datasheet sheet{.source = table.source, .rate_hz = rate_hz, .samples = samples, .missing_samples = 0, .axes = {}};
  Job job{options};
  for (const auto& column : table.columns) {
    const allan::Curve display = curve_of(table, column.deviation, rate_hz, samples);
    const detail::Curves curves{display, thinned(display), {}};
    AxisDatasheet axis{.name = column.name, .signal = column.signal, .mean = display.mean};
    axis.fit = fit_table(curves, column.name, job);
    axis.points = allan::deviation_points(display, {}, axis.fit.processes());
    axis.facts = facts_of(axis.fit, curves.octaves);
    sheet.axes.push_back(std::move(axis));
  }
  return sheet;
}

}  // namespace gyrobudget::inline v0::calibration
