// SPDX-License-Identifier: MIT
// The job of a datasheet: from a record of a sensor at rest to its noise coefficients, with intervals and verdicts.
//
//     const calibration::Datasheet sheet = calibration::calibrate(log::read_log({.path = "imu.csv", .unit = "deg/s"}));
//     for (const calibration::AxisDatasheet& axis : sheet.axes) {
//       const fit::Coefficient& n = axis.fit[noise::Term::white];
//       if (axis.has_answer() && n.status == fit::Status::identified) use(n.value, n.lower, n.upper);
//     }
//
// What the program prints for `gyrobudget calibrate` are these numbers.
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/allan/deviation_table.h"
#include "gyrobudget/allan/form.h"
#include "gyrobudget/allan/points.h"
#include "gyrobudget/allan/record.h"
#include "gyrobudget/allan/series.h"
#include "gyrobudget/allan/taus.h"
#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/estimation/fit/selection.h"
#include "gyrobudget/estimation/fit/whittle.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "facts.h"
#include "findings.h"
#include "temperature.h"

namespace gyrobudget::inline v0::calibration {

/// The fewest samples of a record: four octaves, so that three terms leave one averaging time to test them with.
inline constexpr std::int64_t kFewestSamples = 16;
/// Samples of a record may be so large, and vary by so little [SI]: the squares of others leave double.
inline constexpr double kLargestSample = 1e120, kSmallestVariation = 1e-120;

struct Options {
  /// Unset: N, B and K, and Q where the first averaging time shows white angle noise.
  std::optional<std::vector<noise::Term>> terms;
  bool choose_terms = false;  ///< let likelihood ratios choose the terms (fit/selection.h) in place of `terms`
  fit::Method method = fit::Method::gls;
  std::optional<double> tau_min_s;                      ///< shortest averaging time that is fitted [s]; unset: found
  std::optional<double> tau_max_s;                      ///< longest [s]; unset: found
  std::optional<double> correlation_time_s;             ///< of the Gauss-Markov term, held [s]; unset: fitted
  std::optional<double> frequency_hz;                   ///< of the sinusoid, held [Hz]; unset: fitted
  bool cross_check = false;                             ///< fit the likelihood of the record beside its curve
  std::optional<noise::FrontEnd> front_end;             ///< the low pass in front of the samples, where it is known
  std::optional<noise::FrontEnd::Kind> front_end_kind;  ///< where that alone is
  bool find_front_end = true;                           ///< false: where neither is given there is none
  bool temperature = true;  ///< take off what depends on the record's temperature, where it has one
  Masking mask;
  /// Of the curve that is shown, and read by the methods that read; the fit has octaves.
  allan::Taus taus{.kind = allan::Taus::Kind::logarithmic, .count = 50};
  allan::Form form = allan::Form::full;
  /// Part of a cluster's samples that must exist for it to count, in (0, 1]. Where outliers are masked it is 0.8,
  /// unless it is 1: they can be as many as clusters may miss.
  double minimum_fill = allan::kMinimumFill;
};

/// The likelihood of the record beside the fit of its curve.
struct CrossChecked {
  fit::Result likelihood;
  fit::CrossCheck check;
};

/// How the terms of a fit were chosen, where that was left to the record.
struct Chosen {
  fit::Selection selection;
  std::optional<fit::Result> alternative_fit;  ///< with the terms of `selection.alternative`
};

/// A record that no datasheet can be made of, whatever its noise: too short, with too many gaps, or of a scale whose
/// squares leave double; or records that are not of one sensor type. The message names the record or the axis, what was
/// found and what was expected.
struct Unusable : std::runtime_error {
  enum class Reason { too_short, too_few_taus, out_of_scale, between_samples, other_axes, other_rate };
  Unusable(Reason why, const std::string& message) : std::runtime_error(message), reason(why) {}
  Reason reason;
};

/// What is done for one axis, in this order. `curve` and `fit` make the result, the others add to it.
enum class Stage {
  screening,    ///< the search for what the record holds beside noise
  curve,        ///< the Allan curve, and whether its squares stay inside double
  choice,       ///< of the terms, where Options::choose_terms
  fit,          ///< of the coefficients
  departure,    ///< the search for a warm-up, a drift or a step beside the fitted noise
  temperature,  ///< where the record has one and Options::temperature; what follows is then done again without it
  lines,        ///< the search for spectral lines and humps
  intervals,    ///< of the curve that is shown
  cross_check,  ///< where Options::cross_check
  facts,        ///< what is to be known or done beside the numbers
};

/// A stage of one axis that ended in an error. What it makes is missing; all other stages and axes stand.
struct Fault {
  Stage stage = Stage::fit;
  std::string what;                        ///< the error's own words
  std::optional<Unusable::Reason> reason;  ///< where the record cannot be used; else the stage itself failed
};

/// The datasheet of one axis. All values in SI.
struct AxisDatasheet {
  std::string name;
  noise::Signal signal = noise::Signal::angular_rate;
  double mean = 0;                            ///< of the samples used; not a number for a table of deviations
  std::vector<allan::DeviationPoint> points;  ///< the curve with 95 % intervals
  allan::Curve octaves;                       ///< that was fitted
  fit::Result fit;                            ///< coefficients with 95 % intervals, and the verdict on the model
  std::optional<Chosen> chosen;               ///< where Options::choose_terms
  std::optional<CrossChecked> cross_checked;  ///< where Options::cross_check
  std::optional<Findings> findings;           ///< of a record; a table of deviations has none
  std::optional<Temperature> temperature;     ///< where the record has one that ranges over kLeastRange
  Facts facts;
  std::vector<Fault> faults;  ///< in the order of the stages; empty for almost every record

