// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/fit/fit.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::report {

/// A deviation with its interval, SI.
struct DeviationPoint {
  std::int64_t m = 1;
  double tau_s = 0;
  double deviation = 0;
  double lower = 0;  ///< 95 %
  double upper = 0;
  double edf = 0;
  std::int64_t terms = 0;
  int alpha = 0;  ///< identified power law S ~ f^alpha; the mix behind edf in `allan`
};

struct AxisResult {
  std::string name;
  noise::Signal signal = noise::Signal::angular_rate;
  double mean = 0;                     ///< SI
  std::vector<DeviationPoint> points;  ///< NaN deviations (no terms left) are not in it
  std::optional<fit::Result> fit;      ///< calibrate only
  std::vector<std::string> advice;     ///< plain words, one thing to know or do each
};

/// What `allan` and `calibrate` found: the one value that tables, JSON, plots and the page are made of.
struct LogResult {
  std::string source;   ///< name of the log
  std::string command;  ///< the command line, to repeat it
  double rate_hz = 0;
  std::int64_t samples = 0;
  std::int64_t missing_samples = 0;
  std::string estimator = "oadev";
  std::vector<std::string> notes;
  std::vector<AxisResult> axes;
};

}  // namespace gyrobudget::inline v0::report
