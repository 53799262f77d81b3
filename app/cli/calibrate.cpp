// SPDX-License-Identifier: MIT
// calibrate: log -> datasheet: the coefficients with intervals and verdicts, and the files to use next.
#include "gyrobudget/io/curve_table.h"
#include "gyrobudget/io/output.h"
#include "gyrobudget/io/sensor_file.h"
#include "gyrobudget/report/report.h"
#include "gyrobudget/report/words.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "advice.h"
#include "analysis.h"
#include "fitting.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

constexpr std::int64_t kFewestSamples = 16;  // 4 octaves: three terms and one tau more

report::LogResult calibrate_log(const CalibrateArguments& a) {
  const io::Record record = read_record(a.curve, a.common);
  if (record.samples < kFewestSamples) {
    throw io::InputError(
        fmt::format("{}: found {} samples, expected at least {}; a datasheet needs hours of record "
                    "(gyrobudget plan tells how many)",
                    record.source, record.samples, kFewestSamples));
  }
  report::LogResult result = describe_record(record, a.common);
  Covariances covariances;
  result.axes.resize(record.axes.size());
  tbb::parallel_for(std::size_t{0}, record.axes.size(), [&](std::size_t i) {
    result.axes[i] = calibrate_axis(record.axes[i], record.rate_hz, a, covariances);
  });
  return result;
}

// --- A table of deviations instead of a log ---------------------------------------------------------------------------

// The table as a curve of the record behind it: whole averaging factors, at most n/2.
allan::Curve curve_of_table(const io::CurveTable& table, const std::vector<double>& deviation, double rate_hz,
                            std::int64_t samples) {
  allan::Curve curve;
  curve.dt = 1 / rate_hz;
  curve.samples = samples;
  curve.mean = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    const double cluster = table.tau_s[i] * rate_hz;
    const std::int64_t m = std::llround(cluster);
    constexpr double kPrinted = 0.01;  // taus in tables are rounded
    if (std::abs(cluster - static_cast<double>(m)) > kPrinted * cluster) {
      throw io::InputError(
          fmt::format("{}: found tau = {:g} s, expected a whole number of samples at --rate {:g} Hz; give "
                      "the rate of the record behind the table",
                      table.source, table.tau_s[i], rate_hz));
    }
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
    if (thin.points.empty() ||
        static_cast<double>(p.m) >= kOctave * static_cast<double>(thin.points.back().m)) {
      thin.points.push_back(p);
    }
  }
  return thin;
}

report::LogResult calibrate_table(const CalibrateArguments& a) {
  const double rate_hz = *a.curve.log.rate_hz;
  const io::CurveTable table = io::read_curve({a.curve_file, a.curve.log.unit, a.curve.log.columns});
  const auto samples = static_cast<std::int64_t>(std::llround(*a.duration_s * rate_hz));
  report::LogResult result;
  result.source = table.source;
  result.command = a.common.command_line;
  result.rate_hz = rate_hz;
  result.samples = samples;
  result.notes.push_back(
      "fitted to a table of deviations, taken as fully overlapped ones of a record without gaps");
  Covariances covariances;
  for (const auto& column : table.columns) {
    const allan::Curve display = curve_of_table(table, column.deviation, rate_hz, samples);
    const Curves curves{display, thinned(display), {}};
    const io::Axis axis{column.name, column.signal, {}};
    report::AxisResult axis_result{.name = column.name, .signal = column.signal, .mean = display.mean};
    axis_result.fit = fit_curves(curves, {}, axis, a, covariances);
    axis_result.points = with_intervals(display, {}, axis_result.fit->processes());
    axis_result.advice = advise(*axis_result.fit, axis, curves.octaves, {});
    result.axes.push_back(std::move(axis_result));
  }
  return result;
}

// --- The sensor file --------------------------------------------------------------------------------------------------

