// SPDX-License-Identifier: MIT
// accuracy: records of known truth, every fit against it, limits held or broken.
#include "gyrobudget/app/report/accuracy.h"

#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

noise::ErrorModel axis_of(const noise::SensorModel& sensor, const AccuracyArguments& a) {
  const bool gyro = a.signal == noise::Signal::angular_rate;
  const char* name = gyro ? "gyro" : "accelerometer";
  if (!gyro && !sensor.accelerometer) throw text::InputError(fmt::format("{}: it has no accelerometer", a.sensor));
  noise::ErrorModel model = gyro ? sensor.gyro : *sensor.accelerometer;
  if (model.processes().empty()) {
    throw text::InputError(
        fmt::format("{}: the {} has no noise coefficient above zero; accuracy needs the truth", a.sensor, name));
  }
  return model;
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
  progress.update(0, records);
  return fit::measure_accuracy(truth, options);
}

}  // namespace

int run(const AccuracyArguments& a) {
  check_outputs(a.sensor, {{"--report", a.report}});
  const noise::SensorModel sensor = sensor_file::read_sensor(a.sensor);
  const auto truth = axis_of(sensor, a).processes();
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
