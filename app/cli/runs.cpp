// SPDX-License-Identifier: MIT
#include "runs.h"

#include "gyrobudget/app/report/words.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/estimation/fit/combine.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "analysis.h"
#include "fitting.h"

namespace gyrobudget::inline v0::cli {
namespace {

constexpr std::int64_t kFewestSamples = 16;  // 4 octaves: three terms and one tau more

report::LogResult calibrate_record(const allan::Record& record, const CalibrateArguments& a) {
  if (record.samples < kFewestSamples) {
    throw text::InputError(fmt::format(
        "{}: found {} samples, expected at least {}; a datasheet needs hours of record (gyrobudget plan tells how many)",
        record.source, record.samples, kFewestSamples));
  }
  report::LogResult result = describe_record(record, a.common);
  Covariances covariances;
  result.axes.resize(record.axes.size());
  tbb::parallel_for(std::size_t{0}, record.axes.size(), [&](std::size_t i) {
    result.axes[i] = calibrate_axis(record.axes[i], record.rate_hz, a, covariances);
  });
  return result;
}

template <class Axes>
std::string listing(const Axes& axes) {
  std::string text;
  for (const auto& axis : axes) text += fmt::format("{}'{}'", text.empty() ? "" : ", ", axis.name);
  return text;
}

// The axes of `record` in the order of the first record's.
std::vector<allan::Axis> matched(allan::Record& record, const report::LogResult& first) {
  const std::string found = listing(record.axes);
  std::vector<allan::Axis> axes;
  for (const auto& wanted : first.axes) {
    const auto at = std::find_if(record.axes.begin(), record.axes.end(), [&](const allan::Axis& axis) {
      return axis.name == wanted.name && axis.signal == wanted.signal;
    });
    if (at == record.axes.end()) break;
    axes.push_back(std::move(*at));
    record.axes.erase(at);
  }
  if (record.axes.empty() && axes.size() == first.axes.size()) return axes;
  throw text::InputError(fmt::format(
      "{}: found the columns {}, expected {} as in {}; records of one sensor type have the same columns, in units of the same kinds (choose them with --column)",
      record.source, found, listing(first.axes), first.source));
}

void check_rate(const allan::Record& record, const report::LogResult& first) {
  if (std::abs(record.rate_hz / first.rate_hz - 1) <= log::kRateTolerance) return;
  throw text::InputError(fmt::format(
      "{}: found a rate of {:.6g} Hz, expected the {:.6g} Hz of {}; quantization and filters depend on the rate, so records of other rates are not combined",
      record.source, record.rate_hz, first.rate_hz, first.source));
}

report::CombinedAxis combined(const std::vector<report::LogResult>& runs, std::size_t axis) {
  const auto& first = runs.front().axes[axis];
  report::CombinedAxis result{.name = first.name, .signal = first.signal, .coefficients = {}, .left_out = {}};
  std::vector<fit::Result> fits;
  for (const auto& run : runs) {
    const auto& fit = run.axes[axis].fit;
    if (fit && report::is_quotable(*fit)) {
      fits.push_back(*fit);
    } else {
      result.left_out.push_back(run.source);
    }
  }
  if (!fits.empty()) result.coefficients = fit::combine(fits);
  return result;
}

}  // namespace

report::LogResult calibrate_log(const CalibrateArguments& a) {
  return calibrate_record(read_record(a.curve, a.common), a);
}

report::RunsResult calibrate_runs(const CalibrateArguments& a) {
  report::RunsResult result{.command = a.common.command_line, .runs = {}, .combined = {}};
  for (const auto& log : a.logs) {
    CurveArguments of_log = a.curve;
    of_log.log.path = log;
    allan::Record record = read_record(of_log, a.common);
    if (!result.runs.empty()) {
      check_rate(record, result.runs.front());
      record.axes = matched(record, result.runs.front());
    }
    result.runs.push_back(calibrate_record(record, a));
  }
  for (std::size_t i = 0; i < result.runs.front().axes.size(); ++i) result.combined.push_back(combined(result.runs, i));
  return result;
}

}  // namespace gyrobudget::inline v0::cli
