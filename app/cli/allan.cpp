// SPDX-License-Identifier: MIT
// allan: log -> Allan deviation with degrees of freedom and intervals.
#include "gyrobudget/report/report.h"

#include "analysis.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {

int run(const AllanArguments& a) {
  check_outputs(a.curve.log.path, {{"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  const io::Record record = read_record(a.curve, a.common);
  report::LogResult result = describe_record(record, a.common);
  const auto factors = factors_for(a.curve, record.samples);
  for (const auto& axis : record.axes) {
    const allan::RateRecord rates = rate_record(axis, record, a.curve);
    const allan::Curve curve = allan::overlapped_variance(rates, factors, form_of(a.curve));
    result.axes.push_back({.name = axis.name,
                           .signal = axis.signal,
                           .mean = curve.mean,
                           .points = with_intervals(curve, allan::identify_noise(rates, factors)),
                           .fit = {},
                           .advice = {}});
  }
  print(a.common.json ? report::allan_json(result) : report::allan_table(result));
  write_pictures(result, a.pictures, a.common);
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli
