// SPDX-License-Identifier: MIT
// calibrate: log -> datasheet: the coefficients with intervals and verdicts, and the files to use next.
#include "gyrobudget/app/log/curve_table.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "advice.h"
#include "analysis.h"
#include "fitting.h"
#include "paths.h"
#include "runs.h"
#include "sensor_output.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

// --- A table of deviations instead of a log ---------------------------------------------------------------------------

// The table as a curve of the record behind it: whole averaging factors, at most n/2.
allan::Curve curve_of_table(const log::CurveTable& table, const std::vector<double>& deviation, double rate_hz,
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
      throw text::InputError(fmt::format(
          "{}: found tau = {:g} s, expected a whole number of samples at --rate {:g} Hz; give the rate of the record behind the table",
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
    if (thin.points.empty() || static_cast<double>(p.m) >= kOctave * static_cast<double>(thin.points.back().m)) {
      thin.points.push_back(p);
    }
  }
  return thin;
}

report::LogResult calibrate_table(const CalibrateArguments& a) {
  const double rate_hz = *a.curve.log.rate_hz;
  const log::CurveTable table = log::read_curve({a.curve_file, a.curve.log.unit, a.curve.log.columns});
  const auto samples = static_cast<std::int64_t>(std::llround(*a.duration_s * rate_hz));
  report::LogResult result;
  result.source = table.source;
  result.command = a.common.command_line;
  result.rate_hz = rate_hz;
  result.samples = samples;
  result.notes.push_back("fitted to a table of deviations, taken as fully overlapped ones of a record without gaps");
  Covariances covariances;
  for (const auto& column : table.columns) {
    const allan::Curve display = curve_of_table(table, column.deviation, rate_hz, samples);
    const Curves curves{display, thinned(display), {}};
    const allan::Axis axis{column.name, column.signal, {}};
    report::AxisResult axis_result{.name = column.name, .signal = column.signal, .mean = display.mean};
    axis_result.fit = fit_curves(curves, {}, terms_for(a, {}), axis, a, covariances);
    axis_result.points = allan::deviation_points(display, {}, axis_result.fit->processes());
    axis_result.advice = advise(*axis_result.fit, axis, curves.octaves, {});
    result.axes.push_back(std::move(axis_result));
  }
  return result;
}

bool is_confirmed(const report::AxisResult& axis) { return !axis.cross_checked || axis.cross_checked->check.agrees; }

int exit_code(const report::LogResult& result) {
  const bool done = std::all_of(result.axes.begin(), result.axes.end(),
                                [](const auto& axis) { return has_answer(axis) && is_confirmed(axis); });
  return done ? exit_done : exit_no_answer;
}

int run_several(const CalibrateArguments& a) {
  const report::RunsResult result = calibrate_runs(a);
  print(a.common.json ? report::runs_json(result) : report::runs_datasheet(result));
  write_sensor_files(result, a);
  if (!a.pictures.plot.empty())
    write_pictures(report::side_by_side(result), {.report = "", .plot = a.pictures.plot}, a.common);
  if (!a.pictures.report.empty()) {
    text::write_file(a.pictures.report, report::runs_page(result));
    say(a.common, "report page: " + a.pictures.report);
  }
  return every_axis_has_answer(result) ? exit_done : exit_no_answer;
}

}  // namespace

int run(const CalibrateArguments& a) {
  for (const auto& input : a.curve_file.empty() ? a.logs : std::vector{a.curve_file}) {
    check_outputs(
        input,
        {{"-o", a.output}, {"--kalibr", a.kalibr}, {"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  }
  if (a.logs.size() > 1) return run_several(a);
  const report::LogResult result = a.curve_file.empty() ? calibrate_log(a) : calibrate_table(a);
  print(a.common.json ? report::calibration_json(result) : report::datasheet(result));
  write_sensor_files(result, a);
  write_pictures(result, a.pictures, a.common);
  return exit_code(result);
}

}  // namespace gyrobudget::inline v0::cli
