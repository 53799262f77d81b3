// SPDX-License-Identifier: MIT
// What a record holds beside noise.
#pragma once

#include "gyrobudget/allan/departure.h"
#include "gyrobudget/allan/lines.h"
#include "gyrobudget/allan/outliers.h"
#include "gyrobudget/allan/steps.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace gyrobudget::inline v0::calibration {

/// What is left out of a record before it is fitted, where it is found.
struct Masking {
  bool outliers = false;  ///< samples that were knocked; a cluster then counts with 80 % of its samples
  bool steps = false;     ///< all but the longest part without a step of the mean
  bool warm_up = false;   ///< the first five time constants of a warm-up
};

/// What an axis holds beside noise: found by the searches of allan/outliers.h, steps.h, departure.h and lines.h, whose
/// headers state how often noise alone shows any. Indices count samples of the whole record.
struct Findings {
  std::vector<allan::Outlier> outliers;
  std::vector<allan::Step> steps;
  std::optional<allan::Departure> departure;  ///< slow, beside the noise that was fitted: a warm-up or a drift
  std::vector<allan::SpectralLine> lines;     ///< that the fit does not hold, strongest first
  bool outliers_masked = false;               ///< left out of curve and fit
  bool steps_masked = false;                  ///< the longest part without a step is used
  bool warm_up_masked = false;                ///< its first five time constants are left out
  std::int64_t first = 0;                     ///< of the samples that the curve and the fit are of
  std::int64_t samples = 0;                   ///< number of those

  /// True where something was found.
  [[nodiscard]] bool any() const { return !outliers.empty() || !steps.empty() || departure || !lines.empty(); }

  // What the fit took for noise, so that its numbers are not those of the sensor. Outliers spoil them where they make
  // up more than a hundredth of the variance: a few small ones in a long record spoil nothing.
  [[nodiscard]] bool outliers_spoil() const;
  [[nodiscard]] bool steps_spoil() const { return !steps.empty() && !steps_masked; }
  [[nodiscard]] bool departure_spoils() const { return departure && !warm_up_masked; }
  [[nodiscard]] bool spoil() const { return outliers_spoil() || steps_spoil() || departure_spoils(); }
};

}  // namespace gyrobudget::inline v0::calibration
