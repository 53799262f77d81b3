// SPDX-License-Identifier: MIT
#include "sensor_output.h"

#include "gyrobudget/app/report/words.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "advice.h"
#include "terminal.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

double to_digits(double value, int digits = 6) { return std::stod(fmt::format("{:.{}g}", value, digits)); }

// Six digits in the datasheet's unit: more than any record tells, and readable in the file.
double rounded(double si, noise::Signal signal, Term term) {
  const auto unit = noise::datasheet_unit(signal, term);
  return to_digits(noise::from_si(si, unit)) * noise::parse_unit(unit).to_si;
}

// Squares add up. Each Gauss-Markov process keeps its own correlation time: the triad's spectrum is the mean of its
// axes' spectra. Lines of one frequency are one line.
void add(noise::ErrorModel& model, const fit::Coefficient& c) {
  if (!(c.value > 0)) return;
  if (c.term == Term::gauss_markov) {
    model.gauss_markov.push_back({c.value, c.shape});
  } else if (c.term != Term::sinusoid) {
    model[c.term] = std::hypot(model[c.term], c.value);
  } else {
    constexpr double kSame = 1e-3;
    for (auto& line : model.sinusoids) {
      if (std::abs(line.frequency - c.shape) > kSame * c.shape) continue;
      line.amplitude = std::hypot(line.amplitude, c.value);
      return;
    }
    model.sinusoids.push_back({c.value, c.shape});
  }
}

// From sums of squares over `count` axes to their mean.
void scale_down(noise::ErrorModel& model, int count, noise::Signal signal) {
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp}) {
    model[t] = rounded(model[t] / std::sqrt(count), signal, t);
  }
  for (auto& g : model.gauss_markov) {
    g.sigma = rounded(g.sigma / std::sqrt(count), signal, Term::gauss_markov);
    g.correlation_time = to_digits(g.correlation_time);
  }
  for (auto& line : model.sinusoids) {
    line.amplitude = rounded(line.amplitude / std::sqrt(count), signal, Term::sinusoid);
    line.frequency = to_digits(line.frequency, 9);
  }
}

// One model for a triad: root mean square over its axes that have an answer, term by term.
std::optional<noise::ErrorModel> triad(const report::LogResult& result, noise::Signal signal) {
  noise::ErrorModel model;
  int count = 0;
  for (const auto& axis : result.axes) {
    if (axis.signal != signal || !has_answer(axis)) continue;
    ++count;
    for (const auto& c : axis.fit->coefficients) {
      if (c.fitted) add(model, c);
    }
  }
  if (count == 0) return std::nullopt;
  scale_down(model, count, signal);
  return model;
}

// "logs/gyro_7.csv.gz" is gyro_7.
std::string log_name(const std::string& source) {
  const std::string file = std::filesystem::path(source).filename().string();
  return file.substr(0, file.find('.', 1));
}

std::string provenance(const report::LogResult& result) {
  std::string text = fmt::format("Fitted by: {}\nRecord: {} samples at {} Hz, {} missing\n", result.command,
                                 result.samples, result.rate_hz, result.missing_samples);
  if (result.axes.size() > 1) text += "Each value is the root mean square over the axes of its triad.\n";
  for (const auto& axis : result.axes) {
    text += fmt::format("{}: {}\n", axis.name, one_line_verdict(*axis.fit));
    for (const auto& c : axis.fit->coefficients) {
      if (!c.fitted || c.status == fit::Status::identified) continue;
      const auto unit = noise::datasheet_unit(axis.signal, c.term);
      text +=
          fmt::format("  {} is not resolved: {} is the fitted value, at most {} (95 %); a cautious budget takes that\n",
                      noise::key(axis.signal, c.term), noise::quantity_text(c.value, unit, 3),
                      noise::quantity_text(c.upper, unit, 3));
    }
  }
  return text;
}

// Of the coefficients that several records gave together.
std::optional<noise::ErrorModel> triad(const report::RunsResult& result, noise::Signal signal) {
  noise::ErrorModel model;
  int count = 0;
  for (const auto& axis : result.combined) {
    if (axis.signal != signal || axis.coefficients.empty()) continue;
    ++count;
    for (const auto& c : axis.coefficients) model[c.term] = std::hypot(model[c.term], c.value);
  }
  if (count == 0) return std::nullopt;
  scale_down(model, count, signal);
  return model;
}

