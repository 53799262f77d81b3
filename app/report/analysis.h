// SPDX-License-Identifier: MIT
// What allan::analyse found, as the value that tables, JSON, plots and the page are made of.
#pragma once

#include "gyrobudget/allan/analysis.h"

#include <cstdint>
#include <span>
#include <string>

#include "result.h"

namespace gyrobudget::inline v0::report {

/// What was pooled into one curve, by its name.
enum class Pooled { logs, segments };

/// The result of one record, or of several that were pooled: their source, length and notes, and one AxisResult for
/// each curve, of which the first of a column has the spectrum and the deviation over time.
/// @param segments at least one; of a stream, whose samples are gone, what is known besides.
[[nodiscard]] LogResult log_result(std::span<const allan::Record> segments, const allan::Analysis&, std::string command,
                                   Pooled what = Pooled::logs);

/// What reading as a stream costs, in words.
[[nodiscard]] std::string stream_note(std::int64_t overlap);

}  // namespace gyrobudget::inline v0::report
