// SPDX-License-Identifier: MIT
#include "sensor_output.h"

#include "gyrobudget/app/report/calibration.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/estimation/calibration/sensor_model.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "analysis.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

// "logs/gyro_7.csv.gz" is gyro_7.
std::string log_name(const std::string& source) {
  const std::string file = std::filesystem::path(source).filename().string();
  return file.substr(0, file.find('.', 1));
}

bool has_any_answer(const calibration::Datasheet& sheet) {
  return std::ranges::any_of(sheet.axes, [](const auto& axis) { return axis.has_answer(); });
}
bool has_any_answer(const calibration::TypeDatasheet& sheet) {
  return std::ranges::any_of(sheet.axes, [](const auto& axis) { return !axis.coefficients.empty(); });
}

template <class Sheet>
void write_sensor_files(const Sheet& sheet, const calibration::Datasheet& first, const CalibrateArguments& a) {
  if (a.output.empty() && a.kalibr.empty()) return;
  if (std::ranges::all_of(sheet.axes, [](const auto& axis) { return axis.signal == noise::Signal::dimensionless; }))
    throw std::invalid_argument("-o and --kalibr describe gyros and accelerometers; this log has neither");
  if (!has_any_answer(sheet)) return say(a.common, "no sensor file is written: no axis has an answer to put in it");
  const auto sensor = calibration::sensor_model(sheet, a.name.empty() ? log_name(first.source) : a.name);
  if (!a.output.empty())
    text::write_file(a.output, sensor_file::sensor_yaml(sensor, report::provenance(sheet, a.common.command_line)));
  if (!a.kalibr.empty()) text::write_file(a.kalibr, sensor_file::kalibr_yaml(sensor, first.rate_hz));
  for (const auto& path : {a.output, a.kalibr})
    if (!path.empty()) say(a.common, "sensor file: " + path);
}

}  // namespace

int tell(const calibration::Datasheet& sheet, std::vector<std::string> notes, const CalibrateArguments& a) {
  const auto result = report::calibration_result(sheet, std::move(notes), a.common.command_line);
  print(a.common.json ? report::calibration_json(result) : report::datasheet(result));
  write_sensor_files(sheet, sheet, a);
  write_pictures(result, a.pictures, a.common);
  return sheet.is_complete() ? exit_done : exit_no_answer;
}

int tell(const calibration::TypeDatasheet& sheet, std::vector<std::vector<std::string>> notes,
         const CalibrateArguments& a) {
  const auto result = report::runs_result(sheet, std::move(notes), a.common.command_line);
  print(a.common.json ? report::runs_json(result) : report::runs_datasheet(result));
  write_sensor_files(sheet, sheet.records.front(), a);
  if (!a.pictures.plot.empty())
    write_pictures(report::side_by_side(result), {.report = "", .plot = a.pictures.plot}, a.common);
  if (!a.pictures.report.empty()) {
    text::write_file(a.pictures.report, report::runs_page(result));
    say(a.common, "report page: " + a.pictures.report);
  }
  return sheet.is_complete() ? exit_done : exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli
