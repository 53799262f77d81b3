// SPDX-License-Identifier: MIT
#include "analysis.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace gyrobudget::inline v0::report {
namespace {

SpectrumResult spectrum_result(const allan::AnalysedSpectrum& analysed) {
  const allan::Spectrum& spectrum = analysed.spectrum;
  SpectrumResult result{
      analysed.method == allan::SpectrumMethod::welch ? "welch" : "multitaper", spectrum.bandwidth, {}};
  for (std::size_t i = 0; i < spectrum.frequency.size(); ++i) {
    if (!(spectrum.dof[i] > 0)) continue;
    const allan::Interval interval = spectrum.interval(i);
    result.points.push_back({spectrum.frequency[i], std::sqrt(spectrum.density[i]), std::sqrt(interval.lower),
                             std::sqrt(interval.upper), spectrum.dof[i]});
  }
  return result;
}

SurfaceResult surface_result(const allan::DynamicSurface& surface) {
  SurfaceResult result{static_cast<double>(surface.window) * surface.dt, surface.time, {}, {}};
  for (std::size_t i = 0; i < surface.factors.size(); ++i) result.tau_s.push_back(surface.tau(i));
  for (Eigen::Index row = 0; row < surface.variance.rows(); ++row) {
    auto& deviation = result.deviation.emplace_back();
    for (Eigen::Index i = 0; i < surface.variance.cols(); ++i) deviation.push_back(std::sqrt(surface.variance(row, i)));
  }
  return result;
}

// One for each curve.
void add_axis(LogResult& result, const allan::AxisAnalysis& axis) {
  const std::size_t first = result.axes.size();
  for (const allan::AnalysedCurve& curve : axis.curves) {
    AxisResult& out = result.axes.emplace_back();
    out.name = axis.axis.name;
    out.signal = axis.axis.signal;
    out.estimator = curve.estimator;
    out.mean = axis.mean;
    out.points = curve.points;
  }
  if (axis.spectrum) result.axes.at(first).psd = spectrum_result(*axis.spectrum);
  if (axis.surface) result.axes.at(first).dynamic = surface_result(*axis.surface);
}

void describe_segments(LogResult& result, std::span<const allan::Record> segments, Pooled what) {
  result.samples = result.missing_samples = 0;
  const std::string* source = &segments.front().source;
  for (const allan::Record& record : segments) {
    if (&record != &segments.front()) result.notes.insert(result.notes.end(), record.notes.begin(), record.notes.end());
    if (record.source != *source) result.source += ", " + record.source;
    source = &record.source;
    result.samples += record.samples;
    result.missing_samples += record.missing_samples;
    result.segments.push_back(
        {record.source, record.first_row, record.start_s, record.samples, record.missing_samples});
  }
  result.notes.push_back(fmt::format(
      "{} {} are pooled: at each tau their variances are weighted by degrees of freedom, which add; no term reaches from one into another",
      segments.size(), what == Pooled::segments ? "segments" : "logs"));
}

}  // namespace

LogResult log_result(std::span<const allan::Record> segments, const allan::Analysis& analysis, std::string command,
                     Pooled what) {
  const allan::Record& record = segments.front();
  LogResult result{.source = record.source,
                   .command = std::move(command),
                   .rate_hz = record.rate_hz,
                   .samples = record.samples,
                   .missing_samples = record.missing_samples,
                   .notes = record.notes};
  if (segments.size() > 1) describe_segments(result, segments, what);
  bool one_segment = false;
  for (const allan::AxisAnalysis& axis : analysis.axes) {
    add_axis(result, axis);
    one_segment = one_segment || axis.spectrum || axis.surface;
  }
  if (segments.size() > 1 && one_segment)
    result.notes.emplace_back("spectrum and deviation over time are those of the longest segment");
  return result;
}

std::string stream_note(std::int64_t overlap) {
  return fmt::format(
      "read as a stream: octaves only, terms begin every m/{0} samples above m = {0}; that costs white noise {1:.2g} % of the degrees of freedom, flicker and random walk less, quantization more; they stand in the table",
      overlap, 100 * allan::white_noise_loss(overlap));
}

}  // namespace gyrobudget::inline v0::report
