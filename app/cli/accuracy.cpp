// SPDX-License-Identifier: MIT
// accuracy: records of known truth, every fit against it, limits held or broken.
#include "gyrobudget/app/report/accuracy.h"

#include "gyrobudget/app/report/sensor_words.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/estimation/calibration/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

std::vector<noise::Process> truth_of(const noise::SensorModel& sensor, const AccuracyArguments& a) {
  const bool gyro = a.signal == noise::Signal::angular_rate;
  const char* name = gyro ? "gyro" : "accelerometer";
  if (!gyro && !sensor.accelerometer) throw text::InputError(fmt::format("{}: it has no accelerometer", a.sensor));
  const noise::ErrorModel& model = gyro ? sensor.gyro : *sensor.accelerometer;
  if (!a.axis && !model.axes_are_alike())
    throw text::InputError(
        fmt::format("{0}: the axes of the {1} differ; choose one: --axis {1}_x, {1}_y or {1}_z", a.sensor, name));
  auto truth = model.processes(a.axis.value_or(0));
  if (truth.empty()) {
    throw text::InputError(
        fmt::format("{}: the {} has no noise coefficient above zero; accuracy needs the truth", a.sensor, name));
  }
  return truth;
}

fit::Accuracy measure(const std::vector<noise::Process>& truth, const AccuracyArguments& a, int records) {
  Progress progress(a.common, "records");
  const Interruption interruption;
  fit::AccuracyOptions options{.samples = std::llround(a.duration_s * a.rate_hz),
                               .dt = 1 / a.rate_hz,
                               .records = records,
                               .seed = a.seed,
                               .methods = a.methods,
                               .progress = [&](int done, int of) { progress.update(done, of); },
                               .cancel = &interruption.asked()};
  options.fit.terms = a.terms.value_or(fit::terms_to_measure(truth));
  options.fit.front_end = a.calibrate.front_end;
  progress.update(0, records);
  if (a.recorder) return calibration::measure_accuracy(truth, *a.recorder, options, a.calibrate);
  return fit::measure_accuracy(truth, options);
}

}  // namespace

int run(const AccuracyArguments& a) {
  check_outputs(a.sensor, {{"--report", a.report}});
  const sensor_file::SensorFile file = sensor_file::read_sensor_file(a.sensor, {.rate_hz = a.sensor_rate_hz});
  const noise::SensorModel& sensor = file.model;
  const auto truth = truth_of(sensor, a);
  for (const auto& note : report::sensor_notes(file.warnings, file.notes, a.sensor)) say(a.common, "note: " + note);
  if (a.sweep) return run_sweep(a, sensor.name, truth);
  constexpr int kRecords = 500;
  report::AccuracyStudy study{.sensor = sensor.name,
                              .command = a.common.command_line,
                              .signal = a.signal,
                              .asked = a.records.value_or(kRecords)};
  study.accuracy = measure(truth, a, study.asked);
  study.checks = fit::check(a.requirements, study.accuracy);
  print(a.common.json ? report::accuracy_json(study) : report::accuracy_table(study));
  if (!a.report.empty()) write_page(a.report, report::accuracy_page(study), a.common);
  if (!study.accuracy.complete) {
    say(a.common, fmt::format("interrupted: the result is that of the first {} of {} records", study.accuracy.records,
                              study.asked));
    return exit_interrupted;
  }
  const bool held = std::ranges::all_of(study.checks, &fit::Check::met);
  return held ? exit_done : exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli
