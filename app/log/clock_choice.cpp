// SPDX-License-Identifier: MIT
#include "clock_choice.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "names.h"
#include "top_lines.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::int64_t kOneSecond = noise::kNanosecondsPerSecond;

constexpr std::array<std::pair<std::string_view, std::int64_t>, 4> kUnlabelled{
    {{"s", kOneSecond}, {"ms", 1'000'000}, {"us", 1'000}, {"ns", 1}}};

std::string_view unit_name(std::int64_t ns) {
  return std::ranges::find(kUnlabelled, ns, [](auto& u) { return u.second; })->first;
}

// --- How a column goes on from row to row --------------------------------------------------------------------------

/// Differences of a column in the first rows, sorted; empty where it is not all numbers.
std::vector<double> sorted_steps(const ColumnSet& columns, const Column& c) {
  const std::vector<double> numbers = columns.numbers(c);
  std::vector<double> steps;
  for (std::size_t i = 1; i < numbers.size(); ++i) steps.push_back(numbers[i] - numbers[i - 1]);
  std::ranges::sort(steps);
  return steps;
}

/// Their median, and their mean without those that are no step from sample to sample; both of steps above zero.
struct TypicalStep {
  double median = 0, mean = 0;
};

TypicalStep typical_step(std::vector<double> sorted) {
  std::erase_if(sorted, [](double s) { return !(s > 0); });
  if (sorted.empty()) return {};
  const double median = sorted[sorted.size() / 2];
  double sum = 0, count = 0;
  for (const double s : sorted) {
    if (s > 3 * median) break;
    sum += s, ++count;
  }
  return {median, sum / count};
}

/// Every step is near the median.
bool rises_evenly(const std::vector<double>& sorted) {
  constexpr std::size_t kFewest = 2;
  if (sorted.size() < kFewest || sorted.front() < 0) return false;
  const double median = sorted[sorted.size() / 2];
  const auto near = std::ranges::count_if(sorted, [&](double s) { return std::abs(s - median) < median / 2; });
  constexpr double kMost = 0.9;
  return median > 0 && static_cast<double>(near) >= kMost * static_cast<double>(sorted.size());
}

/// It never falls (but where a counter starts again), and nearly all of its steps are of one size, within a factor of
/// three: jittering stamps, or coarse ones of which runs are equal. A sensor falls every other row.
bool rises_like_time(const std::vector<double>& numbers) {
  constexpr std::size_t kFewest = 16;  // of chance one in 2^16 rises so long
  if (numbers.size() < kFewest) return false;
  std::vector<double> rising;
  std::size_t falls = 0, run = 0, longest_run = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    const double step = numbers[i] - numbers[i - 1];
    falls += step < 0 ? 1 : 0;
    run = step == 0 ? run + 1 : 0;
    longest_run = std::max(longest_run, run);
    if (step > 0) rising.push_back(step);
  }
  const double steps = static_cast<double>(numbers.size() - 1);
  constexpr std::size_t kFewestRises = 4, kMostFalls = 2;
  if (rising.size() < kFewestRises || falls > kMostFalls) return false;
  std::ranges::sort(rising);
  const double median = rising[rising.size() / 2];
  constexpr double kMost = 0.9, kFactor = 3;
  const auto near =
      std::ranges::count_if(rising, [&](double s) { return s < kFactor * median && s * kFactor > median; });
  const double rows_per_rise = steps / static_cast<double>(rising.size());
  return static_cast<double>(near) >= kMost * static_cast<double>(rising.size()) &&
         static_cast<double>(longest_run) <= kFactor * rows_per_rise;
}

/// Whole numbers that go up by the same from row to row, except where rows are lost or the counter starts again.
/// @return by how much; 0 where it is none
std::int64_t counted_step(const std::vector<double>& numbers) {
  constexpr std::size_t kFewest = 8;
  constexpr double kMostExact = 0x1p53, kMost = 0.9;
  if (numbers.size() < kFewest) return 0;
  std::map<double, std::size_t> counts;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != std::floor(numbers[i]) || std::abs(numbers[i]) > kMostExact) return 0;
    if (i > 0) ++counts[numbers[i] - numbers[i - 1]];
  }
  const auto most = std::ranges::max_element(counts, {}, [](const auto& c) { return c.second; });
  const bool even = static_cast<double>(most->second) >= kMost * static_cast<double>(numbers.size() - 1);
  return even && most->first > 0 ? static_cast<std::int64_t>(most->first) : 0;
}

