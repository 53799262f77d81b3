// SPDX-License-Identifier: MIT
// Dates and times of day in a cell, as nanoseconds.
#pragma once

#include "gyrobudget/app/text/number.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

inline constexpr std::int64_t kDay = 86'400'000'000'000;    ///< [ns]
inline constexpr std::int64_t kWeek = 604'800'000'000'000;  ///< [ns]

/// How the cells of a clock are written.
enum class StampForm {
  number,       ///< so many units
  date_time,    ///< "2024-03-05T09:14:22.005Z", "2024/03/05 09:14:22,005 +01:00", "05-Mar-2024 09:14:22"
  date,         ///< "2024-03-05", "20240305", "5.3.2024", "05-Mar-2024": the midnight that it starts with
  time_of_day,  ///< "09:14:22.005", "9:14:22 PM", "14:22.5" (minutes and seconds)
};

/// The form of a cell that holds a date, a time of day or both; empty for numbers and all other text. A date like
/// 05/03/2024 is none: nothing tells the day from the month.
[[nodiscard]] std::optional<StampForm> calendar_form(std::string_view cell);

/// Nanoseconds since 1970, or since midnight for a time of day. Where a zone is told the instant is in UTC; where none
/// is, the clock is taken as it stands. No leap second is counted: 23:59:60 is the next midnight.
/// @param form  one of the calendar; a cell of another one is text
/// @return Cell::missing for an empty cell and the like, with kNoStamp; Cell::beyond for years before 1700 or after
/// 2260, which 64 bits do not hold.
[[nodiscard]] text::Cell parse_calendar(std::string_view cell, StampForm form, std::int64_t& ns);

/// "2025-08-28 17:30:39.749" for nanoseconds since 1970, cut to milliseconds.
[[nodiscard]] std::string calendar_text(std::int64_t ns);

}  // namespace gyrobudget::inline v0::log
