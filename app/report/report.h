// SPDX-License-Identifier: MIT
#pragma once

#include "result.h"

#include <string>

// A LogResult as people and programs want it. All forms share their words (words.h) and their curves (curves.h).
// Numbers stand in datasheet units (deg/sqrt(h), deg/h, deg/h/sqrt(h); m/s/sqrt(h), ug, ug/sqrt(h)), the datasheets
// with SI beside them; values are one sigma, intervals 95 %. The same result gives the same bytes, except for the
// `seconds` of a fit in its JSON.
namespace gyrobudget::inline v0::report {

/// The curve for the terminal: per axis a table of tau, deviation, its interval, degrees of freedom and number of terms.
[[nodiscard]] std::string allan_table(const LogResult&);

/// The datasheet for the terminal: per axis the coefficients with intervals and status, the raw minimum and why it is
/// not B, the verdict and what follows, what was left out of the fit, and the advice. Several axes of one kind start
/// with a summary. UTF-8, no colours, no control characters but the line feed.
[[nodiscard]] std::string datasheet(const LogResult&);

/// Schema gyrobudget.allan/1: {"schema","version","command","source","record":{"samples","rate_hz","duration_s",
/// "missing_samples"},"estimator","notes","axes":[{"name","estimator","signal","unit","si_unit","si_per_unit","mean",
/// "mean_unit","points":[{"tau_s","m","deviation","lower","upper","edf","terms","alpha","stride","bias"}]}]}.
/// With a spectrum an axis has "psd":{"method","sides":"two-sided","unit","si_unit","si_per_unit","bandwidth_hz",
/// "points":[{"frequency_hz","amplitude","lower","upper","dof"}]}, roots of densities; with a surface
/// "dynamic":{"window_s","unit","si_unit","si_per_unit","time_s","tau_s","deviation"}, rows of the last being windows.
/// Where several segments are pooled, "record" is their sum and has "segments":[{"source","first_row","start_s",
/// "samples","duration_s","missing_samples"}].
/// A column has one entry in "axes" for each estimator asked for; "estimator" at the top is the first of them. The
/// estimator's bias is divided out: its own variance is "bias" times the square of "deviation".
/// Doubles survive a round trip; what is not finite is null. Keys keep this order; the text ends in a newline.
[[nodiscard]] std::string allan_json(const LogResult&);

/// Schema gyrobudget.calibration/1: the head of allan_json, and per axis "parameters" by key (arw, bias_instability,
/// rrw, quantization, rate_ramp; vrw and accel_rw for accelerometers), "minimum", "beta" (0 where N or K is 0), "fit"
/// and "advice". Of a parameter that was fitted, value and lower are always numbers (0 allowed), and so is upper but
/// where no limit was found (a fit that never settles): then it is null. All three are null where nothing was fitted.
/// `fit` is null without a fit.
[[nodiscard]] std::string calibration_json(const LogResult&);

/// One HTML page that opens offline and fetches nothing: plots with hover and zoom, datasheet, residuals, verdicts,
/// advice, glossary. At most 300 points a curve. Names and notes of users are text, whatever they hold.
[[nodiscard]] std::string page(const LogResult&);

// Several records of one sensor type, each fitted by itself, and what they say together (fit::combine).

/// Per axis a line for each record and the combined coefficients: value, interval, spread between records, and the
/// interval for another record; then the advice of each record.
[[nodiscard]] std::string runs_datasheet(const RunsResult&);
/// Schema gyrobudget.runs/1: {"schema","version","command","combined":[{"name","signal","left_out","parameters"}],
/// "runs":[calibration_json of each]}. A parameter has value, lower, upper, spread, next_lower and next_upper (95 % of
/// another record's; null below three), records, identified, q and p_value.
[[nodiscard]] std::string runs_json(const RunsResult&);
/// The page of all records, their curves over one another, headed by the combined coefficients.
[[nodiscard]] std::string runs_page(const RunsResult&);
/// The records as one result, axes named after their records, for a picture of them all.
[[nodiscard]] LogResult side_by_side(const RunsResult&);

/// Picture of the deviation curves by gnuplot (Debian: gnuplot-nox), one panel for each axis; the format follows from
/// the ending: .svg, .png or .pdf. The file appears whole or not at all.
/// @throws std::invalid_argument for another ending or a result without points, io::OutputError where gnuplot is
/// missing or fails, or the file cannot be written.
void write_plot(const LogResult&, const std::string& path);

}  // namespace gyrobudget::inline v0::report