// --- The choice ----------------------------------------------------------------------------------------------------

/// Parts of one time that stand in columns of their own.
constexpr std::array<std::pair<std::string_view, std::int64_t>, 3> kPartsOfDay{
    {{"hour", 3600 * kOneSecond}, {"min", 60 * kOneSecond}, {"sec", kOneSecond}}};

class ClockChooser {
 public:
  ClockChooser(const ColumnSet& columns, const LogOptions& options, const std::vector<std::size_t>& requested,
               Choice& choice)
      : set_(columns), options_(options), requested_(requested), choice_(choice) {}

  void choose() {
    if (options_.time) {
      take_asked();
    } else if (set_.all().size() > 1) {
      find();
    }
    refuse_turns();
  }

 private:
  void note(std::string text) { choice_.notes.push_back(std::move(text)); }

  bool is_requested(const Column& c) const { return std::ranges::find(requested_, c.index) != requested_.end(); }
  bool is_used(const Column& c) const {
    return std::ranges::any_of(choice_.stamps, [&](const StampColumn& s) { return s.index == c.index; });
  }

  void use(const Column& c, std::int64_t ns_per_unit, StampForm form = StampForm::number) {
    if (ns_per_unit < 1) {
      set_.fail_at_heading(
          c, fmt::format("found the unit {} of time, expected one of a nanosecond or more", text::quoted(c.unit_text)));
    }
    choice_.stamps.push_back({c.index, ns_per_unit, form});
    if (choice_.stamps.size() > 1) return;
    choice_.time_name = set_.described(c);
    if (form == StampForm::number) choice_.wraps = integer_wraps(ns_per_unit);
    if (form == StampForm::time_of_day) choice_.wraps = {{kDay, true}};
  }

  /// Where a counter of 16, 24 or 32 bits starts again; a microcontroller's of microseconds in any unit.
  static std::vector<Wrap> integer_wraps(std::int64_t ns_per_unit) {
    constexpr std::int64_t kMicro = 1'000;
    std::vector<Wrap> wraps;
    for (const int bits : {16, 24, 32}) {
      std::int64_t period = 0;
      if (!__builtin_mul_overflow(std::int64_t{1} << bits, ns_per_unit, &period)) wraps.push_back({period, false});
    }
    if (ns_per_unit > kMicro) wraps.push_back({(std::int64_t{1} << 32) * kMicro, false});
    std::ranges::sort(wraps, {}, &Wrap::period_ns);
    return wraps;
  }

  // --- Found by itself ---

  /// How sure we are that a column is the time; the highest wins, then the first.
  enum class Claim { none, name, unit, name_with_unit };

  static Claim claim(const Column& c) {
    const bool unit = c.unit && c.unit->dimension == noise::dimension::kTime;
    if (c.unit && !unit) return Claim::none;
    const auto name = time_name(c.name);
    if (name) return unit || name->ns_per_unit != 0 ? Claim::name_with_unit : Claim::name;
    return unit ? Claim::unit : Claim::none;
  }

  void find() {
    const Column* best = nullptr;
    for (const Column& c : set_.all()) {
      if (is_requested(c) || claim(c) == Claim::none) continue;
      if (set_.is_empty(c) && claim(c) != Claim::none) {
        note(fmt::format("the time {} is empty and not used", set_.described(c)));
      } else if (!best || claim(c) > claim(*best)) {
        best = &c;
      }
    }
    if (use_parts_of_day(best)) return;
    if (best && set_.holds_stamps(*best)) return use_named(*best);
    if (best && set_.calendar(*best)) return use_calendar(*best);
    if (use_any_calendar() || use_unnamed() || use_counter()) return;
    if (best) leave_out_text(*best);
  }

