// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "result.h"

// A LogResult as people and programs want it. All forms share their words (words.h) and their curves (curves.h).
// Numbers stand in datasheet units (deg/sqrt(h), deg/h, deg/h/sqrt(h); m/s/sqrt(h), ug, ug/sqrt(h)), the datasheets
// with SI beside them; values are one sigma, intervals 95 %. The same result gives the same bytes; how long it took
// stands in the JSON only with LogResult::timing.
namespace gyrobudget::inline v0::report {

/// The curve for the terminal: per axis a table of tau, deviation, its interval, degrees of freedom and number of
/// terms.
[[nodiscard]] std::string allan_table(const LogResult&);

/// The datasheet for the terminal: per axis the coefficients with intervals and status, the raw minimum and why it is
/// not B, the verdict and what follows, what was left out of the fit, and the advice. Several axes of one kind start
/// with a summary. UTF-8, no colours, no control characters but the line feed.
[[nodiscard]] std::string datasheet(const LogResult&);

/// The fields are described by schema/allan-1.schema.json, which is installed with the program.
/// A column has one entry in "axes" for each estimator asked for. The estimator's bias is divided out: its own variance
/// is "bias" times the square of "deviation". Amplitudes of a spectrum are roots of densities.
/// Doubles survive a round trip; what is not finite is null. Keys keep their order; the text ends in a newline.
[[nodiscard]] std::string allan_json(const LogResult&);

/// The fields are described by schema/calibration-1.schema.json, which is installed with the program. Of a parameter
/// that was fitted, value and lower are always numbers (0 allowed), and so is upper except where no limit was found (a
/// fit that never settles): then it is null. All three are null where nothing was fitted.
[[nodiscard]] std::string calibration_json(const LogResult&);

/// One HTML page that opens offline and fetches nothing: plots with hover and zoom, datasheet, residuals, verdicts,
/// advice, glossary. At most 300 points a curve. Names and notes of users are text, whatever they hold.
[[nodiscard]] std::string page(const LogResult&);

// Several records of one sensor type, each fitted by itself, and what they say together (fit::combine).

/// Per axis a line for each record and the combined coefficients: value, interval, spread between records, and the
/// interval for another record; then the advice of each record.
[[nodiscard]] std::string runs_datasheet(const RunsResult&);
/// The fields are described by schema/runs-1.schema.json, which is installed with the program; each run is what
/// calibration_json gives.
[[nodiscard]] std::string runs_json(const RunsResult&);
/// The page of all records, their curves over one another, headed by the combined coefficients.
[[nodiscard]] std::string runs_page(const RunsResult&);
/// The records as one result, axes named after their records, for a picture of them all.
[[nodiscard]] LogResult side_by_side(const RunsResult&);

/// Picture of the deviation curves by gnuplot (Debian: gnuplot-nox), one panel for each axis; the format follows from
/// the ending: .svg, .png or .pdf. The file appears whole or not at all.
/// @throws std::invalid_argument for another ending or a result without points, text::OutputError where gnuplot is
/// missing or fails, or the file cannot be written.
void write_plot(const LogResult&, const std::string& path);

}  // namespace gyrobudget::inline v0::report
