// SPDX-License-Identifier: MIT
// allan: log -> deviations with degrees of freedom and intervals.
#include "gyrobudget/allan/dynamic.h"
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/family.h"
#include "gyrobudget/allan/psd.h"
#include "gyrobudget/allan/statistics.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>

#include "analysis.h"
#include "paths.h"
#include "stream.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using allan::DeviationPoint;
using allan::Estimator;

/// The curve of one record, with what its noise was found to be at each tau.
struct Measured {
  allan::Curve curve;
  std::vector<allan::Identified> noises;
};

Measured measure(const allan::Series& rates, Estimator estimator, const std::vector<std::int64_t>& factors,
                 const AllanArguments& a) {
  std::vector<std::int64_t> usable;  // a segment may be shorter than the one that the factors are made for
  std::ranges::copy_if(factors, std::back_inserter(usable),
                       [&](auto m) { return allan::has_terms(estimator, rates.samples(), m); });
  allan::Curve curve = allan::deviation(rates, estimator, usable, {.overlap = a.overlap, .form = form_of(a.curve)});
  auto noises = allan::identify_noise(rates, curve);
  return {std::move(curve), std::move(noises)};
}

// --- Several logs into one curve --------------------------------------------------------------------------------------

/// Of the segments' points at this tau, the one that knows most.
DeviationPoint best_at(double tau, const std::vector<std::vector<allan::DeviationPoint>>& segments) {
  allan::DeviationPoint best;
  for (const auto& points : segments) {
    for (const allan::DeviationPoint& p : points) {
      if (p.tau_s == tau && p.edf > best.edf) best = p;
    }
  }
  return best;
}

std::vector<allan::DeviationPoint> pooled(const std::vector<Measured>& segments) {
  std::vector<std::vector<allan::PointStatistics>> statistics;
  std::vector<std::vector<allan::DeviationPoint>> points;
  std::vector<allan::Segment> list;
  for (const Measured& s : segments) {
    statistics.push_back(allan::statistics(s.curve, s.noises));
    points.push_back(allan::deviation_points(s.curve, s.noises));
  }
  for (std::size_t i = 0; i < segments.size(); ++i) list.push_back({&segments[i].curve, statistics[i]});
  std::vector<allan::DeviationPoint> result;
  for (const allan::PooledPoint& p : allan::pool(list)) {
    allan::DeviationPoint point = best_at(p.tau, points);
    point.deviation = std::sqrt(p.variance);
    point.lower = std::sqrt(p.interval.lower);
    point.upper = std::sqrt(p.interval.upper);
    point.edf = p.edf;
    point.terms = p.terms;
    result.push_back(point);
  }
  return result;
}

void check_alike(const allan::Record& first, const allan::Record& other) {
  const auto same = [](const allan::Axis& a, const allan::Axis& b) { return a.name == b.name && a.signal == b.signal; };
  if (!std::ranges::equal(first.axes, other.axes, same)) {
    throw text::InputError(fmt::format(
        "{}: its columns are not those of {}, expected segments of one log; choose the same columns of both with --column",
        other.source, first.source));
  }
  constexpr double kSameRate = 1e-3;  // of clocks that were read from time stamps
  if (std::abs(other.rate_hz / first.rate_hz - 1) <= kSameRate) return;
  throw text::InputError(
      fmt::format("{}: its rate is {:.6g} Hz, that of {} {:.6g} Hz; only logs of one rate are pooled", other.source,
                  other.rate_hz, first.source, first.rate_hz));
}

/// A log that is pooled with itself would look twice as sure.
void check_segments(const AllanArguments& a) {
  std::vector<std::string> paths{a.curve.log.path};
  for (const auto& path : a.segments) {
    if (std::ranges::find(paths, path) != paths.end())
      throw std::invalid_argument(fmt::format("{} is given twice", path));
    paths.push_back(path);
  }
}

/// One or several power-ups of a sensor, from one or several logs.
std::vector<allan::Record> read_segments(const AllanArguments& a) {
  std::vector<std::string> paths{a.curve.log.path};
  paths.insert(paths.end(), a.segments.begin(), a.segments.end());
  std::vector<allan::Record> records;
  for (const auto& path : paths) {
    CurveArguments next = a.curve;
    next.log.path = path;
    std::vector<allan::Record> read;
    if (a.gap_s) {
      read = read_cut_record(next, *a.gap_s, a.common);
    } else {
      read.push_back(read_record(next, a.common));
    }
    std::ranges::move(read, std::back_inserter(records));
    check_alike(records.front(), records.back());
  }
  for (auto& record : records) record.rate_hz = records.front().rate_hz;
  return records;
}

report::LogResult describe_segments(const std::vector<allan::Record>& records, const AllanArguments& a) {
  report::LogResult result = describe_record(records.front(), a.common);
  if (records.size() == 1) return result;
  result.samples = result.missing_samples = 0;
  for (const allan::Record& record : records) {
    if (&record != &records.front()) result.notes.insert(result.notes.end(), record.notes.begin(), record.notes.end());
    result.samples += record.samples;
    result.missing_samples += record.missing_samples;
    result.segments.push_back(
        {record.source, record.first_row, record.start_s, record.samples, record.missing_samples});
  }
  for (const auto& path : a.segments) result.source += ", " + path;
  result.notes.push_back(fmt::format(
      "{} {} are pooled: at each tau their variances are weighted by degrees of freedom, which add; no term reaches from one into another",
      records.size(), a.gap_s ? "segments" : "logs"));
  return result;
}