  void leave_out_text(const Column& c) {
    const auto cells = set_.cells(c);
    const std::string found = text::quoted(cells.empty() ? "" : cells[0]);
    if (!options_.rate_hz) {
      text::fail_at(
          set_.source(), set_.layout().body_line, 1,
          fmt::format(
              "found {} in the time {}, expected a number, or a date and time of day as in 2024-03-05 09:14:22.005; write the time so, or give --rate HZ",
              found, set_.described(c)));
    }
    note(fmt::format("the time {} holds text ({}) and is not used: gaps cannot be seen, the rate is that of --rate",
                     set_.described(c), found));
  }

  void use_named(const Column& c) {
    if (c.unit) {
      use(c, std::llround(c.unit->to_si * kOneSecond));
      return add_week(c);
    }
    const TimeName name = *time_name(c.name);
    if (name.ns_per_unit == 0) {
      use(c, agreeing_unit(c, true).value());
      return add_week(c);
    }
    use(c, name.ns_per_unit);
    note(fmt::format("the unit of time is taken from the name of {}", set_.described(c)));
    if (name.unit_only) add_finer_part(c, name);
    add_week(c);
  }

  /// secs has its nsecs (or usecs) beside it.
  void add_finer_part(const Column& c, const TimeName& name) {
    for (const Column& other : set_.all()) {
      const auto part = time_name(other.name);
      if (is_requested(other) || !part || !part->unit_only) continue;
      const auto [fine, coarse] = std::minmax(part->ns_per_unit, name.ns_per_unit);
      constexpr std::int64_t kMicro = 1'000;
      if (coarse != kOneSecond || fine > kMicro) continue;
      choice_.stamps.push_back({other.index, part->ns_per_unit});
      choice_.wraps.clear();
      note(fmt::format("the time is the sum of {} and {}", set_.described(c), set_.described(other)));
      return;
    }
  }

  static bool is_named_week(const Column& c) { return text::lower(c.name).find("week") != std::string::npos; }

  /// All numbers of the first rows are whole and lie from `least` to `most`.
  bool lies_within(const Column& c, double least, double most) const {
    const std::vector<double> numbers = set_.numbers(c);
    return !numbers.empty() && std::ranges::all_of(numbers, [&](double x) { return x >= least && x <= most; });
  }

  /// Seconds of a week run on from week to week where a column has its number.
  void add_week(const Column& c) {
    const double most = static_cast<double>(kWeek) / static_cast<double>(choice_.stamps[0].ns_per_unit);
    if (!lies_within(c, 0, most)) return;
    const std::string name = text::lower(c.name);
    const bool of_week = name.find("tow") != std::string::npos || name.find("sow") != std::string::npos ||
                         name.find("ofweek") != std::string::npos || name.find("gps") != std::string::npos;
    for (const Column& other : set_.all()) {
      constexpr double kMostWeeks = 10'000;
      if (!is_named_week(other) || is_requested(other) || other.index == c.index || !lies_within(other, 0, kMostWeeks))
        continue;
      use(other, kWeek);
      choice_.wraps.clear();
      note(fmt::format("the time is {} in the week of {}, without leap seconds", set_.described(c),
                       set_.described(other)));
      return;
    }
    if (of_week) choice_.wraps.push_back({kWeek, true});
  }

  // --- Dates and times of day ---

  void use_calendar(const Column& c) {
    const StampForm form = *set_.calendar(c);
    use(c, 1, form);
    if (form != StampForm::time_of_day) return;
    for (const Column& other : set_.all()) {
      if (is_requested(other) || other.index == c.index || !holds_dates(other)) continue;
      use(other, 1, StampForm::date);
      choice_.wraps.clear();
      note(fmt::format("the time is {} on the day of {}", set_.described(c), set_.described(other)));
      return;
    }
  }

  bool holds_dates(const Column& c) const {
    if (set_.calendar(c) == StampForm::date) return true;
    if (text::lower(c.name).find("date") == std::string::npos) return false;
    const auto cells = set_.cells(c);  // 20240305
    return std::ranges::all_of(cells, [](std::string_view cell) {
      std::int64_t ns = 0;
      return cell.size() == 8 && parse_calendar(cell, StampForm::date, ns) == text::Cell::number;
    });
  }

