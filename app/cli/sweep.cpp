// SPDX-License-Identifier: MIT
// accuracy --sweep: the same records fitted in many ways, error against run time.
#include "gyrobudget/app/report/accuracy.h"

#include <cmath>

#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

fit::Sweep measure(const std::vector<noise::Process>& truth, const AccuracyArguments& a) {
  constexpr int kRecords = 200;
  constexpr double kLongest = 1e7;
  Progress progress(a.common, "work");
  const Interruption interruption;
  const fit::SweepOptions options{.samples = std::llround(a.duration_s * a.rate_hz),
                                  .longest = static_cast<std::int64_t>(a.longest.value_or(kLongest)),
                                  .dt = 1 / a.rate_hz,
                                  .records = a.records.value_or(kRecords),
                                  .seed = a.seed,
                                  .terms = a.terms.value_or(fit::terms_to_measure(truth)),
                                  .progress = [&](double done, double of) { progress.update(done, of); },
                                  .cancel = &interruption.asked()};
  progress.update(0, 1);
  return fit::sweep(truth, options);
}

}  // namespace

int run_sweep(const AccuracyArguments& a, const std::string& sensor, const std::vector<noise::Process>& truth) {
  const report::SweepStudy study{.sensor = sensor,
                                 .command = a.common.command_line,
                                 .signal = a.signal,
                                 .rate_hz = a.rate_hz,
                                 .seed = a.seed,
                                 .sweep = measure(truth, a)};
  print(a.common.json ? report::sweep_json(study) : report::sweep_table(study));
  if (!a.report.empty()) write_page(a.report, report::sweep_page(study), a.common);
  if (study.sweep.complete) return exit_done;
  say(a.common, "interrupted: the rows are of the records that were finished");
  return exit_interrupted;
}

}  // namespace gyrobudget::inline v0::cli
