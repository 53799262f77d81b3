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
#include "detail/held.h"
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
  if (!record.temperature.empty() && std::ssize(record.temperature) != record.samples)
    throw std::invalid_argument(fmt::format("the temperature has {} samples, expected the record's {}",
                                            record.temperature.size(), record.samples));
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

// What the findings mean for the fit: a record that is not of one sensor at rest is described by nothing, and rounding
// above the noise leaves no white noise, nor the others where the mean stays within a few steps.
void apply(const Findings& found, fit::Result& fit, Facts& facts) {
  if (found.not_at_rest() || found.not_of_one_sensor()) {
    fit.verdict = fit::Verdict::not_described;
    facts = Facts{.all_equal = facts.all_equal};
  }
  if (!found.rounded_above_noise()) return;
  for (auto& c : fit.coefficients) {
    const bool short_term = c.term == Term::white || c.term == Term::quantization;
    if (c.fitted && (short_term || !found.rounding->is_dithered_by_wander())) c.status = fit::Status::not_quotable;
  }
  facts.no_answer = facts.only_quantization = false;  // the finding says why
  if (found.rounding->is_dithered_by_wander()) return;
  facts.walk_unresolved = false;
  facts.longer.clear();
}

// Screens an axis and fits it.
Fitted look_at(std::optional<Screened>& screened, std::span<const double> rate, double dt, const std::string& name,
               Job& job) {
  screened.emplace(rate, dt, job.options.minimum_fill, job.options.mask);
  Fitted fitted = fit_axis(screened->series(), name, job);
  if (screened->look_for_departure(fitted.fit.processes())) fitted = fit_axis(screened->series(), name, job);
  return fitted;
}

// What depends on temperature, over the whole axis, where it is seen; `rate` is without it then.
std::optional<Temperature> take_off_temperature(std::vector<double>& rate, std::span<const double> temperature,
                                                double dt, const Fitted& fitted) {
  constexpr std::size_t kFewest = 1024;
  if (rate.size() < kFewest || fit::is_reading(fitted.fit.method)) return std::nullopt;
  const SmoothTemperature smooth(temperature, dt);
  if (!smooth.is_usable()) return std::nullopt;
  Temperature found = fit_temperature(rate, smooth, dt, fitted.fit);
  found.before = fitted.fit;
  found.removed = found.p_value < kTemperatureSeen;
  if (!found.removed) return found;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    const double t = (static_cast<double>(i) + 0.5) * dt;
    rate[i] -= found.shift(smooth.at(t), smooth.slope(t));
  }
  return found;
}

AxisDatasheet calibrate_axis(const allan::Axis& axis, const allan::Record& record, const detail::HeldSensor* held,
                             Job& job) {
  check_scale(axis);
  const Options& options = job.options;
  const bool has_temperature = options.temperature && !record.temperature.empty();
  // Samples of its own, where they are not those of the record.
  std::vector<double> own = held != nullptr   ? held->readings.of(axis.rate)
                            : has_temperature ? axis.rate
                                              : std::vector<double>{};
  const std::span<const double> rate = own.empty() ? std::span<const double>(axis.rate) : own;
  const double dt = (held != nullptr ? held->readings.rows_each : 1) / record.rate_hz;
  std::optional<Screened> screened;
  Fitted fitted = look_at(screened, rate, dt, axis.name, job);
  AxisDatasheet sheet{.name = axis.name, .signal = axis.signal, .mean = fitted.curves.octaves.mean};
  if (has_temperature) {
    const auto of_readings = held != nullptr ? held->readings.of(record.temperature) : std::vector<double>{};
    sheet.temperature = take_off_temperature(
        own, held != nullptr ? std::span<const double>(of_readings) : record.temperature, dt, fitted);
    if (sheet.temperature && sheet.temperature->removed) fitted = look_at(screened, own, dt, axis.name, job);
  }
  auto& [curves, fit, chosen] = fitted;
  screened->look_for_lines(fit);
  const auto mix = fit.verdict == fit::Verdict::not_described ? std::vector<noise::Process>{} : fit.processes();
  sheet.points = allan::deviation_points(curves.display, curves.identified, mix);
  if (options.cross_check && !fit.fitted_terms.empty()) sheet.cross_checked = cross_check(fit, screened->series());
  sheet.findings = screened->findings();
  sheet.facts = facts_of(fit, curves.octaves);
  apply(*sheet.findings, fit, sheet.facts);
  sheet.chosen = std::move(chosen);
  sheet.fit = std::move(fit);
  if (held != nullptr) {
    const double raised = raise_white_noise(sheet, rate, *held, dt);
    sheet.findings->held = Held{held->repeats, 1 / dt, std::ssize(rate), raised};
  }
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
  return std::ranges::all_of(axes, [](const auto& axis) { return axis.has_answer() && axis.is_confirmed(); });
}

Datasheet calibrate(const allan::Record& record, const Options& options) {
  check_length(record);
  Datasheet sheet{.source = record.source,
                  .rate_hz = record.rate_hz,
                  .samples = record.samples,
                  .missing_samples = record.missing_samples,
                  .axes = std::vector<AxisDatasheet>(record.axes.size())};
  Job job{options};
  const auto held = detail::held_sensors(record);
  tbb::parallel_for(std::size_t{0}, record.axes.size(),
                    [&](std::size_t i) { sheet.axes[i] = calibrate_axis(record.axes[i], record, held[i].get(), job); });
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
