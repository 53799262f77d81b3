// SPDX-License-Identifier: MIT
#include "analysis.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <utility>

#include "factors.h"
#include "family.h"
#include "statistics.h"

namespace gyrobudget::inline v0::allan {
namespace {

// The curve of one segment, with what its noise was found to be at each tau.
struct Measured {
  Curve curve;
  std::vector<Identified> noises;
};

Measured measure(const Series& rates, Estimator estimator, const std::vector<std::int64_t>& factors,
                 const AnalysisOptions& o) {
  std::vector<std::int64_t> usable;  // a segment may be shorter than the one that the factors are made for
  std::ranges::copy_if(factors, std::back_inserter(usable),
                       [&](auto m) { return has_terms(estimator, rates.samples(), m); });
  Curve curve = deviation(rates, estimator, usable, {.overlap = o.overlap, .form = o.form});
  auto noises = identify_noise(rates, curve);
  return {std::move(curve), std::move(noises)};
}

// --- Several segments into one curve --------------------------------------------------------------------------------

// Of the segments' points at this tau, the one that knows most.
DeviationPoint best_at(double tau, const std::vector<std::vector<DeviationPoint>>& segments) {
  DeviationPoint best;
  for (const auto& points : segments) {
    for (const DeviationPoint& p : points) {
      if (p.tau_s == tau && p.edf > best.edf) best = p;
    }
  }
  return best;
}

std::vector<DeviationPoint> pooled(const std::vector<Measured>& segments) {
  std::vector<std::vector<PointStatistics>> known;
  std::vector<std::vector<DeviationPoint>> points;
  for (const Measured& s : segments) {
    known.push_back(statistics(s.curve, s.noises));
    points.push_back(deviation_points(s.curve, s.noises));
  }
  std::vector<Segment> list;
  for (std::size_t i = 0; i < segments.size(); ++i) list.push_back({&segments[i].curve, known[i]});
  std::vector<DeviationPoint> result;
  for (const PooledPoint& p : pool(list)) {
    DeviationPoint point = best_at(p.tau, points);
    point.deviation = std::sqrt(p.variance);
    point.lower = std::sqrt(p.interval.lower);
    point.upper = std::sqrt(p.interval.upper);
    point.edf = p.edf;
    point.terms = p.terms;
    result.push_back(point);
  }
  return result;
}

double pooled_mean(const std::deque<Series>& segments) {
  double sum = 0, count = 0;
  for (const Series& s : segments) {
    const double existing = static_cast<double>(s.samples() - (s.mask() ? s.mask()->missing() : 0));
    if (existing == 0) continue;
    sum += existing * s.mean();
    count += existing;
  }
  return sum / count;
}

// --- Other views ----------------------------------------------------------------------------------------------------

AnalysedSpectrum spectrum_of(const Series& rates, SpectrumMethod method) {
  const Spectrum fine =
      method == SpectrumMethod::welch ? welch(rates.rate(), rates.dt()) : multitaper(rates.rate(), rates.dt());
  return {method, log_binned(fine)};
}

DynamicSurface surface_of(const Series& rates, double window_s) {
  const auto window = static_cast<std::int64_t>(std::llround(window_s / rates.dt()));
  constexpr std::int64_t kLeast = 32, kMostWindows = 400;
  if (window < kLeast || window > rates.samples()) {
    throw WindowError(fmt::format("a window of {} samples; there must be from {} to the {} of the record", window,
                                  kLeast, rates.samples()));
  }
  const std::int64_t hop = std::max(window / 4, (rates.samples() - window) / kMostWindows + 1);
  return dynamic_variance(rates, octave_factors(window), {.window = window, .hop = hop});
}

// --- An axis --------------------------------------------------------------------------------------------------------

AxisAnalysis analyse_axis(std::size_t axis, std::span<const Record> segments, const AnalysisOptions& o) {
  const Axis& first = segments.front().axes[axis];
  std::deque<Series> rates;
  std::int64_t longest = 0;
  for (const Record& segment : segments) {
    rates.emplace_back(segment.axes[axis].rate, 1 / segments.front().rate_hz, o.minimum_fill);
    longest = std::max(longest, segment.samples);
  }
  AxisAnalysis result{.axis = {first.name, first.signal}, .mean = pooled_mean(rates)};
  for (const Estimator estimator : o.estimators) {
    const auto factors = factors_of(o.taus, estimator, longest);
    std::vector<Measured> measured;
    for (const Series& r : rates) measured.push_back(measure(r, estimator, factors, o));
    result.curves.push_back({estimator, measured.size() == 1
                                            ? deviation_points(measured.front().curve, measured.front().noises)
                                            : pooled(measured)});
  }
  const Series& most = *std::ranges::max_element(rates, {}, &Series::samples);
  if (o.spectrum) result.spectrum = spectrum_of(most, *o.spectrum);
  if (o.window_s) result.surface = surface_of(most, *o.window_s);
  return result;
}

}  // namespace

Match match(const Record& first, const Record& other) {
  const auto same = [](const Axis& a, const Axis& b) { return a.name == b.name && a.signal == b.signal; };
  if (!std::ranges::equal(first.axes, other.axes, same)) return Match::other_axes;
  constexpr double kSameRate = 1e-3;
  return std::abs(other.rate_hz / first.rate_hz - 1) <= kSameRate ? Match::alike : Match::other_rate;
}

Analysis analyse(const Record& record, const AnalysisOptions& options) {
  return analyse(std::span(&record, 1), options);
}

Analysis analyse(std::span<const Record> segments, const AnalysisOptions& options) {
  if (segments.empty()) throw std::invalid_argument("there is no record to analyse");
  for (const Record& segment : segments) {
    if (match(segments.front(), segment) == Match::alike) continue;
    throw std::invalid_argument(
        fmt::format("{} and {} differ in their axes or rates: they are not segments of one recording", segment.source,
                    segments.front().source));
  }
  Analysis analysis;
  for (std::size_t i = 0; i < segments.front().axes.size(); ++i) {
    analysis.axes.push_back(analyse_axis(i, segments, options));
  }
  return analysis;
}

StreamingAnalysis::StreamingAnalysis(std::vector<AxisLabel> axes, double rate_hz, const StreamingOptions& options)
    : axes_(std::move(axes)) {
  if (axes_.empty()) throw std::invalid_argument("a stream without axes has nothing to analyse");
  deviations_.assign(axes_.size(), StreamingDeviation(1 / rate_hz, options));
}

void StreamingAnalysis::push(std::span<const std::vector<double>> rates) {
  if (rates.size() != axes_.size()) {
    throw std::invalid_argument(fmt::format("samples of {} axes, expected those of {}", rates.size(), axes_.size()));
  }
  tbb::parallel_for(std::size_t{0}, rates.size(), [&](std::size_t i) { deviations_[i].push(rates[i]); });
}

Analysis StreamingAnalysis::analysis() const {
  Analysis analysis;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Curve curve = deviations_[i].curve();
    AxisAnalysis& axis = analysis.axes.emplace_back(AxisAnalysis{.axis = axes_[i], .mean = curve.mean});
    axis.curves.push_back({Estimator::oadev, deviation_points(curve, identify_noise(curve))});
  }
  return analysis;
}

}  // namespace gyrobudget::inline v0::allan
