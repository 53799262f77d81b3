// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/estimation/fit/judgement.h"

#include <string>
#include <string_view>
#include <vector>

#include "result.h"

// How results are put into words and digits: the terminal and the page say the same, in the same figures.
namespace gyrobudget::inline v0::report {

/// "12.35", "0.001700", "3.394e-06": `digits` significant digits, kept even where they are zeros; fixed notation from
/// 1e-4 to 1e6. "0" for zero, "-" for what is not a number, "infinite".
[[nodiscard]] std::string number(double value, int digits = 4);
/// An SI value in `unit`, with it; the unit "1" is not written.
[[nodiscard]] std::string in_unit(double si, std::string_view unit, int digits = 4);
/// "4.3 %" of a fraction, two significant digits; whole percents from 10 % on.
[[nodiscard]] std::string percent(double fraction);
/// "p = 0.94", "p = 2.1e-05", "p < 1e-300".
[[nodiscard]] std::string probability_text(double p_value);
/// "0.01 s", "61.4 s", "5243 s".
[[nodiscard]] std::string tau_text(double seconds);
using text::count_text;
using text::duration_text;
using text::printable;
/// "rad/sqrt(s)", "m/s^2", "1": the SI unit of a dimension.
[[nodiscard]] std::string si_unit(const noise::Dimension&);

/// Tdev and ttotdev: their unit is the signal's times s.
[[nodiscard]] bool is_time_deviation(allan::Estimator);
/// The unit in which an axis' deviations are quoted: deg/h, ug or 1; of a time deviation arcsec, m/s or s.
[[nodiscard]] std::string_view deviation_unit(const AxisResult&);
[[nodiscard]] noise::Dimension deviation_dimension(const AxisResult&);
/// The unit of the root of a power spectral density: deg/h/sqrt(Hz), ug/sqrt(Hz) or 1/sqrt(Hz).
[[nodiscard]] std::string_view spectrum_unit(noise::Signal);
/// "Allan deviation", "modified Allan deviation", "Theo1".
[[nodiscard]] std::string_view deviation_name(allan::Estimator);
/// The rate of the samples of an axis: that of the log, or the sensor's own where rows of the log repeat.
[[nodiscard]] double rate_of(const AxisResult&, double rate_hz);
/// The estimators of a result's curves, in their order.
[[nodiscard]] std::vector<allan::Estimator> estimators_of(const LogResult&);
/// The name of a curve, unique in its result: that of the column, and where there are several estimators theirs.
[[nodiscard]] std::string curve_name(const AxisResult&, const LogResult&);

/// A coefficient's numbers in one unit, all at the resolution its standard deviation deserves (two digits of it).
struct CoefficientText {
  std::string value;     ///< "0.70 ± 0.12"; "0"; "-" where not fitted
  std::string interval;  ///< "0.44 to 0.93"; "0 to 1.4"; "no limit" where the record sets none above; "-"
  std::string unit;
};
/// @param si_per_unit how many SI units one `unit` is.
[[nodiscard]] CoefficientText coefficient_text(const fit::Coefficient&, double si_per_unit, std::string unit);
[[nodiscard]] CoefficientText datasheet_text(noise::Signal, const fit::Coefficient&);
[[nodiscard]] CoefficientText si_text(noise::Signal, const fit::Coefficient&);

/// What G and S have beside their size: "correlation time" or "frequency", in s or Hz; empty for the other terms, and
/// where nothing was fitted.
struct ShapeText {
  std::string label, value, interval, unit;
};
[[nodiscard]] ShapeText shape_text(const fit::Coefficient&);

/// A combined coefficient, all in `unit`.
struct CombinedText {
  std::string value, interval, spread, next, unit;
  std::string agreement;  ///< "seen in 3 of 3; they agree (p = 0.4)"
};
[[nodiscard]] CombinedText combined_text(noise::Signal, const fit::Combined&);

/// Order in which people look for the terms: N, B, K, then Q and R, G and S.
[[nodiscard]] const std::vector<noise::Term>& reading_order();

/// The process of a fitted term with `value` for its coefficient, and its own correlation time or frequency.
[[nodiscard]] noise::Process process_of(const fit::Coefficient&, double value);
/// "N, B and K"
[[nodiscard]] std::string letters(const std::vector<noise::Term>&);

/// The last part of a path, for titles.
[[nodiscard]] std::string file_name(const std::string& path);
/// "identified", "upper bound: at most 0.0014 deg/h", "left out: not fitted".
[[nodiscard]] std::string status_text(noise::Signal, const fit::Coefficient&, const fit::Result&);

/// Part of the model's variance at one tau that a term accounts for.
struct Share {
  noise::Term term;
  double part = 0;
};
/// Shares at the averaging time nearest to tau; empty for a model without terms.
[[nodiscard]] std::vector<Share> variance_shares(const fit::Result&, double tau_s, double rate_hz);

/// A coefficient for a table of many: value and std, or the limit; "-" where it must not be quoted.
[[nodiscard]] std::string cell_text(const AxisResult&, noise::Term);

/// The bias over temperature, a line for each coefficient: name, value with its interval, unit.
struct TemperatureRow {
  std::string key, label, value, interval, unit;
  double unit_si = 1;  ///< how many SI units (with K and s) one is
  const calibration::TemperatureCoefficient* coefficient = nullptr;
};
[[nodiscard]] std::vector<TemperatureRow> temperature_rows(const AxisResult&);
/// What temperature explains, and what N, B and K are with and without it.
[[nodiscard]] std::string temperature_text(const AxisResult&);

// Sentences; every number with its unit, every verdict with what follows from it. Empty where there is nothing to say.
[[nodiscard]] std::string record_text(const LogResult&);
[[nodiscard]] std::string estimator_text(allan::Estimator);
[[nodiscard]] std::string verdict_headline(const fit::Result&);
[[nodiscard]] std::string verdict_text(const fit::Result&);
[[nodiscard]] std::string consequence_text(const fit::Result&);
/// The same, with what the record holds beside noise and what the likelihood says of the fit.
[[nodiscard]] std::string verdict_headline(const AxisResult&);
[[nodiscard]] std::string verdict_text(const AxisResult&);
[[nodiscard]] std::string consequence_text(const AxisResult&);
/// What the fit took for noise, in words: "outliers", "steps"; empty where its numbers may be used.
[[nodiscard]] std::vector<std::string> spoilt_by(const calibration::Findings&);
[[nodiscard]] std::string minimum_text(const AxisResult&, double rate_hz);
[[nodiscard]] std::string beta_text(const fit::Result&);
[[nodiscard]] std::string cut_text(const AxisResult&);
/// The low pass between the noise and the samples; empty where none is known.
[[nodiscard]] std::string front_end_text(const fit::Result&);
[[nodiscard]] std::string cross_check_text(const AxisResult&);
/// What --terms auto weighed, one candidate of one step each: "beside N: flicker adds 12.1 to ln L, needed 3.5: kept".
[[nodiscard]] std::vector<std::string> weighed_texts(const AxisResult&);
/// Which terms came out of that.
[[nodiscard]] std::string selection_text(const AxisResult&);
/// Two models that the record cannot tell apart, and what each would mean for whoever uses the sensor.
[[nodiscard]] std::string alternative_text(const AxisResult&);

}  // namespace gyrobudget::inline v0::report
