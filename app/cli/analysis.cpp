// SPDX-License-Identifier: MIT
#include "analysis.h"

#include "gyrobudget/allan/statistics.h"
#include "gyrobudget/allan/taus.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <cmath>

#include "terminal.h"

namespace gyrobudget::inline v0::cli {

// The text was checked when the command line was read: one of three words, or a number.
allan::Taus taus_of(const CurveArguments& a) {
  using Kind = allan::Taus::Kind;
  if (a.taus == "octave") return {Kind::octave};
  if (a.taus == "decade") return {Kind::decade};
  if (a.taus == "all") return {Kind::all};
  return {Kind::logarithmic, std::stoll(a.taus)};
}

std::vector<std::int64_t> factors_for(const CurveArguments& a, std::int64_t samples) {
  return allan::factors_of(taus_of(a), samples);
}

std::vector<std::int64_t> factors_for(const CurveArguments& a, allan::Estimator estimator, std::int64_t samples) {
  return allan::factors_of(taus_of(a), estimator, samples);
}

namespace {

void refuse_sensor_file(const std::string& path) {
  if (!path.ends_with(".yaml") && !path.ends_with(".yml")) return;
  throw text::InputError(fmt::format(
      "{}: found a sensor file by its ending, expected a log: samples as CSV, text, .npy, .f32 or .f64; gyrobudget simulate makes one of a sensor file",
      path));
}

}  // namespace

allan::Record read_record(const CurveArguments& a, const Common& common) {
  refuse_sensor_file(a.log.path);
  allan::Record record = log::read_log(a.log);
  for (const auto& note : record.notes) say(common, "note: " + note);
  return record;
}

std::vector<allan::Record> read_cut_record(const CurveArguments& a, double longest_gap_s, const Common& common) {
  std::vector<allan::Record> records = log::read_segments(a.log, longest_gap_s);
  for (const auto& record : records) {
    for (const auto& note : record.notes) say(common, "note: " + note);
  }
  return records;
}

report::LogResult describe_record(const allan::Record& record, const Common& common) {
  report::LogResult result;
  result.source = record.source;
  result.command = common.command_line;
  result.rate_hz = record.rate_hz;
  result.samples = record.samples;
  result.missing_samples = record.missing_samples;
  result.notes = record.notes;
  return result;
}

allan::Series rate_record(const allan::Axis& axis, const allan::Record& record, const CurveArguments& a) {
  return allan::Series(axis.rate, 1 / record.rate_hz, a.strict_gaps ? 1 : allan::kMinimumFill);
}

allan::Form form_of(const CurveArguments& a) { return a.ieee_form ? allan::Form::ieee : allan::Form::full; }

void write_pictures(const report::LogResult& result, const Pictures& pictures, const Common& common) {
  if (!pictures.plot.empty()) {
    report::write_plot(result, pictures.plot);
    say(common, "figure: " + pictures.plot);
  }
  if (!pictures.report.empty()) {
    text::write_file(pictures.report, report::page(result));
    say(common, "report page: " + pictures.report);
  }
}

}  // namespace gyrobudget::inline v0::cli
