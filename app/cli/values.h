// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/estimator.h"
#include "gyrobudget/allan/taus.h"
#include "gyrobudget/estimation/calibration/findings.h"
#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/noise/recorder.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/noise/units.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"

// Words of the command line as values in SI. Each throws std::invalid_argument that names `option`, what was
// given and what it may be.
namespace gyrobudget::inline v0::cli {

/// "10 h" in SI, of that dimension.
[[nodiscard]] double quantity(const std::string& option, const std::string& text, const noise::Dimension&);
/// `value` where it is above 0 and finite.
[[nodiscard]] double positive(const std::string& option, double value, const std::string& text);
/// A time above 0 [s].
[[nodiscard]] double duration(const std::string& option, const std::string& text);
/// COLUMN=VALUE of --rows.
[[nodiscard]] log::RowsOf rows_of(const std::string& text);
/// COLUMN[=UNIT] of --time.
[[nodiscard]] log::TimeOf time_of(const std::string& text);
/// LOG[=UNIT] of --with.
[[nodiscard]] log::With with_of(const std::string& text);
/// "100", "100 Hz", "1 kHz" [Hz]
[[nodiscard]] double rate(const std::string& option, const std::string& text);
[[nodiscard]] std::uint64_t whole_number(const std::string& option, const std::string& text);
/// Of --seed.
[[nodiscard]] std::uint64_t seed(const std::string& text);

/// The parts between separators; one part, perhaps empty, where there is none.
[[nodiscard]] std::vector<std::string> split(const std::string& text, char separator);
/// "N,B,K" of --terms, by letter or by key.
[[nodiscard]] std::vector<noise::Term> terms(const std::string& text);
/// "N,G=120s,S=0.05Hz": G's correlation time and S's frequency may be given.
struct ShapedTerms {
  std::vector<noise::Term> terms;
  std::optional<double> correlation_time_s, frequency_hz;
};
[[nodiscard]] ShapedTerms shaped_terms(const std::string& text);
/// "first_order" or "first_order:25Hz" of --front-end.
struct GivenFrontEnd {
  noise::FrontEnd::Kind kind = noise::FrontEnd::Kind::first_order;
  std::optional<double> bandwidth;  ///< [Hz]
};
[[nodiscard]] GivenFrontEnd front_end(const std::string& text);
/// "second_order:3Hz,rounding:1,gaps:2%" of --front-end, of records that are simulated at a rate [Hz]. A moving average
/// has the whole number of samples next to its bandwidth.
[[nodiscard]] noise::Recorder recorder(const std::string& text, double rate_hz);
/// "outliers", "steps" ... of --mask.
[[nodiscard]] calibration::Masking masking(const std::vector<std::string>& names);
/// "B=10%" of --want.
[[nodiscard]] fit::PlanOptions::Wish wish(const std::string& text);
/// One of --methods.
[[nodiscard]] fit::Method method_named(const std::string& name);
/// "oadev,mdev" or "all" of --estimator, each once.
[[nodiscard]] std::vector<allan::Estimator> estimators(const std::string& text);
/// "octave", "decade", "all" or a number from 2 on of --taus.
[[nodiscard]] allan::Taus taus(const std::string& text);
/// "1", "m" or "m/16" of --stride: how many terms begin in a cluster; 0 for all.
[[nodiscard]] std::int64_t overlap(const std::string& text);
/// "crossrange < 10 m" of --limit.
[[nodiscard]] BudgetArguments::Limit limit(const std::string& text);
/// "9h", or "1000" samples, of --skip.
[[nodiscard]] std::uint64_t skipped_samples(const std::string& text, double rate_hz);

}  // namespace gyrobudget::inline v0::cli
