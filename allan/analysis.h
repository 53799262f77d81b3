// SPDX-License-Identifier: MIT
// From a record to what is quoted of it: deviations by one or several estimators with their intervals, spectrum, and
// the deviation over time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "dynamic.h"
#include "points.h"
#include "psd.h"
#include "record.h"
#include "streaming.h"
#include "taus.h"

namespace gyrobudget::inline v0::allan {

enum class SpectrumMethod { welch, multitaper };

struct AnalysisOptions {
  std::vector<Estimator> estimators{Estimator::oadev};
  Taus taus;                               ///< of each estimator, in its range
  std::int64_t overlap = 0;                ///< terms begin every m/overlap samples; 0: at every sample
  Form form = Form::full;                  ///< how many terms the oadev has
  double minimum_fill = kMinimumFill;      ///< part of a cluster's samples that must exist for it to count, in (0, 1]
  std::optional<SpectrumMethod> spectrum;  ///< wanted besides, by this method
  std::optional<double> window_s;          ///< the deviation over time, of windows this long [s], is wanted besides
};

/// The curve of an axis by one estimator, with its 95 % intervals; taus without a finite variance are not in it.
struct AnalysedCurve {
  Estimator estimator = Estimator::oadev;
  std::vector<DeviationPoint> points;  ///< ascending m
};

struct AnalysedSpectrum {
  SpectrumMethod method = SpectrumMethod::welch;
  Spectrum spectrum;  ///< 20 points a decade, of which those without degrees of freedom say nothing
};

struct AxisAnalysis {
  AxisLabel axis;
  double mean = 0;                    ///< of the samples that exist, in the unit of the signal
  std::vector<AnalysedCurve> curves;  ///< one for each estimator, in the order of the options
  std::optional<AnalysedSpectrum> spectrum;
  std::optional<DynamicSurface> surface;  ///< oadev at octaves
};

struct Analysis {
  std::vector<AxisAnalysis> axes;
};

/// The window of a deviation over time is not one that the record can have.
class WindowError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Analyses each axis of a record. The degrees of freedom of a curve are those of the noise that is identified at each
/// averaging time.
///
///     const auto record = allan::make_record({{"gyro_x", noise::Signal::angular_rate, samples}}, 100);
///     for (const auto& p : allan::analyse(record).axes.front().curves.front().points) use(p.tau_s, p.deviation);
///
/// Windows of the deviation over time start a quarter of a window apart, or further apart where there would be more
/// than 400.
/// @throws WindowError for windows shorter than 32 samples or longer than the record; std::invalid_argument for what
/// deviation(), Series and factors_of refuse.
[[nodiscard]] Analysis analyse(const Record& record, const AnalysisOptions& options = {});

/// The same of several stretches of one sensor (power-ups, pieces of a log, several logs) together: at each averaging
/// time their variances are pooled, weighted by their degrees of freedom, which add (see pool()). Averaging times are
/// those of the longest segment; spectrum and deviation over time are of the longest segment alone. All segments count
/// as having the first one's sample interval, from which theirs may differ as match() allows.
/// @throws std::invalid_argument besides where there is no segment, or one that does not match the first.
[[nodiscard]] Analysis analyse(std::span<const Record> segments, const AnalysisOptions& options = {});

/// Whether a record can be pooled with another: the same axes in the same order, and rates that agree within 0.1 %,
/// since clocks are read from time stamps.
enum class Match { alike, other_axes, other_rate };
[[nodiscard]] Match match(const Record& first, const Record& other);

/// The analysis of a stream without end, in constant memory: the oadev at octaves, see StreamingDeviation. The noise at
/// each averaging time is identified from the curve alone.
class StreamingAnalysis {
 public:
  /// @throws std::invalid_argument for a rate [Hz] that is not positive, no axis, and what StreamingDeviation refuses.
  StreamingAnalysis(std::vector<AxisLabel> axes, double rate_hz, const StreamingOptions& options = {});

  /// Takes in the next samples of each axis. @throws std::invalid_argument where there are not as many as axes.
  void push(std::span<const std::vector<double>> rates);

  [[nodiscard]] std::int64_t samples() const { return deviations_.front().samples(); }  ///< so far, missing included

  /// What is known so far; there is nothing to know before the second sample.
  [[nodiscard]] Analysis analysis() const;

 private:
  std::vector<AxisLabel> axes_;
  std::vector<StreamingDeviation> deviations_;
};

}  // namespace gyrobudget::inline v0::allan
