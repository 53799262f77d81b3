// SPDX-License-Identifier: MIT
#include "sensor_output.h"

#include "gyrobudget/app/report/calibration.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/sensor_file/kalibr.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/sensor_file/sensor_merge.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/estimation/calibration/sensor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
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
  return text::printable(file.substr(0, file.find('.', 1)));
}

bool has_any_answer(const calibration::Datasheet& sheet) {
  return std::ranges::any_of(sheet.axes, [](const auto& axis) { return axis.has_answer(); });
}
bool has_any_answer(const calibration::TypeDatasheet& sheet) {
  return std::ranges::any_of(sheet.axes, [](const auto& axis) { return !axis.coefficients.empty(); });
}

// All that a datasheet could ever put into a file: what that would not keep is lost by any.
sensor_file::Update everything() {
  sensor_file::Update update;
  using enum noise::Term;
  for (noise::ErrorModel* triad : {&update.model.gyro, &update.model.accelerometer.emplace()}) {
    for (const auto term : {white, flicker, rate_random_walk, quantization, rate_ramp}) (*triad)[term] = 1;
    triad->gauss_markov = {{1, 1}};
    triad->sinusoids = {{1, 1}};
  }
  for (const auto signal : {noise::Signal::angular_rate, noise::Signal::specific_force})
    for (const auto term : {white, flicker, rate_random_walk, quantization, rate_ramp, gauss_markov, sinusoid})
      update.fitted.push_back({signal, term});
  return update;
}

// A file that says more than the new one would is not overwritten.
// @param perhaps  keys of a triad that the new one may have too
void keep_what_is_there(const std::string& path, const sensor_file::Update& update,
                        std::initializer_list<std::string_view> perhaps = {}) {
  auto held = [&] {
    try {
      return sensor_file::held_beyond(path, update);
    } catch (const text::InputError& error) {
      throw text::OutputError(fmt::format(
          "{}: it exists and is no sensor file, so it is not overwritten ({}); give another name", path, error.what()));
    }
  }();
  std::erase_if(held, [&](const std::string& key) {
    return std::ranges::find(perhaps, std::string_view(key).substr(key.find('.') + 1)) != perhaps.end();
  });
  if (held.empty()) return;
  throw text::OutputError(fmt::format(
      "{}: it holds {}, which this record does not tell and a new file would lose; --update puts the new coefficients into it and keeps the rest",
      path, text::listing(held)));
}

bool has_text(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && std::filesystem::file_size(path, error) > 0;
}

struct Made {
  std::string text;
  std::vector<std::string> taken;
};

template <class Sheet>
Made sensor_text(const Sheet& sheet, const calibration::SensorSummary& summary, const CalibrateArguments& a) {
  sensor_file::Update update{.model = summary.sensor,
                             .fitted = {},
                             .rename = !a.name.empty(),
                             .comment = {},
                             .warnings = report::spoilt_texts(sheet)};
  for (const auto& c : summary.coefficients) update.fitted.push_back({c.signal, c.term});
  const auto comment = [&](const noise::SensorModel& written) {
    return report::provenance(sheet, {summary, a.common.command_line, written});
  };
  if (!a.update || !has_text(a.output)) {
    keep_what_is_there(a.output, update);
    return {sensor_file::sensor_yaml(summary.sensor, comment(summary.sensor), update.warnings), {}};
  }
  for (const std::string& warning : sensor_file::read_sensor_file(a.output).warnings)
    if (!warning.starts_with(report::kNotYet)) update.warnings.push_back(warning);
  update.comment = comment(sensor_file::merged(a.output, update).model);
  auto merged = sensor_file::merged(a.output, update);
  return {std::move(merged.text), std::move(merged.taken)};
}

template <class Sheet>
std::string kalibr_text(const Sheet& sheet, const calibration::SensorSummary& summary, double rate_hz,
                        const CalibrateArguments& a) {
  std::string comment;
  for (const std::string& warning : report::spoilt_texts(sheet)) comment += fmt::format("WARNING: {}.\n", warning);
  return sensor_file::kalibr_yaml(
      summary.sensor,
      {.update_rate_hz = rate_hz, .horizon_s = a.kalibr_horizon_s, .limits = summary.limits, .comment = comment});
}

template <class Sheet>
void write_sensor_files(const Sheet& sheet, const calibration::Datasheet& first, const CalibrateArguments& a) {
  if (a.output.empty() && a.kalibr.empty()) return;
  if (std::ranges::all_of(sheet.axes, [](const auto& axis) { return axis.signal == noise::Signal::dimensionless; }))
    throw std::invalid_argument("-o and --kalibr describe gyros and accelerometers; this log has neither");
  if (!has_any_answer(sheet)) return say(a.common, "no sensor file is written: no axis has an answer to put in it");
  const auto summary = calibration::summarise(sheet, a.name.empty() ? log_name(first.source) : a.name);
  if (!a.output.empty()) {
    const Made made = sensor_text(sheet, summary, a);
    text::write_file(a.output, made.text);
    for (const std::string& key : made.taken)
      say(a.common, fmt::format("{}: {} is taken out, as the new fit has none of it", a.output, key));
  }
  if (!a.kalibr.empty()) text::write_file(a.kalibr, kalibr_text(sheet, summary, first.rate_hz, a));
  for (const auto& path : {a.output, a.kalibr})
    if (!path.empty()) say(a.common, "sensor file: " + path);
}

template <class Sheet>
int conclude(const Sheet& sheet, const CalibrateArguments& a) {
  for (const std::string& warning : report::spoilt_texts(sheet)) say(a.common, "gyrobudget: " + warning);
  return sheet.is_complete() ? exit_done : exit_no_answer;
}

}  // namespace

void check_sensor_output(const CalibrateArguments& a) {
  if (!a.output.empty() && !a.update) keep_what_is_there(a.output, everything(), {"filter", "temperature"});
}

int tell(const calibration::Datasheet& sheet, std::vector<std::string> notes, const CalibrateArguments& a) {
  auto result = report::calibration_result(sheet, std::move(notes), a.common.command_line);
  result.timing = a.timing;
  print(a.common.json ? report::calibration_json(result) : report::datasheet(result));
  write_pictures(result, a.pictures, a.common);
  write_sensor_files(sheet, sheet, a);
  return conclude(sheet, a);
}

int tell(const calibration::TypeDatasheet& sheet, std::vector<std::vector<std::string>> notes,
         const CalibrateArguments& a) {
  auto result = report::runs_result(sheet, std::move(notes), a.common.command_line);
  for (report::LogResult& run : result.runs) run.timing = a.timing;
  print(a.common.json ? report::runs_json(result) : report::runs_datasheet(result));
  if (!a.pictures.plot.empty())
    write_pictures(report::side_by_side(result), {.report = "", .plot = a.pictures.plot}, a.common);
  if (!a.pictures.report.empty()) {
    text::write_file(a.pictures.report, report::runs_page(result));
    say(a.common, "report page: " + a.pictures.report);
  }
  write_sensor_files(sheet, sheet.records.front(), a);
  return conclude(sheet, a);
}

}  // namespace gyrobudget::inline v0::cli
