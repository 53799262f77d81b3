// SPDX-License-Identifier: MIT
// allan: log -> deviations with degrees of freedom and intervals.
#include "gyrobudget/allan/analysis.h"
#include "gyrobudget/app/report/analysis.h"
#include "gyrobudget/app/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "analysis.h"
#include "paths.h"
#include "segments.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

allan::Analysis analyse(const std::vector<allan::Record>& records, const AllanArguments& a) {
  try {
    return allan::analyse(records, {.estimators = a.estimators,
                                    .taus = a.curve.taus,
                                    .overlap = a.overlap,
                                    .form = a.curve.form,
                                    .minimum_fill = a.curve.minimum_fill,
                                    .spectrum = a.psd,
                                    .window_s = a.dynamic_s});
  } catch (const allan::WindowError& error) {
    throw std::invalid_argument(fmt::format("--dynamic: {}", error.what()));
  }
}

}  // namespace

int run(const AllanArguments& a) {
  if (a.stream) return run_stream(a);
  const std::vector<Output> outputs{{"--report", a.pictures.report}, {"--plot", a.pictures.plot}};
  for (const auto& path : logs_of(a)) check_outputs(path, outputs);
  const std::vector<allan::Record> records = read_segments(a);
  const report::LogResult result = report::log_result(records, analyse(records, a), a.common.command_line,
                                                      a.gap_s ? report::Pooled::segments : report::Pooled::logs);
  print(a.common.json ? report::allan_json(result) : report::allan_table(result));
  write_pictures(result, a.pictures, a.common);
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli
