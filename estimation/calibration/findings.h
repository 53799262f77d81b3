// SPDX-License-Identifier: MIT
// What a record holds beside noise.
#pragma once

#include "gyrobudget/allan/departure.h"
#include "gyrobudget/allan/humps.h"
#include "gyrobudget/allan/lines.h"
#include "gyrobudget/allan/motion.h"
#include "gyrobudget/allan/outlier_tail.h"
#include "gyrobudget/allan/outliers.h"
#include "gyrobudget/allan/repeats.h"
#include "gyrobudget/allan/rounding.h"
#include "gyrobudget/allan/saturation.h"
#include "gyrobudget/allan/steps.h"
#include "gyrobudget/allan/turns.h"
#include "gyrobudget/estimation/fit/fit.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace gyrobudget::inline v0::calibration {

/// What is left out of a record before it is fitted, where it is found.
struct Masking {
  bool outliers = false;  ///< samples that were knocked; a cluster then counts with 80 % of its samples
  bool steps = false;     ///< all but the longest part without a step of the mean
  bool warm_up = false;   ///< the first five time constants of a warm-up
  bool motion = false;    ///< the times in which the sensor was moved
};

/// Rows that repeat, and what was made of them. They are always left out: curve and fit are of the sensor's own
/// readings, at its own rate. Whoever sums the rows of the log as they stand counts the readings unevenly where these
/// stand for unevenly many rows; white noise is then larger by `raised`, and the N of the datasheet, its interval and
/// the curve hold that.
struct Held : allan::Repeats {
  double rate_hz = 0;         ///< the sensor's own [Hz]
  std::int64_t readings = 0;  ///< their number, missing ones included
  double raised = 1;          ///< N of the log as it stands over that of the readings
};

/// What an axis holds beside noise: found by the searches of allan/outliers.h, steps.h, departure.h, lines.h, humps.h,
/// motion.h, repeats.h, rounding.h, saturation.h and turns.h, whose headers state how often noise alone shows any.
/// Indices and numbers count samples of the whole record; where its rows repeat, readings at Held::rate_hz.
struct Findings {
  std::optional<Held> held;
  std::optional<allan::Rounding> rounding;    ///< the record is written in steps that are seen
  std::vector<allan::Saturation> saturation;  ///< the lower end of the range first
  std::optional<allan::Turns> turns;          ///< the rows are of several sensors
  std::vector<allan::Outlier> outliers;
  std::optional<allan::OutlierTail> tail;  ///< of errors that the outliers belong to, where they are many
  std::vector<allan::Motion> motion;
  std::vector<allan::Step> steps;
  std::optional<allan::Departure> departure;  ///< slow, beside the noise that was fitted: a warm-up or a drift
  std::vector<allan::Hump> humps;             ///< of the spectrum, highest first
  std::vector<allan::SpectralLine> lines;     ///< that neither the fit nor a hump holds, strongest first
  bool outliers_masked = false;               ///< left out of curve and fit
  bool motion_masked = false;                 ///< left out of curve and fit
  bool steps_masked = false;                  ///< the longest part without a step is used
  bool warm_up_masked = false;                ///< its first five time constants are left out
  std::int64_t first = 0;                     ///< of the samples that the curve and the fit are of
  std::int64_t samples = 0;                   ///< number of those

  /// True where something was found. Rounding below the noise is nothing.
  [[nodiscard]] bool any() const;
  /// Share of the samples that are outliers.
  [[nodiscard]] double outlier_share() const;
  /// Outliers that are half a per cent of the samples or more, and lie in nearly every part of the record, are not
  /// knocks but the tail of the noise.
  [[nodiscard]] bool has_heavy_tail() const;
  /// What errors in single samples do to N [signal sqrt(s)] of samples every dt [s]. Where outliers are masked, those
  /// that hide in the noise are still in N^2, and some of the noise is not, by OutlierTail::left times sigma^2 dt.
  /// Where they are not, N has them in it, and the scatter of a sum of squares of kurtosis k: (k - 3)/(4 samples) more
  /// of its logarithm's variance than its interval has.
  [[nodiscard]] fit::WhiteShift shift_by_outliers(double white, double dt) const;
  /// Share of the samples that are at an end of the range.
  [[nodiscard]] double saturated_share() const;
  /// The step is above the noise: N and Q of this axis are no longer those of its noise, nor are the others where the
  /// mean does not pass over several steps.
  [[nodiscard]] bool rounded_above_noise() const { return rounding && rounding->is_above_noise(); }

  // What the fit took for noise, so that its numbers are not those of the sensor. Outliers spoil them where they make
  // up more than a hundredth of the variance: a few small ones in a long record spoil nothing. Saturation does where it
  // holds more than a thousandth of the samples.
  [[nodiscard]] bool outliers_spoil() const;
  [[nodiscard]] bool steps_spoil() const { return !steps.empty() && !steps_masked; }
  [[nodiscard]] bool departure_spoils() const { return departure && !warm_up_masked; }
  [[nodiscard]] bool saturation_spoils() const;
  /// No record of one sensor at rest: nothing describes it.
  [[nodiscard]] bool not_at_rest() const { return !motion.empty() && !motion_masked; }
  [[nodiscard]] bool not_of_one_sensor() const { return turns.has_value(); }
  [[nodiscard]] bool spoil() const;
};

}  // namespace gyrobudget::inline v0::calibration