std::string provenance(const report::RunsResult& result) {
  std::string text = fmt::format("Fitted by: {}\nEach record by itself, then combined:\n", result.command);
  for (const auto& run : result.runs) {
    text += fmt::format("  {}: {} samples at {} Hz, {} missing\n", report::printable(run.source), run.samples,
                        run.rate_hz, run.missing_samples);
  }
  if (result.combined.size() > 1) text += "Each value is the root mean square over the axes of its triad.\n";
  for (const auto& axis : result.combined) {
    for (const auto& c : axis.coefficients) {
      const auto t = report::combined_text(axis.signal, c);
      text += fmt::format("{}: {} {}, {} (95 %), spread between records {} {}; {}\n", report::printable(axis.name),
                          noise::key(axis.signal, c.term), t.value, t.interval, t.spread, t.unit, t.agreement);
    }
  }
  return text + "Gauss-Markov processes and sinusoids are left out: they are not combined.\n";
}

template <class Result>
noise::SensorModel sensor_of(const Result& result, const std::string& name) {
  noise::SensorModel sensor;
  sensor.name = name;
  if (const auto gyro = triad(result, noise::Signal::angular_rate)) sensor.gyro = *gyro;
  sensor.accelerometer = triad(result, noise::Signal::specific_force);
  return sensor;
}

void write(const noise::SensorModel& sensor, const std::string& comment, double rate_hz, const CalibrateArguments& a) {
  if (!a.output.empty()) text::write_file(a.output, sensor_file::sensor_yaml(sensor, comment));
  if (!a.kalibr.empty()) text::write_file(a.kalibr, sensor_file::kalibr_yaml(sensor, rate_hz));
  for (const auto& path : {a.output, a.kalibr}) {
    if (!path.empty()) say(a.common, "sensor file: " + path);
  }
}

template <class Axes>
void require_inertial(const Axes& axes) {
  if (std::any_of(axes.begin(), axes.end(), [](const auto& a) { return a.signal != noise::Signal::dimensionless; }))
    return;
  throw std::invalid_argument("-o and --kalibr describe gyros and accelerometers; this log has neither");
}

void say_nothing_is_written(const CalibrateArguments& a) {
  say(a.common, "no sensor file is written: no axis has an answer to put in it");
}

}  // namespace

bool has_answer(const report::AxisResult& axis) {
  const bool described = axis.fit->verdict != fit::Verdict::not_described || !report::has_p_value(axis.fit->method);
  return described && axis.fit->converged && !holds_no_answer(*axis.fit);
}

bool every_axis_has_answer(const report::RunsResult& result) {
  for (std::size_t i = 0; i < result.combined.size(); ++i) {
    if (std::none_of(result.runs.begin(), result.runs.end(), [=](const auto& run) { return has_answer(run.axes[i]); }))
      return false;
  }
  return true;
}

void write_sensor_files(const report::LogResult& result, const CalibrateArguments& a) {
  if (a.output.empty() && a.kalibr.empty()) return;
  require_inertial(result.axes);
  if (std::none_of(result.axes.begin(), result.axes.end(), [](const auto& axis) { return has_answer(axis); }))
    return say_nothing_is_written(a);
  write(sensor_of(result, a.name.empty() ? log_name(result.source) : a.name), provenance(result), result.rate_hz, a);
}

void write_sensor_files(const report::RunsResult& result, const CalibrateArguments& a) {
  if (a.output.empty() && a.kalibr.empty()) return;
  require_inertial(result.combined);
  if (std::all_of(result.combined.begin(), result.combined.end(),
                  [](const auto& axis) { return axis.coefficients.empty(); }))
    return say_nothing_is_written(a);
  write(sensor_of(result, a.name.empty() ? log_name(result.runs.front().source) : a.name), provenance(result),
        result.runs.front().rate_hz, a);
}

}  // namespace gyrobudget::inline v0::cli
