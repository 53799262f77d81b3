// SPDX-License-Identifier: MIT
#include "analysis.h"

#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include "terminal.h"

namespace gyrobudget::inline v0::cli {
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

void write_pictures(const report::LogResult& result, const Pictures& pictures, const Common& common) {
  if (!pictures.report.empty()) {  // first: what a figure lacks does not take the page away
    text::write_file(pictures.report, report::page(result));
    say(common, "report page: " + pictures.report);
  }
  if (!pictures.plot.empty()) {
    report::write_plot(result, pictures.plot);
    say(common, "figure: " + pictures.plot);
  }
}

}  // namespace gyrobudget::inline v0::cli
