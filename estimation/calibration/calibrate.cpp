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
#include "detail/held.h"
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
  options.find_front_end = false;
  if (fit.front_end && fit.front_end->kind) {
    options.front_end = fit.front_end->value();
    options.front_end_choice = fit.front_end->choice;
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

// Errors in single samples shift and widen N.
void allow_for_outliers(const Findings& found, double dt, AxisDatasheet& sheet) {
  const auto shift = [&](fit::Result& fit) {
    if (const auto* white = fit::find(fit, Term::white)) shift_white(fit, found.shift_by_outliers(white->value, dt));
  };
  shift(sheet.fit);
  if (sheet.cross_checked) shift(sheet.cross_checked->likelihood);
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

// What is seen of an axis, and its fit.
struct Look {
  std::optional<Screened> screened;
  Fitted fitted;
};

// Screens an axis and fits it. @return the error that left it without a fit, null where there was none
std::exception_ptr look_at(Look& look, std::span<const double> rate, double dt, const std::string& name, Job& job,
                           detail::Stages& stages) {
  Screened& screened = look.screened.emplace(rate, dt, job.options.minimum_fill, job.options.mask);
  stages.attempt(Stage::screening, [&] { screened.look(); });
  const auto fit = [&] { look.fitted = fit_axis(screened.series(), name, job, stages); };
  if (const auto error = stages.attempt(Stage::curve, fit)) return error;
  stages.attempt(Stage::departure, [&] {
    if (screened.look_for_departure(look.fitted.fit.processes())) fit();
  });
  return nullptr;
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

// The samples that the fit of an axis is of: those of the record, the readings that its rows repeat, or what is left
// when temperature is taken off.
class Samples {
 public:
  Samples(const allan::Axis& axis, const allan::Record& record, const detail::HeldSensor* held)
      : record_(record), held_(held), rate_(axis.rate), dt_((held ? held->readings.rows_each : 1) / record.rate_hz) {
    if (held) own_ = held->readings.of(axis.rate), rate_ = own_;
  }
  Samples(const Samples&) = delete;
  Samples& operator=(const Samples&) = delete;

  [[nodiscard]] std::span<const double> rate() const { return rate_; }
  [[nodiscard]] double dt() const { return dt_; }

  // What depends on temperature; where it is seen, the samples are without it afterwards.
  std::optional<Temperature> take_off_temperature(const Fitted& fitted) {
    if (own_.empty()) own_.assign(rate_.begin(), rate_.end()), rate_ = own_;
    if (!held_) return calibration::take_off_temperature(own_, record_.temperature, dt_, fitted);
    return calibration::take_off_temperature(own_, held_->readings.of(record_.temperature), dt_, fitted);
  }

 private:
  const allan::Record& record_;
  const detail::HeldSensor* held_;
  std::vector<double> own_;
  std::span<const double> rate_;
  double dt_;
};

Outcome calibrate_axis(const allan::Axis& axis, const allan::Record& record, const detail::HeldSensor* held, Job& job) {
  Outcome outcome{.sheet = {.name = axis.name, .signal = axis.signal}, .error = nullptr};
  AxisDatasheet& sheet = outcome.sheet;
  sheet.mean = std::numeric_limits<double>::quiet_NaN();
  detail::Stages stages(sheet.name, job.observer, sheet.faults);
  outcome.error = stages.attempt(Stage::curve, [&] { check_scale(axis); });
  if (outcome.error) return outcome;
  Samples samples(axis, record, held);
  Look look;
  const auto see = [&] { return look_at(look, samples.rate(), samples.dt(), axis.name, job, stages); };
  outcome.error = see();
  if (!outcome.error) sheet.mean = look.fitted.curves.octaves.mean;
  if (!outcome.error && job.options.temperature && !record.temperature.empty()) {
    stages.attempt(Stage::temperature, [&] { sheet.temperature = samples.take_off_temperature(look.fitted); });
    if (sheet.temperature && sheet.temperature->removed) {
      sheet.faults.clear();  // all of it is done again
      outcome.error = see();
    }
  }
  Fitted& fitted = look.fitted;
  if (!outcome.error) {
    sheet.fit = std::move(fitted.fit);
    sheet.chosen = std::move(fitted.chosen);
    complete(sheet, fitted, *look.screened, job, stages);
    sheet.octaves = std::move(fitted.curves.octaves);
  }
  sheet.findings = look.screened->findings();
  if (!outcome.error) {
    apply(*sheet.findings, sheet.fit, sheet.facts);
    allow_for_outliers(*sheet.findings, samples.dt(), sheet);
  }
  if (held) {
    double raised = 1;
    if (!outcome.error)
      stages.attempt(Stage::facts, [&] { raised = raise_white_noise(sheet, samples.rate(), *held, samples.dt()); });
    sheet.findings->held = Held{held->repeats, 1 / samples.dt(), std::ssize(samples.rate()), raised};
  }
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
  const auto held = detail::held_sensors(record);
  std::vector<Outcome> outcomes(record.axes.size());
  Job job{options, observer};
  tbb::parallel_for(std::size_t{0}, record.axes.size(),
                    [&](std::size_t i) { outcomes[i] = calibrate_axis(record.axes[i], record, held[i].get(), job); });
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
