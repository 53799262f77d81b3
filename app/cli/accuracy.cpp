// SPDX-License-Identifier: MIT
// accuracy: records of known truth, every fit against it, limits held or broken.
#include "gyrobudget/app/report/accuracy.h"

#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "accuracy_sweep.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

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

std::vector<Term> terms_to_fit(const noise::ErrorModel& truth, const AccuracyArguments& a) {
  if (a.terms) return *a.terms;
  std::vector<Term> list{noise::Term::white, Term::flicker, Term::rate_random_walk};
  for (const Term t : {Term::quantization, Term::rate_ramp}) {
    if (truth[t] > 0) list.push_back(t);
  }
  return list;
}

std::int64_t samples_of(const AccuracyArguments& a) { return std::llround(a.duration_s * a.rate_hz); }

fit::Accuracy measure(const noise::ErrorModel& truth, const AccuracyArguments& a, int records) {
  Progress progress(a.common, "records");
  const Interruption interruption;
  fit::AccuracyOptions options{.samples = samples_of(a),
                               .dt = 1 / a.rate_hz,
                               .records = records,
                               .seed = a.seed,
                               .methods = a.methods,
                               .progress = [&](int done, int of) { progress.update(done, of); },
                               .cancel = &interruption.asked()};
  options.fit.terms = terms_to_fit(truth, a);
  progress.update(0, records);
  return fit::measure_accuracy(truth.processes(), options);
}

void write_page(const AccuracyArguments& a, const std::string& page) {
  text::write_file(a.report, page);
  say(a.common, "report page: " + a.report);
}

int run_study(const noise::SensorModel& sensor, const noise::ErrorModel& truth, const AccuracyArguments& a) {
  constexpr int kRecords = 500;
  report::AccuracyStudy study{.sensor = sensor.name,
                              .command = a.common.command_line,
                              .signal = a.signal,
                              .asked = a.records.value_or(kRecords)};
  study.accuracy = measure(truth, a, study.asked);
  study.checks = fit::check(a.requirements, study.accuracy);
  print(a.common.json ? report::accuracy_json(study) : report::accuracy_table(study));
  if (!a.report.empty()) write_page(a, report::accuracy_page(study));
  if (!study.accuracy.complete) {
    say(a.common, fmt::format("interrupted: the result is that of the first {} of {} records", study.accuracy.records,
                              study.asked));
    return exit_interrupted;
  }
  const bool held = std::ranges::all_of(study.checks, &fit::Check::met);
  return held ? exit_done : exit_no_answer;
}

int run_sweep(const noise::SensorModel& sensor, const noise::ErrorModel& truth, const AccuracyArguments& a) {
  constexpr int kRecords = 200;
  constexpr double kLongest = 1e7;
  report::Sweep sweep{.sensor = sensor.name,
                      .command = a.common.command_line,
                      .signal = a.signal,
                      .rate_hz = a.rate_hz,
                      .seed = a.seed};
  {
    Progress progress(a.common, "work");
    const Interruption interruption;
    SweepOptions options{.samples = samples_of(a),
                         .longest = static_cast<std::int64_t>(a.longest.value_or(kLongest)),
                         .dt = 1 / a.rate_hz,
                         .records = a.records.value_or(kRecords),
                         .seed = a.seed,
                         .terms = terms_to_fit(truth, a),
                         .progress = [&](double done, double of) { progress.update(done, of); },
                         .cancel = &interruption.asked()};
    progress.update(0, 1);
    measure_sweep(truth.processes(), options, sweep);
  }
  print(a.common.json ? report::sweep_json(sweep) : report::sweep_table(sweep));
  if (!a.report.empty()) write_page(a, report::sweep_page(sweep));
  if (sweep.complete) return exit_done;
  say(a.common, "interrupted: the rows are of the records that were finished");
  return exit_interrupted;
}

}  // namespace

int run(const AccuracyArguments& a) {
  check_outputs(a.sensor, {{"--report", a.report}});
  const noise::SensorModel sensor = sensor_file::read_sensor(a.sensor);
  const noise::ErrorModel truth = axis_of(sensor, a);
  return a.sweep ? run_sweep(sensor, truth, a) : run_study(sensor, truth, a);
}

}  // namespace gyrobudget::inline v0::cli