  /// Coefficients were fitted, however well: false where the stage `curve` or `fit` ended in a fault.
  [[nodiscard]] bool is_fitted() const { return !fit.coefficients.empty(); }
  /// A converged fit whose verdict is not "not described" (methods that only read the curve have none), with at least
  /// one of N, B, K and G identified: the others may be upper bounds. What was found beside noise and not masked is not
  /// in it: is_spoilt() says that.
  [[nodiscard]] bool has_answer() const;
  /// The fit took for noise what is none: its numbers are not yet those of the sensor.
  [[nodiscard]] bool is_spoilt() const { return findings && findings->spoil(); }
  /// No cross-check was asked for, or it agrees.
  [[nodiscard]] bool is_confirmed() const { return !cross_checked || cross_checked->check.agrees; }
};

struct Datasheet {
  std::string source;                ///< of the record
  double rate_hz = 0;                ///< [Hz]
  std::int64_t samples = 0;          ///< missing ones included
  std::int64_t missing_samples = 0;  ///< at which any axis has no number
  std::vector<AxisDatasheet> axes;   ///< in the order of the record's

  /// Every axis has an answer that may be used: not spoilt, no cross-check contradicts it, and no stage ended in a
  /// fault.
  [[nodiscard]] bool is_complete() const;
};

/// A record to its datasheet, axis by axis.
///
/// 1. Rows that repeat are left out: what follows is of the sensor's own readings (Held). Rounding, saturation, rows of
///    several sensors by turns, outliers, motion and steps of the mean are looked for; outliers, motion and steps are
///    left out where Options::mask asks for it.
/// 2. The overlapped Allan deviation is made at octaves and at Options::taus, and its noise identified at each tau.
/// 3. The terms are those asked for, those that likelihood ratios choose, or N, B, K (and Q where it is seen).
/// 4. They are fitted (fit/fit.h states the model, the intervals and their coverage). Chosen terms that do not describe
///    the shortest taus are chosen once more without these.
/// 5. A warm-up, a drift or a step beside the fitted noise is looked for, and where the mask leaves one out, 2 to 4 are
///    done again. Spectral lines that the fit does not hold, and humps, are looked for.
/// Where the record has a temperature, what depends on it is taken off first (temperature.h) if it is seen: 1 to 5 are
/// then of what is left, and Temperature::before has the fit without that. 6. The likelihood is fitted beside the curve
/// where Options::cross_check.
///
/// Axes do not touch each other, and what adds to a result cannot take it away: an error in one stage of one axis is an
/// AxisDatasheet::faults of it. Where the terms could not be chosen, the default ones are fitted.
///
/// What the record cannot answer is a verdict or a status in the result: AxisDatasheet::has_answer. The same result to
/// the bit for any number of threads. Time: about 0.2 s an axis of 3.6 million samples on one core of a 2020s
/// processor, and 2.2 s more where terms are chosen; memory 16 bytes a sample and axis beside the record.
///
/// @param record   all axes of one length; missing samples are NaN
/// @param options  what to fit, and how
/// @throws Unusable as above where it is so for every axis; std::invalid_argument for options out of range (as fit::fit
/// has it), a rate that is not positive and finite, and axes of different lengths. Where no axis could be fitted, the
/// error of the first is thrown.
[[nodiscard]] Datasheet calibrate(const allan::Record& record, const Options& options = {});

/// A table of deviations, as papers and other tools give them, to a datasheet. They are taken as fully overlapped ones
/// of a record of `samples` samples at `rate_hz` without gaps; the fit has those about an octave apart, as a denser
/// grid makes the covariance singular. Options::mask, cross_check and choose_terms need a record and do nothing here.
/// @param table    deviations of each axis at ascending averaging times
/// @param rate_hz  of the record behind it [Hz]
/// @param samples  its length
/// @throws Unusable where too few averaging times lie within the record to fit the terms, and for an averaging time
/// that is not a whole number of samples at this rate (to 1 %); std::invalid_argument as above.
[[nodiscard]] Datasheet calibrate(const allan::DeviationTable& table, double rate_hz, std::int64_t samples,
                                  const Options& options = {});

}  // namespace gyrobudget::inline v0::calibration