  bool use_any_calendar() {
    for (const Column& c : set_.all()) {
      const auto form = is_requested(c) ? std::nullopt : set_.calendar(c);
      if (!form || *form == StampForm::date) continue;
      use_calendar(c);
      note(fmt::format("{} holds {} and is read as time", set_.described(c),
                       *form == StampForm::date_time ? "dates" : "times of day"));
      return true;
    }
    return false;
  }

  /// The last word of a name says hour, minute or second.
  static bool is_named_part(const Column& c, std::string_view part) {
    const std::string name = text::lower(c.name);
    const std::size_t word = name.find_last_of("_. /") == std::string::npos ? 0 : name.find_last_of("_. /") + 1;
    return name.compare(word, part.size(), part) == 0;
  }

  /// Hour, minute and second in three columns, and perhaps nanoseconds in a fourth.
  bool use_parts_of_day(const Column* best) {
    std::vector<const Column*> parts;
    for (const auto& [name, ns] : kPartsOfDay) {
      const double most = ns == kPartsOfDay[0].second ? 24 : 60;
      const auto found = std::ranges::find_if(set_.all(), [&, part = name](const Column& c) {
        return is_named_part(c, part) && !is_requested(c) && lies_within(c, 0, most);
      });
      if (found == set_.all().end()) return false;
      parts.push_back(&*found);
    }
    if (best && std::ranges::find(parts, best) == parts.end()) return false;
    for (std::size_t i = 0; i < parts.size(); ++i) use(*parts[i], kPartsOfDay[i].second);
    choice_.wraps = {{kDay, true}};
    for (const Column& c : set_.all()) {
      if (!is_named_part(c, "nano") || is_requested(c) || !lies_within(c, 0, kOneSecond)) continue;
      choice_.stamps.push_back({c.index, 1});
      break;
    }
    note(fmt::format("the time is that of {}, {} and {}{}", set_.described(*parts[0]), set_.described(*parts[1]),
                     set_.described(*parts[2]), choice_.stamps.size() > 3 ? " with its nanoseconds" : ""));
    return true;
  }

  // --- Columns without the name of a time ---

  bool may_be_clock(const Column& c) const {
    if (is_requested(c) || is_used(c) || !c.unit_text.empty()) return false;
    return !set_.has_header() || kind_of_name(c.name) == NameKind::unknown;
  }

  /// Candidates in order: the first and the last column, then the others.
  std::vector<const Column*> candidates() const {
    std::vector<const Column*> result{&set_.all().front(), &set_.all().back()};
    for (std::size_t i = 1; i + 1 < set_.all().size(); ++i) result.push_back(&set_.all()[i]);
    std::erase_if(result, [&](const Column* c) { return !may_be_clock(*c); });
    return result;
  }

  /// A column without a name or unit of its own that rises as time does.
  bool use_unnamed() {
    for (const Column* c : candidates()) {
      const bool at_an_end = c->index == 0 || c->index + 1 == set_.all().size();
      if (!(at_an_end && rises_evenly(sorted_steps(set_, *c))) && !rises_like_time(set_.numbers(*c))) continue;
      // Running angles rise evenly too: they are taken for time only where they fit the rate.
      const bool must_be_time = requested_.empty() && options_.input != Input::angle;
      const bool may_count = options_.rate_hz && options_.input != Input::angle && counted_step(set_.numbers(*c)) > 0;
      if (const auto unit = agreeing_unit(*c, must_be_time && !may_count)) {
        use(*c, *unit);
        note(fmt::format("{} rises evenly and agrees with --rate in {}: it is read as time", set_.described(*c),
                         unit_name(*unit)));
        return true;
      }
      if (may_count) return count_by(*c), true;
      if (options_.input != Input::angle)
        note(fmt::format(
            "{} rises like a time and agrees with --rate in no unit: it is not used; --time {}=UNIT reads it",
            set_.described(*c), c->index + 1));
    }
    return false;
  }

