// SPDX-License-Identifier: MIT
#include "analysis.h"

#include "gyrobudget/allan/confidence.h"
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/identify.h"
#include "gyrobudget/io/output.h"
#include "gyrobudget/report/report.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>

#include "terminal.h"

namespace gyrobudget::inline v0::cli {

std::vector<std::int64_t> factors_for(const CurveArguments& a, std::int64_t samples) {
  if (a.taus == "octave") return allan::octave_factors(samples);
  if (a.taus == "decade") return allan::decade_factors(samples);
  if (a.taus == "all") return allan::all_factors(samples);
  return allan::log_factors(samples, std::stoll(a.taus));
}

io::Record read_record(const CurveArguments& a, const Common& common) {
  io::Record record = io::read_log(a.log);
  for (const auto& note : record.notes) say(common, "note: " + note);
  return record;
}

report::LogResult describe_record(const io::Record& record, const Common& common) {
  report::LogResult result;
  result.source = record.source;
  result.command = common.command_line;
  result.rate_hz = record.rate_hz;
  result.samples = record.samples;
  result.missing_samples = record.missing_samples;
  result.notes = record.notes;
  return result;
}

allan::RateRecord rate_record(const io::Axis& axis, const io::Record& record, const CurveArguments& a) {
  return allan::RateRecord(axis.rate, 1 / record.rate_hz, a.strict_gaps ? 1 : allan::kMinimumFill);
}

allan::Form form_of(const CurveArguments& a) { return a.ieee_form ? allan::Form::ieee : allan::Form::full; }

std::vector<report::DeviationPoint> with_intervals(const allan::Curve& curve,
                                                   std::span<const allan::Identified> identified,
                                                   std::span<const noise::Process> mix) {
  std::vector<report::DeviationPoint> points(curve.points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const allan::Point& p = curve.points[i];
    if (p.terms < 1 || !std::isfinite(p.variance)) return;
    const allan::Identified type = identified.empty() ? allan::Identified{} : identified[i];
    const std::array single{noise::unit_process(type.term)};
    const double edf = allan::equivalent_dof(curve.samples, p.m, curve.dt, mix.empty() ? single : mix,
                                             curve.form, curve.mask.get());
    const allan::Interval interval = allan::chi_square_interval(p.variance, edf);
    points[i] = {.m = p.m,
                 .tau_s = curve.tau(i),
                 .deviation = std::sqrt(p.variance),
                 .lower = std::sqrt(interval.lower),
                 .upper = std::sqrt(interval.upper),
                 .edf = edf,
                 .terms = p.terms,
                 .alpha = type.alpha};
  });
  std::erase_if(points, [](const auto& p) { return p.terms < 1; });
  return points;
}

void write_pictures(const report::LogResult& result, const Pictures& pictures, const Common& common) {
  if (!pictures.plot.empty()) {
    report::write_plot(result, pictures.plot);
    say(common, "figure: " + pictures.plot);
  }
  if (!pictures.report.empty()) {
    io::write_file(pictures.report, report::page(result));
    say(common, "report page: " + pictures.report);
  }
}

}  // namespace gyrobudget::inline v0::cli
