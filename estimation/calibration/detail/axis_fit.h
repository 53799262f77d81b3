// SPDX-License-Identifier: MIT
// One axis from its curve to its fit, for a record and for a table of deviations.
#pragma once

#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/identify.h"
#include "gyrobudget/estimation/calibration/calibrate.h"

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stages.h"

namespace gyrobudget::inline v0::calibration::detail {

/// The taus that are shown and the fit's octaves, made in one pass over the record.
struct Curves {
  allan::Curve display;
  allan::Curve octaves;
  std::vector<allan::Identified> identified;  ///< at each tau of `display`; empty for a table
};

[[nodiscard]] Curves curves_of(const allan::Series& series, const Options& options);

/// The covariance matrices depend on the record's length, its gaps and the terms, not on the data: axes share them.
class Covariances {
 public:
  using Shared = std::shared_ptr<const allan::CurveCovariance>;
  [[nodiscard]] Shared of(const allan::Curve& curve, const std::vector<noise::Term>& terms);

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

/// Everything about one axis that is made again where a part of the record is masked.
struct Fitted {
  Curves curves;
  fit::Result fit;
  std::optional<Chosen> chosen;
};

/// What all axes of a record have in common.
struct Job {
  const Options& options;
  Observer observer = {};
  Covariances covariances = {};
};

/// Enters the stages `curve`, `choice` and `fit`. Where the choice ends in a fault the default terms are fitted.
/// @throws Unusable where gaps leave too few averaging times to fit.
[[nodiscard]] Fitted fit_axis(const allan::Series& series, const std::string& name, Job& job, Stages& stages);
/// Of curves without a record. @throws Unusable where they hold too few averaging times to fit.
[[nodiscard]] fit::Result fit_table(const Curves& curves, const std::string& name, Job& job);

/// The first averaging time from which the terms of a fit that is not described describe the curve after all: its own
/// fit from there has an answer and is described, and so is the one from the next octave. Beyond half of the octaves
/// that are tested nothing is looked for: the longest few fit anything.
/// @param rate  samples of the axis; empty for a table
[[nodiscard]] std::optional<LaterStart> later_start(const fit::Result& fit, const Curves& curves,
                                                    std::span<const double> rate, const std::string& name, Job& job);

}  // namespace gyrobudget::inline v0::calibration::detail