  /// The unit in which the steps of the column agree with the given rate.
  /// Where none does: empty, or an error that lists the choices.
  std::optional<std::int64_t> agreeing_unit(const Column& c, bool must) const {
    const TypicalStep step = typical_step(sorted_steps(set_, c));
    std::vector<std::string> choices;
    constexpr double kNear = 0.1;  // units are a thousand apart; the rate itself is checked with all stamps
    for (const double typical : {step.median, step.mean}) {
      for (const auto& [name, ns] : kUnlabelled) {
        const double rate = kOneSecond / (typical * static_cast<double>(ns));
        if (options_.rate_hz && std::abs(rate / *options_.rate_hz - 1) < kNear) return ns;
        if (choices.size() < kUnlabelled.size()) choices.push_back(fmt::format("{:.4g} Hz in {}", rate, name));
      }
    }
    if (options_.rate_hz) {
      if (const auto unit = unit_of_coarse_stamps(c)) return unit;
    }
    if (!must) return std::nullopt;
    fail_without_unit(c, step.median, choices);
  }

  /// Stamps that repeat: the unit in which all of the first rows agree with the given rate.
  std::optional<std::int64_t> unit_of_coarse_stamps(const Column& c) const {
    const std::vector<double> numbers = set_.numbers(c);
    if (!rises_like_time(numbers)) return std::nullopt;
    constexpr double kRough = 0.3;  // a few stamps in the first rows
    const double step = (numbers.back() - numbers.front()) / static_cast<double>(numbers.size() - 1);
    for (const auto& [name, ns] : kUnlabelled) {
      const double rate = kOneSecond / (step * static_cast<double>(ns));
      if (std::abs(rate / *options_.rate_hz - 1) < kRough) return ns;
    }
    return std::nullopt;
  }

  [[noreturn]] void fail_without_unit(const Column& c, double step, const std::vector<std::string>& choices) const {
    const std::string column = set_.described(c);
    if (step <= 0)
      set_.fail_at_heading(c, fmt::format("the time {} does not rise in the first rows; expected rising time", column));
    if (!options_.rate_hz) {
      set_.fail_at_heading(
          c,
          fmt::format(
              "the time {} has no unit: its step of {:.4g} is {}; write the unit into the header, as in \"time (s)\", or give --rate HZ or --time {}=ms{}",
              column, step, text::listing(choices, "or"), c.index + 1,
              counted_step(set_.numbers(c)) > 0 ? "; a counter of samples needs --rate HZ" : ""));
    }
    set_.fail_at_heading(
        c,
        fmt::format(
            "{} rises like a time by {:.4g} a row, which is {}, but --rate is {:g} Hz; correct --rate, or choose the data columns with --column, or tell what it is with --time (--time none: no time)",
            column, step, text::listing(choices, "or"), *options_.rate_hz));
  }

  // --- Counters ---

  static bool is_named_counter(const Column& c) {
    const std::string name = text::lower(c.name);
    constexpr std::array<std::string_view, 9> kWords{"count", "cntr",   "packet", "seq",      "sample",
                                                     "index", "number", "frame",  "iteration"};
    return std::ranges::any_of(kWords, [&](auto word) { return name.find(word) != std::string::npos; });
  }

  bool use_counter() {
    if (!options_.rate_hz || !set_.has_header()) return false;
    for (const Column& c : set_.all()) {
      if (is_requested(c) || !c.unit_text.empty() || !is_named_counter(c)) continue;
      if (counted_step(set_.numbers(c)) == 0) continue;
      count_by(c);
      return true;
    }
    return false;
  }

  void count_by(const Column& c) {
    const auto step = static_cast<double>(std::max<std::int64_t>(counted_step(set_.numbers(c)), 1));
    const double ns = kOneSecond / *options_.rate_hz / step;
    constexpr double kLongest = 1e15;  // [ns] a count; more has no room for counters of 32 bits
    const auto unit = static_cast<std::int64_t>(std::clamp(std::round(ns), 1., kLongest));
    use(c, unit);
    choice_.count_ns = unit * static_cast<std::int64_t>(step);
    choice_.wraps.clear();
    for (const int bits : {7, 8, 16, 24, 32}) {
      std::int64_t period = 0;
      if (!__builtin_mul_overflow(std::int64_t{1} << bits, unit, &period)) choice_.wraps.push_back({period, false});
    }
  }

  // --- Asked for ---

  void take_asked() {
    const TimeOf& asked = *options_.time;
    choice_.time_asked = true;
    if (text::lower(asked.column) == "none" && !set_.find(asked.column)) return;
    std::vector<const Column*> parts;
    if (const auto whole = set_.find(asked.column)) {
      parts.push_back(&set_.all()[*whole]);
    } else {
      for (const std::string_view part : split(asked.column, '+')) parts.push_back(&set_.all()[set_.get(part)]);
    }
    for (const Column* c : parts) {
      if (is_requested(*c))
        set_.fail_at_heading(
            *c, fmt::format("{} is asked for as time and as data; leave it out of one", set_.described(*c)));
      take_asked_part(*c, parts.size());
    }
    if (parts.size() > 1 && !(choice_.wraps.size() == 1 && choice_.wraps[0].known)) choice_.wraps.clear();
    if (parts.size() > 1 && std::ranges::any_of(choice_.stamps, [](const auto& s) {
          return s.form == StampForm::date || s.ns_per_unit == kWeek;
        }))
      choice_.wraps.clear();
  }

  void take_asked_part(const Column& c, std::size_t parts) {
    const std::string& unit = options_.time->unit;
    if (unit == "counter") {
      count_by(c);
    } else if (unit == "gps") {
      const bool week = parts > 1 && is_named_week(c);
      use(c, week ? kWeek : c.unit ? std::llround(c.unit->to_si * kOneSecond) : kOneSecond);
      if (!week) choice_.wraps = {{kWeek, true}};
    } else if (unit == "iso" || (unit.empty() && (set_.calendar(c) || (parts > 1 && holds_dates(c))))) {
      const auto form = set_.calendar(c);
      if (!form && !holds_dates(c)) fail_at_calendar(c);
      use(c, 1, form.value_or(StampForm::date));
    } else if (!unit.empty()) {
      const auto* known = std::ranges::find(kUnlabelled, unit, [](auto& u) { return u.first; });
      use(c, parts > 1 && is_named_week(c) ? kWeek : known->second);
    } else {
      use(c, told_unit(c, parts));
    }
  }

  [[noreturn]] void fail_at_calendar(const Column& c) const {
    const auto cells = set_.cells(c);
    const auto other =
        std::ranges::find_if_not(cells, [](auto cell) { return calendar_form(cell) || is_missing(cell); });
    text::fail_at(
        set_.source(), set_.layout().body_line, 1,
        fmt::format(
            "found {} in {}, expected dates or times of day, all alike, as in 2024-03-05T09:14:22.005Z; correct --time",
            text::quoted(other == cells.end() ? "" : *other), set_.described(c)));
  }

  std::int64_t told_unit(const Column& c, std::size_t parts) const {
    if (c.unit && c.unit->dimension == noise::dimension::kTime) return std::llround(c.unit->to_si * kOneSecond);
    if (parts > 1 && is_named_week(c)) return kWeek;
    for (const auto& [name, ns] : kPartsOfDay)
      if (parts > 1 && is_named_part(c, name)) return ns;
    if (const auto name = time_name(c.name); name && name->ns_per_unit != 0) return name->ns_per_unit;
    return agreeing_unit(c, true).value();
  }

  // --- By turns ---

  /// The time of a row in the first rows; NaN where it has none.
  std::vector<double> first_stamps() const {
    std::vector<double> stamps;
    for (const auto& row : set_.layout().sample) {
      double sum = 0;
      for (const StampColumn& s : choice_.stamps) {
        std::int64_t ns = text::kNoStamp;
        if (s.index < row.size()) static_cast<void>(parse_stamp(row[s.index], s, ns));
        sum += ns == text::kNoStamp ? std::nan("") : static_cast<double>(ns - first_ns(s));
      }
      stamps.push_back(sum);
    }
    return stamps;
  }

  text::Cell parse_stamp(std::string_view cell, const StampColumn& s, std::int64_t& ns) const {
    return s.form == StampForm::number ? text::parse_stamp(cell, set_.layout().dialect.decimal_comma, s.ns_per_unit, ns)
                                       : parse_calendar(cell, s.form, ns);
  }

  /// What a part holds in the first row: differences from it are exact.
  std::int64_t first_ns(const StampColumn& s) const {
    std::int64_t ns = text::kNoStamp;
    const auto& row = set_.layout().sample.front();
    if (s.index < row.size()) static_cast<void>(parse_stamp(row[s.index], s, ns));
    constexpr std::int64_t kHalf = std::int64_t{1} << 61;  // leaves room for the difference
    return ns == text::kNoStamp || std::abs(ns) > kHalf ? 0 : ns;
  }

  /// Share of the steps that are within half of the middle one, which is above zero.
  static double even_share(const std::vector<double>& stamps) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
    if (steps.empty()) return 0;
    std::vector<double> sorted = steps;
    std::ranges::sort(sorted);
    // Of two sizes by turns the middle one is in between.
    const double middle = (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]) / 2;
    const auto near = std::ranges::count_if(steps, [&](double s) { return std::abs(s - middle) < middle / 2; });
    return middle > 0 ? static_cast<double>(near) / static_cast<double>(steps.size()) : 0;
  }

  /// Where the time is uneven, and even in the rows of each value of another column, several sensors wrote by turns.
  void refuse_turns() const {
    constexpr std::size_t kFewest = 16;
    constexpr double kUneven = 0.75, kEven = 0.8;
    if (choice_.stamps.empty() || options_.rows || options_.resample_hz || set_.layout().sample.size() < kFewest)
      return;
    const std::vector<double> stamps = first_stamps();
    if (even_share(stamps) > kUneven) return;
    for (const Column& c : set_.all()) {
      if (is_used(c) || is_requested(c) || c.unit) continue;
      const auto turns = stamps_of_values(c, stamps);
      if (turns.empty() || !std::ranges::all_of(turns, [&](const auto& t) { return even_share(t.second) > kEven; }))
        continue;
      std::vector<std::string> values;
      for (const auto& [value, ignored] : turns) values.push_back(value);
      set_.fail_at_heading(
          c,
          fmt::format(
              "{} sensors wrote by turns: {} is {}, and only in the rows of one of them does the time {} go evenly; choose one, as in --rows {}={}; if they are samples of one sensor, give --rate HZ and --time none",
              turns.size(), set_.described(c), text::listing(values, "or"), choice_.time_name,
              set_.has_header() ? c.name : std::to_string(c.index + 1), values.front()));
    }
  }

  /// The stamps of the rows of each value of a column; empty where it has few rows for each, or many values.
  std::map<std::string, std::vector<double>> stamps_of_values(const Column& c,
                                                              const std::vector<double>& stamps) const {
    constexpr std::size_t kMostValues = 16, kFewestRows = 4;
    std::map<std::string, std::vector<double>> turns;
    const auto& sample = set_.layout().sample;
    for (std::size_t row = 0; row < sample.size(); ++row) {
      if (c.index >= sample[row].size()) return {};
      turns[std::string(sample[row][c.index])].push_back(stamps[row]);
      if (turns.size() > kMostValues) return {};
    }
    const bool few = std::ranges::any_of(turns, [](const auto& t) { return t.second.size() < kFewestRows; });
    return few || turns.size() < 2 ? decltype(turns){} : turns;
  }

  const ColumnSet& set_;
  const LogOptions& options_;
  const std::vector<std::size_t>& requested_;
  Choice& choice_;
};

}  // namespace

void choose_clock(const ColumnSet& columns, const LogOptions& options, const std::vector<std::size_t>& requested,
                  Choice& choice) {
  ClockChooser(columns, options, requested, choice).choose();
}

bool looks_like_a_clock(const ColumnSet& columns, const Column& c) {
  if (c.unit || (columns.has_header() && kind_of_name(c.name) != NameKind::unknown)) return false;
  return rises_like_time(columns.numbers(c));
}

}  // namespace gyrobudget::inline v0::log
