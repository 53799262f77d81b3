// SPDX-License-Identifier: MIT
// calibrate: log -> datasheet: the coefficients with intervals and verdicts, and the files to use next.
#include "gyrobudget/app/log/curve_table.h"
#include "gyrobudget/app/report/calibration.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <cmath>
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

int run_log(const CalibrateArguments& a) {
  const allan::Record record = read_record(a.curve, a.common);
  return tell(calibration::calibrate(record, a.options), record.notes, a);
}

int run_several(const CalibrateArguments& a) {
  std::vector<calibration::Datasheet> sheets;
  std::vector<std::vector<std::string>> notes;
  for (const auto& path : a.logs) {
    CurveArguments of_log = a.curve;
    of_log.log.path = path;
    allan::Record record = read_record(of_log, a.common);
    if (!sheets.empty()) record = calibration::matched(std::move(record), sheets.front());
    sheets.push_back(calibration::calibrate(record, a.options));
    notes.push_back(std::move(record.notes));
  }
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
    return a.logs.size() > 1 ? run_several(a) : run_log(a);
  } catch (const calibration::Unusable& error) {
    throw text::InputError(fmt::format("{}; {}", error.what(), report::mend(error.reason)));
  }
}

}  // namespace gyrobudget::inline v0::cli
