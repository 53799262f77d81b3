// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/noise/process.h"

#include <optional>
#include <vector>

namespace gyrobudget::inline v0::calibration {

/// How long a record must be to know a coefficient.
struct LongerRecord {
  noise::Term term = noise::Term::flicker;
  double relative_std = 0;  ///< here
  bool identified = false;  ///< here; else the value that `needed_s` is for may be 0
  double duration_s = 0;    ///< of this record [s]
  double needed_s = 0;      ///< for a relative standard deviation of kWantedAccuracy [s]; infinite: no length does
};
inline constexpr double kWantedAccuracy = 0.10;

/// An averaging time from which the terms describe the curve, where they do not from the first one fitted.
struct LaterStart {
  double tau_min_s = 0;  ///< [s]
  double p_value = 0;    ///< of the fit from there
};

/// What is to be known or done beside the numbers of an axis. Reports find the words for it.
struct Facts {
  bool all_equal = false;            ///< every sample is equal: there is no noise to measure
  bool no_answer = false;            ///< none of N, B, K and G is identified
  bool only_quantization = false;    ///< so, and quantization is
  bool untested = false;             ///< too short to test whether the model describes the record
  bool misfit = false;               ///< the model does not describe it
  bool walk_unresolved = false;      ///< rate random walk was fitted and is not seen: it may show in a longer record
  std::vector<LongerRecord> longer;  ///< by the Cramer-Rao bound; only what this record is too short for
  std::optional<LaterStart> later;   ///< of a record that is not described and holds nothing found beside noise
};

/// @param fit      of the axis
/// @param octaves  the curve that was fitted
/// Throws nothing of its own.
[[nodiscard]] Facts facts_of(const fit::Result& fit, const allan::Curve& octaves);

/// True where none of N, B, K and G is identified: the samples are all equal, or there is nothing but quantization.
[[nodiscard]] bool holds_no_answer(const fit::Result& fit);

}  // namespace gyrobudget::inline v0::calibration
