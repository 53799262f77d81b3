// SPDX-License-Identifier: MIT
#include "calendar.h"

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::int64_t kMinute = 60, kHour = 3600;  // [s]

/// What is left of a cell while it is read from its start.
class CalendarText {
 public:
  explicit CalendarText(std::string_view text) : text_(text) {}

  [[nodiscard]] bool at_end() const { return text_.empty(); }
  [[nodiscard]] char next() const { return text_.empty() ? '\0' : text_.front(); }
  bool take(char c) {
    if (next() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  bool take_one_of(std::string_view characters) {
    return !at_end() && characters.find(next()) != std::string_view::npos && take(next());
  }
  void skip_blanks() {
    while (take(' ') || take('\t')) {
    }
  }
  /// The number that `least` to `most` digits write; empty, and nothing is taken, where there are fewer.
  std::optional<std::int64_t> number(std::size_t least, std::size_t most) {
    std::int64_t value = 0;
    std::size_t digits = 0;
    for (; digits < std::min(most, text_.size()) && text::is_digit(text_[digits]); ++digits)
      value = 10 * value + (text_[digits] - '0');
    if (digits < least) return std::nullopt;
    text_.remove_prefix(digits);
    return value;
  }
  /// Digits behind a decimal mark, as nanoseconds; what is finer is rounded.
  std::int64_t nanoseconds() {
    constexpr int kPlaces = 9;
    std::int64_t value = 0;
    int places = 0;
    bool up = false;
    for (; text::is_digit(next()); text_.remove_prefix(1), ++places) {
      if (places < kPlaces) value = 10 * value + (next() - '0');
      if (places == kPlaces) up = next() >= '5';
    }
    for (; places < kPlaces; ++places) value *= 10;
    return value + (up ? 1 : 0);
  }
  /// One of the words, whether in capitals or not. @return its place, or -1
  int word(std::span<const std::string_view> words) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (text::lower(text_.substr(0, words[i].size())) != words[i]) continue;
      text_.remove_prefix(words[i].size());
      return static_cast<int>(i);
    }
    return -1;
  }

 private:
  std::string_view text_;
};

constexpr std::array<std::string_view, 12> kMonths{"jan", "feb", "mar", "apr", "may", "jun",
                                                   "jul", "aug", "sep", "oct", "nov", "dec"};

struct CalendarDate {
  std::int64_t year = 0, month = 0, day = 0;
};

/// YYYY-MM-DD and the like, YYYYMMDD, D.M.YYYY, DD-Mon-YYYY.
std::optional<CalendarDate> take_date(CalendarText& text) {
  CalendarText from = text;
  const auto year = from.number(4, 4);
  if (year) {
    if (from.take_one_of("-/.")) {
      const auto month = from.number(1, 2);
      if (!month || !from.take_one_of("-/.")) return std::nullopt;
      const auto day = from.number(1, 2);
      if (!day) return std::nullopt;
      return text = from, CalendarDate{*year, *month, *day};
    }
    const auto month = from.number(2, 2), day = from.number(2, 2);
    if (!month || !day || text::is_digit(from.next())) return std::nullopt;
    return text = from, CalendarDate{*year, *month, *day};
  }
  const auto day = from.number(1, 2);
  if (!day) return std::nullopt;
  std::optional<std::int64_t> month;
  if (from.take('.')) {
    month = from.number(1, 2);
    if (!month || !from.take('.')) return std::nullopt;
  } else if (from.take_one_of("- ")) {
    const int name = from.word(kMonths);
    if (name < 0 || !from.take_one_of("- ")) return std::nullopt;
    month = name + 1;
  }
  const auto last = from.number(4, 4);
  if (!month || !last) return std::nullopt;
  return text = from, CalendarDate{*last, *month, *day};
}

/// Seconds since 1970 of its midnight; empty for a day that no calendar has.
std::optional<std::int64_t> seconds_of(const CalendarDate& date) {
  using namespace std::chrono;
  const year_month_day day{year(static_cast<int>(date.year)), month(static_cast<unsigned>(date.month)),
                           std::chrono::day(static_cast<unsigned>(date.day))};
  if (!day.ok()) return std::nullopt;
  return std::int64_t{sys_days(day).time_since_epoch().count()} * 24 * kHour;
}

/// hh:mm:ss.fff, hhmmss behind a T, mm:ss.f. @return nanoseconds since midnight
std::optional<std::int64_t> take_time(CalendarText& text, bool behind_date) {
  CalendarText from = text;
  constexpr std::size_t kHourDigits = 5;  // a time that runs on counts more than 24
  const std::string_view marks = behind_date ? ":." : ":";
  auto first = from.number(1, behind_date ? 2 : kHourDigits);
  if (!first) return std::nullopt;
  std::optional<std::int64_t> second, third;
  if (from.take_one_of(marks)) {
    second = from.number(2, 2);
    if (second && from.take_one_of(marks)) third = from.number(1, 2);
  } else if (behind_date) {
    second = from.number(2, 2), third = from.number(2, 2);
  }
  if (!second) return std::nullopt;
  const bool fraction = from.take_one_of(".,");
  const std::int64_t fine = fraction ? from.nanoseconds() : 0;
  if (!third) {  // 14:22 may be hours or minutes; 14:22.5 is minutes and seconds
    if (!fraction && !behind_date) return std::nullopt;
    if (behind_date)
      third = 0;
    else
      third = std::exchange(second, std::exchange(first, 0));
  }
  constexpr std::int64_t kMostSeconds = 60;  // a leap second
  if (*second >= kMinute || *third > kMostSeconds || (behind_date && *first > 24)) return std::nullopt;
  constexpr std::array<std::string_view, 2> kHalves{"am", "pm"};
  CalendarText half = from;
  half.skip_blanks();
  if (const int name = half.word(kHalves); name >= 0 && *first >= 1 && *first <= 12) {
    first = *first % 12 + 12 * name;
    from = half;
  }
  text = from;
  return (*first * kHour + *second * kMinute + *third) * noise::kNanosecondsPerSecond + fine;
}

/// Z, UTC, +01:00, -0330, +01: seconds east of Greenwich. Empty for what is no zone; 0 where there is none.
std::optional<std::int64_t> take_zone(CalendarText& text) {
  text.skip_blanks();
  constexpr std::array<std::string_view, 3> kUniversal{"z", "utc", "gmt"};
  if (text.word(kUniversal) >= 0 || text.at_end()) return 0;
  const bool west = text.next() == '-';
  if (!text.take_one_of("+-")) return std::nullopt;
  const auto hours = text.number(2, 2);
  text.take(':');
  const auto minutes = text.at_end() ? 0 : text.number(2, 2);
  if (!hours || !minutes || *minutes >= kMinute) return std::nullopt;
  return (west ? -1 : 1) * (*hours * kHour + *minutes * kMinute);
}

struct CalendarStamp {
  StampForm form = StampForm::number;
  std::int64_t seconds = 0, nanoseconds = 0;
};

/// Where the year is out of 64 bits, seconds are all the same right.
std::optional<CalendarStamp> read_calendar(std::string_view cell) {
  if (cell.size() < 5 || !text::is_digit(cell.front())) return std::nullopt;
  CalendarText text(cell);
  CalendarStamp stamp;
  const auto date = take_date(text);
  if (date) {
    const auto midnight = seconds_of(*date);
    if (!midnight) return std::nullopt;
    stamp = {StampForm::date, *midnight, 0};
    if (text.at_end()) return stamp;
    if (!text.take_one_of("Tt _")) return std::nullopt;
    text.skip_blanks();
  }
  const auto time = take_time(text, date.has_value());
  if (!time) return std::nullopt;
  const auto zone = take_zone(text);
  if (!zone || !text.at_end()) return std::nullopt;
  stamp.form = date ? StampForm::date_time : StampForm::time_of_day;
  stamp.seconds += *time / noise::kNanosecondsPerSecond - *zone;
  stamp.nanoseconds = *time % noise::kNanosecondsPerSecond;
  return stamp;
}

std::string_view without_quotes(std::string_view cell) {
  cell = text::trim(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = text::trim(cell.substr(1, cell.size() - 2));
  return cell;
}

}  // namespace

std::optional<StampForm> calendar_form(std::string_view cell) {
  cell = without_quotes(cell);
  // "20240305" is a number first.
  if (std::ranges::all_of(cell, text::is_digit)) return std::nullopt;
  const auto stamp = read_calendar(cell);
  return stamp ? std::optional(stamp->form) : std::nullopt;
}

text::Cell parse_calendar(std::string_view cell, StampForm form, std::int64_t& ns) {
  ns = text::kNoStamp;
  cell = without_quotes(cell);
  const auto stamp = read_calendar(cell);
  if (!stamp || stamp->form != form) {
    double ignored = 0;
    return text::parse_number(cell, false, ignored) == text::Cell::missing ? text::Cell::missing : text::Cell::text;
  }
  constexpr std::int64_t kFirst = -8'520'336'000, kLast = 9'151'488'000;  // 1700 and 2260 [s]
  if (stamp->seconds < kFirst || stamp->seconds >= kLast) return text::Cell::beyond;
  ns = stamp->seconds * noise::kNanosecondsPerSecond + stamp->nanoseconds;
  return text::Cell::number;
}

std::string calendar_text(std::int64_t ns) {
  using namespace std::chrono;
  const auto ms = floor<milliseconds>(nanoseconds(ns));
  const auto day = floor<days>(ms);
  const year_month_day date{sys_days(day)};
  const hh_mm_ss time(ms - day);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}.{:03}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), time.hours().count(),
                     time.minutes().count(), time.seconds().count(), time.subseconds().count());
}

}  // namespace gyrobudget::inline v0::log
