// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/estimator.h"
#include "gyrobudget/allan/points.h"
#include "gyrobudget/estimation/calibration/several.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::report {

/// A two-sided power spectral density, as its root: white noise reads N. SI units of the axis' signal per sqrt(Hz).
struct SpectrumResult {
  struct Point {
    double frequency_hz = 0;
    double amplitude = 0;
    double lower = 0;  ///< 95 %, chi-square with `dof`
    double upper = 0;  ///< 95 %
    double dof = 0;    ///< equivalent degrees of freedom
  };
  std::string method;       ///< "welch" or "multitaper"
  double bandwidth_hz = 0;  ///< points of the estimate this far apart are as good as independent
  std::vector<Point> points;
};

/// The overlapped Allan deviation of windows of a record.
struct SurfaceResult {
  double window_s = 0;
  std::vector<double> time_s;                  ///< middle of each window, from the start
  std::vector<double> tau_s;                   ///< octaves
  std::vector<std::vector<double>> deviation;  ///< [time][tau], SI; NaN where no term counts
};

/// One curve of one column of a log. Columns with several estimators have several, one behind the other.
struct AxisResult {
  std::string name;                                    ///< as the log has it: any bytes
  noise::Signal signal = noise::Signal::angular_rate;  ///< decides units and names
  allan::Estimator estimator = allan::Estimator::oadev;
  double mean = 0;                            ///< of the signal, SI
  std::vector<allan::DeviationPoint> points;  ///< ascending m; NaN deviations (no terms left) are not in it
  std::optional<fit::Result> fit;             ///< calibrate only
  std::optional<calibration::Chosen> chosen;  ///< where the terms were left to the record
  std::optional<calibration::CrossChecked> cross_checked;  ///< where asked for
  std::optional<calibration::Findings> findings;           ///< calibrate of a log only
  std::optional<calibration::Temperature> temperature;     ///< calibrate of a log with a temperature only
  std::optional<SpectrumResult> psd;                       ///< allan --psd, with the first curve of a column
  std::optional<SurfaceResult> dynamic;                    ///< allan --dynamic, likewise
  std::vector<calibration::Fault> faults;                  ///< stages that ended in an error; calibrate only
  std::vector<std::string> advice;                         ///< plain words, one thing to know or do each
};

/// A stretch of a log that was pooled with others into one curve.
struct SegmentResult {
  std::string source;          ///< path or name of its log
  std::int64_t first_row = 1;  ///< line (binary: row) of its first sample in that log, from 1
  double start_s = 0;          ///< of its first sample, since that of the log by its own clock
  std::int64_t samples = 0;    ///< missing ones included
  std::int64_t missing_samples = 0;
};

/// What `allan` and `calibrate` found: the one value that tables, JSON, plots and the page are made of.
struct LogResult {
  std::string source;        ///< path or name of the log
  std::string command;       ///< the command line, to repeat it
  double rate_hz = 0;        ///< above zero
  std::int64_t samples = 0;  ///< of the time grid, missing ones included
  std::int64_t missing_samples = 0;
  std::vector<std::string> notes;       ///< how the log was read
  std::vector<SegmentResult> segments;  ///< where the curves are pooled from several; else empty
  std::vector<AxisResult> axes;
  bool timing = false;  ///< run times stand in the JSON, which then differs from run to run
};

/// Several records of one sensor type (power-ups, units), each with its own datasheet, and what they say together.
struct RunsResult {
  std::string command;
  std::vector<LogResult> runs;                      ///< the same axes in the same order in each
  std::vector<calibration::CombinedAxis> combined;  ///< in that order
};

}  // namespace gyrobudget::inline v0::report