// Six digits in the datasheet's unit: more than any record tells, and readable in the file.
double rounded(double si, noise::Signal signal, Term term) {
  const auto unit = noise::datasheet_unit(signal, term);
  return std::stod(fmt::format("{:.6g}", noise::from_si(si, unit))) * noise::parse_unit(unit).to_si;
}

// A converged fit that describes the record and finds at least one of N, B, K.
bool has_answer(const report::AxisResult& axis) {
  const bool described =
      axis.fit->verdict != fit::Verdict::not_described || !report::has_p_value(axis.fit->method);
  return described && axis.fit->converged && !holds_no_answer(*axis.fit);
}

// One model for a triad: root mean square over its axes that have an answer, term by term.
std::optional<noise::ErrorModel> triad(const report::LogResult& result, noise::Signal signal) {
  noise::ErrorModel model;
  int count = 0;
  for (const auto& axis : result.axes) {
    if (axis.signal != signal || !has_answer(axis)) continue;
    ++count;
    for (const auto& c : axis.fit->coefficients) {
      if (c.fitted) model[c.term] = std::hypot(model[c.term], c.value);
    }
  }
  if (count == 0) return std::nullopt;
  for (const Term t :
       {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp}) {
    model[t] = rounded(model[t] / std::sqrt(count), signal, t);
  }
  return model;
}

// "logs/gyro_7.csv.gz" is gyro_7.
std::string log_name(const std::string& source) {
  const std::string file = std::filesystem::path(source).filename().string();
  return file.substr(0, file.find('.', 1));
}

noise::SensorModel sensor_of(const report::LogResult& result, const std::string& name) {
  noise::SensorModel sensor;
  sensor.name = name.empty() ? log_name(result.source) : name;
  if (const auto gyro = triad(result, noise::Signal::angular_rate)) sensor.gyro = *gyro;
  sensor.accelerometer = triad(result, noise::Signal::specific_force);
  return sensor;
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
      text += fmt::format("  {} is not resolved: at most {} (95 %)\n", noise::key(axis.signal, c.term),
                          noise::quantity_text(c.upper, unit, 3));
    }
  }
  return text;
}

void write_sensor_files(const report::LogResult& result, const CalibrateArguments& a) {
  if (a.output.empty() && a.kalibr.empty()) return;
  const bool inertial = std::any_of(result.axes.begin(), result.axes.end(), [](const auto& axis) {
    return axis.signal != noise::Signal::dimensionless;
  });
  if (!inertial)
    throw std::invalid_argument("-o and --kalibr describe gyros and accelerometers; this log has neither");
  if (std::none_of(result.axes.begin(), result.axes.end(), has_answer)) {
    say(a.common, "no sensor file is written: no axis has an answer to put in it");
    return;
  }
  const noise::SensorModel sensor = sensor_of(result, a.name);
  if (!a.output.empty()) io::write_file(a.output, io::sensor_yaml(sensor, provenance(result)));
  if (!a.kalibr.empty()) io::write_file(a.kalibr, io::kalibr_yaml(sensor, result.rate_hz));
  for (const auto& path : {a.output, a.kalibr}) {
    if (!path.empty()) say(a.common, "sensor file: " + path);
  }
}

int exit_code(const report::LogResult& result) {
  return std::all_of(result.axes.begin(), result.axes.end(), has_answer) ? exit_done : exit_no_answer;
}

}  // namespace

int run(const CalibrateArguments& a) {
  check_outputs(a.curve_file.empty() ? a.curve.log.path : a.curve_file, {{"-o", a.output},
                                                                         {"--kalibr", a.kalibr},
                                                                         {"--report", a.pictures.report},
                                                                         {"--plot", a.pictures.plot}});
  const report::LogResult result = a.curve_file.empty() ? calibrate_log(a) : calibrate_table(a);
  print(a.common.json ? report::calibration_json(result) : report::datasheet(result));
  write_sensor_files(result, a);
  write_pictures(result, a.pictures, a.common);
  return exit_code(result);
}

}  // namespace gyrobudget::inline v0::cli