double pooled_mean(const std::vector<std::unique_ptr<allan::Series>>& segments) {
  double sum = 0, count = 0;
  for (const auto& s : segments) {
    const double existing = static_cast<double>(s->samples() - (s->mask() ? s->mask()->missing() : 0));
    if (existing == 0) continue;
    sum += existing * s->mean();
    count += existing;
  }
  return sum / count;
}

// --- Other views ----------------------------------------------------------------------------------------------------------

report::SpectrumResult spectrum_of(const allan::Series& rates, AllanArguments::Psd method) {
  const bool welch = method == AllanArguments::Psd::welch;
  const allan::Spectrum whole =
      welch ? allan::welch(rates.rate(), rates.dt()) : allan::multitaper(rates.rate(), rates.dt());
  const allan::Spectrum spectrum = allan::log_binned(whole);
  report::SpectrumResult result{welch ? "welch" : "multitaper", whole.bandwidth, {}};
  for (std::size_t i = 0; i < spectrum.frequency.size(); ++i) {
    if (!(spectrum.dof[i] > 0)) continue;
    const allan::Interval interval = spectrum.interval(i);
    result.points.push_back({spectrum.frequency[i], std::sqrt(spectrum.density[i]), std::sqrt(interval.lower),
                             std::sqrt(interval.upper), spectrum.dof[i]});
  }
  return result;
}

report::SurfaceResult surface_of(const allan::Series& rates, double window_s) {
  const auto window = static_cast<std::int64_t>(std::llround(window_s / rates.dt()));
  constexpr std::int64_t kLeast = 32, kMostWindows = 400;
  if (window < kLeast || window > rates.samples()) {
    throw std::invalid_argument(
        fmt::format("--dynamic: a window of {} samples; there must be from {} to the {} of the record", window, kLeast,
                    rates.samples()));
  }
  const std::int64_t hop = std::max(window / 4, (rates.samples() - window) / kMostWindows + 1);
  const allan::DynamicSurface surface =
      allan::dynamic_variance(rates, allan::octave_factors(window), {.window = window, .hop = hop});
  report::SurfaceResult result{static_cast<double>(window) * rates.dt(), surface.time, {}, {}};
  for (std::size_t i = 0; i < surface.factors.size(); ++i) result.tau_s.push_back(surface.tau(i));
  for (Eigen::Index row = 0; row < surface.variance.rows(); ++row) {
    auto& deviation = result.deviation.emplace_back();
    for (Eigen::Index i = 0; i < surface.variance.cols(); ++i) deviation.push_back(std::sqrt(surface.variance(row, i)));
  }
  return result;
}

// --- An axis ------------------------------------------------------------------------------------------------------------

/// The curves of one column, one for each estimator.
void add_axis(report::LogResult& result, std::size_t column, const std::vector<allan::Record>& records,
              const AllanArguments& a) {
  std::vector<std::unique_ptr<allan::Series>> rates;
  std::int64_t longest = 0;
  for (const auto& record : records) {
    rates.emplace_back(new allan::Series(rate_record(record.axes[column], record, a.curve)));
    longest = std::max(longest, record.samples);
  }
  const allan::Axis& axis = records.front().axes[column];
  for (const Estimator estimator : a.estimators) {
    const auto factors = factors_for(a.curve, estimator, longest);
    std::vector<Measured> measured;
    for (const auto& r : rates) measured.push_back(measure(*r, estimator, factors, a));
    report::AxisResult& out = result.axes.emplace_back();
    out.name = axis.name;
    out.signal = axis.signal;
    out.estimator = estimator;
    out.mean = pooled_mean(rates);
    out.points = measured.size() == 1 ? allan::deviation_points(measured.front().curve, measured.front().noises)
                                      : pooled(measured);
  }
  report::AxisResult& first = result.axes[result.axes.size() - a.estimators.size()];
  const auto& most = **std::ranges::max_element(rates, {}, [](const auto& r) { return r->samples(); });
  if (a.psd) first.psd = spectrum_of(most, *a.psd);
  if (a.dynamic_s) first.dynamic = surface_of(most, *a.dynamic_s);
}

}  // namespace

int run(const AllanArguments& a) {
  if (a.stream) return run_stream(a);
  check_segments(a);
  for (const auto& path : a.segments)
    check_outputs(path, {{"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  check_outputs(a.curve.log.path, {{"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  const std::vector<allan::Record> records = read_segments(a);
  report::LogResult result = describe_segments(records, a);
  if (records.size() > 1 && (a.psd || a.dynamic_s))
    result.notes.emplace_back("spectrum and deviation over time are those of the longest segment");
  for (std::size_t i = 0; i < records.front().axes.size(); ++i) add_axis(result, i, records, a);
  print(a.common.json ? report::allan_json(result) : report::allan_table(result));
  write_pictures(result, a.pictures, a.common);
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli
