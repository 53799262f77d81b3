// SPDX-License-Identifier: MIT
// calibrate: log -> datasheet: the coefficients with intervals and verdicts, and the files to use next.
#include "gyrobudget/app/log/curve_table.h"
#include "gyrobudget/app/report/calibration.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "analysis.h"
#include "paths.h"
#include "sensor_output.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

int run_table(const CalibrateArguments& a) {
  const double rate_hz = *a.curve.log.rate_hz;
  const auto table = log::read_curve({a.curve_file, a.curve.log.unit, a.curve.log.columns});
  const auto sheet = calibration::calibrate(table, rate_hz, std::llround(*a.duration_s * rate_hz), a.options);
  return tell(sheet, {"fitted to a table of deviations, taken as fully overlapped ones of a record without gaps"}, a);
}

// What one log holds: a record, or one for each segment.
std::vector<allan::Record> records_of(const CalibrateArguments& a, const std::string& path) {
  CurveArguments of_log = a.curve;
  of_log.log.path = path;
  std::vector<allan::Record> records;
  if (a.gap_s)
    records = read_cut_record(of_log, *a.gap_s, a.common);
  else
    records.push_back(read_record(of_log, a.common));
  for (std::size_t i = 0; records.size() > 1 && i < records.size(); ++i)
    records[i].source += fmt::format(", segment {}", i + 1);
  return records;
}

int run_logs(const CalibrateArguments& a) {
  std::vector<calibration::Datasheet> sheets;
  std::vector<std::vector<std::string>> notes;
  for (const auto& path : a.logs) {
    for (allan::Record& record : records_of(a, path)) {
      if (!sheets.empty()) record = calibration::matched(std::move(record), sheets.front());
      sheets.push_back(calibration::calibrate(record, a.options));
      notes.push_back(std::move(record.notes));
    }
  }
  if (sheets.size() == 1) return tell(sheets.front(), std::move(notes.front()), a);
  return tell(calibration::combine(std::move(sheets)), std::move(notes), a);
}

}  // namespace

int run(const CalibrateArguments& asked) {
  CalibrateArguments a = asked;
  a.options.taus = a.curve.taus;
  a.options.form = a.curve.form;
  a.options.minimum_fill = a.curve.minimum_fill;
  for (const auto& input : a.curve_file.empty() ? a.logs : std::vector{a.curve_file})
    check_outputs(
        input,
        {{"-o", a.output}, {"--kalibr", a.kalibr}, {"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  check_sensor_output(a);
  try {
    if (!a.curve_file.empty()) return run_table(a);
    return run_logs(a);
  } catch (const calibration::Unusable& error) {
    throw text::InputError(fmt::format("{}; {}", error.what(), report::mend(error.reason)));
  }
}

}  // namespace gyrobudget::inline v0::cli
