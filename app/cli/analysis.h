// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/allan/estimator.h"
#include "gyrobudget/allan/identify.h"
#include "gyrobudget/allan/taus.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/report/result.h"

#include <cstdint>
#include <span>
#include <vector>

#include "arguments.h"

// Log -> curve with its statistics: what allan and calibrate share.
namespace gyrobudget::inline v0::cli {

/// What --taus asks for.
[[nodiscard]] allan::Taus taus_of(const CurveArguments&);
/// The averaging factors that it stands for.
[[nodiscard]] std::vector<std::int64_t> factors_for(const CurveArguments&, std::int64_t samples);

/// The same for any estimator: in the range that it has terms for.
[[nodiscard]] std::vector<std::int64_t> factors_for(const CurveArguments&, allan::Estimator, std::int64_t samples);

/// Reads the log and says its notes on stderr.
[[nodiscard]] allan::Record read_record(const CurveArguments&, const Common&);

/// The same, cut where more than `longest_gap_s` is missing.
[[nodiscard]] std::vector<allan::Record> read_cut_record(const CurveArguments&, double longest_gap_s, const Common&);

/// What the result says of the record as a whole; axes still empty.
[[nodiscard]] report::LogResult describe_record(const allan::Record&, const Common&);

/// An axis made ready for its statistics.
[[nodiscard]] allan::Series rate_record(const allan::Axis&, const allan::Record&, const CurveArguments&);
[[nodiscard]] allan::Form form_of(const CurveArguments&);

/// Writes --report and --plot.
void write_pictures(const report::LogResult&, const Pictures&, const Common&);

}  // namespace gyrobudget::inline v0::cli
