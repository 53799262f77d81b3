// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/identify.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/report/result.h"
#include "gyrobudget/estimation/fit/fit.h"

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "arguments.h"

// One axis from its curve to its fit: what calibrate does for a log and for a table.
namespace gyrobudget::inline v0::cli {

/// Display taus and the fit's octaves, made in one pass over the record.
struct Curves {
  allan::Curve display;
  allan::Curve octaves;
  std::vector<allan::Identified> identified;  ///< at each tau of `display`; empty for a table
};

[[nodiscard]] Curves curves_of(const allan::Series&, const CurveArguments&);

/// The covariance matrices depend on the record's length, its gaps and the terms, not on the data: axes share them.
class Covariances {
 public:
  using Shared = std::shared_ptr<const allan::CurveCovariance>;
  [[nodiscard]] Shared of(const allan::Curve&, const std::vector<noise::Term>&);

 private:
  struct Known {
    std::vector<noise::Term> terms;
    std::int64_t samples;
    std::shared_ptr<const allan::Mask> mask;
    Shared covariance;
  };
  std::mutex mutex_;
  std::vector<Known> known_;
};

/// The terms asked for; else N, B and K, and Q where lag-1 identification sees white angle noise at the first tau.
[[nodiscard]] std::vector<noise::Term> terms_for(const CalibrateArguments&, const std::vector<allan::Identified>&);

/// What choosing the terms saw, for the fit to begin from.
struct Seen {
  std::optional<double> correlation_time_s, frequency_hz;
  std::optional<double> tau_min_s;
};

/// Fits by the method asked for. `rate` is empty for a table.
/// @throws io::InputError where gaps, or a table of few taus, leave too little to fit.
[[nodiscard]] fit::Result fit_curves(const Curves&, std::span<const double> rate, const std::vector<noise::Term>&,
                                     const allan::Axis&, const CalibrateArguments&, Covariances&, const Seen& = {});

/// Everything calibrate tells of one axis of a log.
/// @throws io::InputError also for samples whose squares leave double.
[[nodiscard]] report::AxisResult calibrate_axis(const allan::Axis&, double rate_hz, const CalibrateArguments&,
                                                Covariances&);

}  // namespace gyrobudget::inline v0::cli
