// SPDX-License-Identifier: MIT
// calibrate: log -> datasheet: the coefficients with intervals and verdicts, and the files to use next.
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/identify.h"
#include "gyrobudget/fit/visual.h"
#include "gyrobudget/io/curve_table.h"
#include "gyrobudget/io/output.h"
#include "gyrobudget/io/sensor_file.h"
#include "gyrobudget/report/report.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "advice.h"
#include "analysis.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

constexpr std::int64_t kFewestSamples = 16;  // 4 octaves: three terms and one tau more

// Display taus and the fit's octaves in one pass over the record, then apart again.
struct Curves {
  allan::Curve display;
  allan::Curve octaves;
  std::vector<allan::Identified> identified;  // at each tau of `display`; empty for a table
};

allan::Curve pick(const allan::Curve& curve, const std::vector<std::int64_t>& factors) {
  allan::Curve picked = curve;
  std::erase_if(picked.points,
                [&](const auto& p) { return !std::binary_search(factors.begin(), factors.end(), p.m); });
  return picked;
}

Curves curves_of(const io::Axis& axis, const io::Record& record, const CurveArguments& a) {
  const auto display = factors_for(a, record.samples);
  const auto octaves = allan::octave_factors(record.samples);
  std::vector<std::int64_t> both;
  std::set_union(display.begin(), display.end(), octaves.begin(), octaves.end(), std::back_inserter(both));
  const allan::RateRecord rates = rate_record(axis, record, a);
  const allan::Curve curve = allan::overlapped_variance(rates, both, form_of(a));
  return {pick(curve, display), pick(curve, octaves), allan::identify_noise(rates, display)};
}

// N, B and K; and Q where lag-1 identification sees white angle noise at the first tau.
std::vector<Term> terms_for(const CalibrateArguments& a, const std::vector<allan::Identified>& identified) {
  if (a.terms) return *a.terms;
  std::vector<Term> terms{Term::white, Term::flicker, Term::rate_random_walk};
  if (!identified.empty() && identified.front().alpha == 2) terms.insert(terms.begin(), Term::quantization);
  return terms;
}

// The covariance matrices depend on the record's length, its gaps and the terms, not on the data: axes share them.
class Covariances {
 public:
  using Shared = std::shared_ptr<const allan::CurveCovariance>;

  Shared of(const allan::Curve& curve, const std::vector<Term>& terms) {
    const std::scoped_lock lock(mutex_);
    for (const auto& known : known_) {
      if (known.terms == terms && same_gaps(known.mask.get(), curve.mask.get())) return known.covariance;
    }
    // Isolated: a thread that waits in here must not take up another axis, which would want the lock.
    tbb::this_task_arena::isolate([&] { known_.push_back({terms, curve.mask, make(curve, terms)}); });
    return known_.back().covariance;
  }

 private:
  struct Known {
    std::vector<Term> terms;
    std::shared_ptr<const allan::Mask> mask;
    Shared covariance;
  };

  static bool same_gaps(const allan::Mask* a, const allan::Mask* b) {
    if (a == nullptr || b == nullptr) return a == b;
    return std::equal(a->runs().begin(), a->runs().end(), b->runs().begin(), b->runs().end(),
                      [](const auto& x, const auto& y) { return x.first == y.first && x.count == y.count; });
  }

  static Shared make(const allan::Curve& curve, const std::vector<Term>& terms) {
    std::vector<std::int64_t> factors;
    for (const auto& p : curve.points) factors.push_back(p.m);
    std::vector<noise::Process> processes;
    for (const Term t : terms) processes.push_back(noise::unit_process(t));
    return std::make_shared<const allan::CurveCovariance>(curve.samples, std::move(factors), curve.dt,
                                                          std::move(processes), curve.form, curve.mask.get());
  }

  std::mutex mutex_;
  std::vector<Known> known_;
};

// Gaps, or a table of few taus, may leave too little to fit.
void check_enough(const io::Axis& axis, const allan::Curve& curve, std::size_t terms) {
  const auto usable = std::count_if(curve.points.begin(), curve.points.end(),
                                    [](const auto& p) { return p.terms > 0 && std::isfinite(p.variance); });
  if (static_cast<std::size_t>(usable) > terms) return;
  const std::int64_t missing = curve.mask ? curve.mask->missing() : 0;
  throw io::InputError(fmt::format(
      "column '{}': found {} usable averaging times, expected at least {} to fit {} terms; {} of {} samples "
      "are missing, and "
      "a cluster needs 95 % of its own; fit fewer terms (--terms) or use a part of the log without gaps",
      axis.name, usable, terms + 1, terms, missing, curve.samples));
}

bool is_silent(const allan::Curve& curve) {
  return std::all_of(curve.points.begin(), curve.points.end(),
                     [](const auto& p) { return !(p.variance > 0); });
}

fit::Result fit_axis(const io::Axis& axis, const Curves& curves, const CalibrateArguments& a,
                     Covariances& covariances) {
  fit::Options options;
  options.terms = terms_for(a, curves.identified);
  check_enough(axis, curves.octaves, options.terms.size());
  options.method = a.method;
  options.tau_min_s = a.tau_min_s;
  options.tau_max_s = a.tau_max_s;
  if (a.method == fit::Method::visual && !is_silent(curves.display))
    return fit::read_visually(curves.display, options);
  fit::Result result = fit::fit(curves.octaves, *covariances.of(curves.octaves, options.terms), options);
  note_minimum(result, curves.display);
  return result;
}

report::AxisResult calibrate_axis(const io::Axis& axis, const io::Record& record, const CalibrateArguments& a,
                                  Covariances& covariances) {
  const Curves curves = curves_of(axis, record, a.curve);
  report::AxisResult result{.name = axis.name, .signal = axis.signal, .mean = curves.octaves.mean};
  result.fit = fit_axis(axis, curves, a, covariances);
  const auto mix = result.fit->verdict == fit::Verdict::not_described ? std::vector<noise::Process>{}
                                                                      : result.fit->processes();
  result.points = with_intervals(curves.display, curves.identified, mix);
  result.advice = advise(*result.fit, axis, curves.octaves);
  return result;
}

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
    result.axes[i] = calibrate_axis(record.axes[i], record, a, covariances);
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
    axis_result.fit = fit_axis(axis, curves, a, covariances);
    axis_result.points = with_intervals(display, {}, axis_result.fit->processes());
    axis_result.advice = advise(*axis_result.fit, axis, curves.octaves);
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
      axis.fit->verdict != fit::Verdict::not_described || axis.fit->method == fit::Method::visual;
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
