// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/report/result.h"

#include <vector>

#include "arguments.h"

// Reading logs and writing pictures: what allan and calibrate share.
namespace gyrobudget::inline v0::cli {

/// Reads the log and says its notes on stderr.
[[nodiscard]] allan::Record read_record(const CurveArguments&, const Common&);

/// The same, cut where more than `longest_gap_s` is missing.
[[nodiscard]] std::vector<allan::Record> read_cut_record(const CurveArguments&, double longest_gap_s, const Common&);

/// Writes --report and --plot.
void write_pictures(const report::LogResult&, const Pictures&, const Common&);

}  // namespace gyrobudget::inline v0::cli
