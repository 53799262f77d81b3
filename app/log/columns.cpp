// SPDX-License-Identifier: MIT
#include "columns.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "names.h"

namespace gyrobudget::inline v0::log {
namespace {

namespace dimension = noise::dimension;
using noise::Signal;
using noise::Unit;

std::optional<Unit> try_unit(const std::string& text) {
  try {
    return noise::parse_unit(text);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// What a header says where a column holds raw counts: the size of one must come from the options.
bool means_counts(const std::string& unit) {
  static const std::vector<std::string> kWords = {"count", "counts", "cnt", "lsb",   "raw", "adc",
                                                  "digit", "digits", "-",   "ticks", ""};
  return std::ranges::find(kWords, text::lower(unit)) != kWords.end();
}

// --- What the numbers of a sample stand for ------------------------------------------------------------------------

/// The signal of a column whose numbers have this dimension; empty where the input does not have it.
std::optional<Signal> signal_of(Input input, const noise::Dimension& d) {
  if (d == dimension::kNumber) return Signal::dimensionless;
  if (input == Input::rate) {
    if (d == dimension::kAngularRate) return Signal::angular_rate;
    if (d == dimension::kSpecificForce) return Signal::specific_force;
    return std::nullopt;
  }
  if (d == dimension::kAngle) return Signal::angular_rate;
  if (d == dimension::kVelocity) return Signal::specific_force;
  if (d == dimension::kTime) return Signal::dimensionless;  // the phase of a clock
  return std::nullopt;
}

std::string_view expected_units(Input input) {
  return input == Input::rate ? "a rate (deg/s, rad/s, deg/h), an acceleration (g, m/s^2) or 1"
                              : "an angle (deg, rad, arcsec), a velocity (m/s) or 1";
}

/// The other inputs that a unit of this dimension would fit: "--input increment or --input angle".
std::string_view fitting_input(const noise::Dimension& d) {
  if (d == dimension::kAngularRate || d == dimension::kSpecificForce) return "; --input rate reads it";
  if (d == dimension::kAngle || d == dimension::kVelocity) {
    return "; --input increment (per sample) or --input angle (running) reads it";
  }
  return "";
}

// --- The columns ---------------------------------------------------------------------------------------------------

struct Column {
  std::size_t index = 0;
  std::string name;          ///< without unit; "column 3" where there is no header
  std::string unit_text;     ///< of the header
  std::optional<Unit> unit;  ///< of the header, where it is understood
  std::int64_t place = 1;    ///< where its heading stands in its line
};

class Chooser {
 public:
  Chooser(const std::string& source, const Layout& layout, const LogOptions& options, std::optional<std::size_t> clock)
      : source_(source), layout_(layout), options_(options), clock_(clock) {
    if (options.unit) given_unit_ = noise::parse_unit(*options.unit);  // an unknown one is wrong with any log
    for (std::size_t i = 0; i < layout.columns; ++i) columns_.push_back(column(i));
  }

  Choice choose() {
    requested_ = requested_columns();
    choose_time();
    choose_temperature();
    choose_rows();
    if (requested_.empty()) {
      choose_all_data();
    } else {
      for (const std::size_t i : requested_) {
        if (!is_the_temperature(columns_[i])) add_data(columns_[i]);
      }
      if (choice_.data.empty())
        fail_without_data({{"a temperature, which is no rate", {described(columns_[requested_[0]])}}});
    }
    if (choice_.stamps.empty() && !options_.rate_hz) {
      text::fail(source_, "has no time column and no rate is given; give the sample rate: --rate HZ");
    }
    note_unused_unit();
    make_names_differ();
    return std::move(choice_);
  }

 private:
  Column column(std::size_t i) const {
    if (layout_.headings.empty()) return {i, fmt::format("column {}", i + 1), {}, {}, 1};
    const Heading& h = layout_.headings[i];
    return {i, h.name.empty() ? fmt::format("column {}", i + 1) : h.name, h.unit,
            h.unit.empty() ? std::nullopt : try_unit(h.unit), h.column};
  }

  [[noreturn]] void fail_at_heading(const Column& c, const std::string& message) const {
    if (layout_.heading_line == 0) text::fail_at(source_, layout_.body_line, 1, message);
    text::fail_at(source_, layout_.heading_line, c.place, message);
  }

  std::string described(const Column& c) const {
    return layout_.headings.empty() ? c.name : fmt::format("column {}", text::quoted(c.name));
  }

  // --- --column ---

  std::vector<std::size_t> requested_columns() const {
    std::vector<std::size_t> result;
    const auto add = [&](std::size_t i) {
      if (std::ranges::find(result, i) == result.end()) result.push_back(i);
    };
    for (const std::string& wanted : options_.columns) {
      if (const auto found = find_column(wanted)) {
        add(*found);
        continue;
      }
      for (const std::string_view part : split(wanted, ',')) {  // --column gx,gy,gz
        const auto found = find_column(part);
        if (!found) fail_unknown_column(part);
        add(*found);
      }
    }
    return result;
  }

  std::optional<std::size_t> find_column(std::string_view wanted) const {
    const auto find = [&](auto same) -> std::optional<std::size_t> {
      const auto found = std::ranges::find_if(columns_, same);
      return found == columns_.end() ? std::nullopt : std::optional(found->index);
    };
    if (const auto exact = find([&](const Column& c) { return c.name == wanted; })) return exact;
    if (const auto loose = find([&](const Column& c) {
          return text::lower(c.name) == text::lower(wanted) ||
                 text::lower(c.name + " (" + c.unit_text + ")") == text::lower(wanted) ||
                 text::lower(c.name + " [" + c.unit_text + "]") == text::lower(wanted);
        })) {
      return loose;
    }
    if (wanted.empty() || wanted.size() > 6 || wanted.find_first_not_of("0123456789") != std::string_view::npos) {
      return std::nullopt;
    }
    const auto number = static_cast<std::size_t>(std::stoul(std::string(wanted)));
    return number >= 1 && number <= columns_.size() ? std::optional(number - 1) : std::nullopt;
  }

  [[noreturn]] void fail_unknown_column(std::string_view wanted) const {
    std::vector<std::string> names;
    names.reserve(columns_.size());
    for (const Column& c : columns_) names.push_back(c.name);
    const std::string numbers =
        columns_.size() == 1 ? "there is column 1" : fmt::format("there are columns 1 to {}", columns_.size());
    constexpr std::size_t kListed = 20;
    std::vector<std::string> listed(names.begin(), names.begin() + std::ptrdiff_t(std::min(names.size(), kListed)));
    if (names.size() > kListed) listed.emplace_back("more");
    text::fail(source_, fmt::format("has no column {}{}; {}{}", text::quoted(wanted), text::suggestion(wanted, names),
                                    numbers, layout_.headings.empty() ? "" : ": " + text::listing(listed)));
  }

  bool is_requested(const Column& c) const { return std::ranges::find(requested_, c.index) != requested_.end(); }
  bool is_the_temperature(const Column& c) const {
    return choice_.temperature && choice_.temperature->index == c.index;
  }
  bool is_time(const Column& c) const {
    return std::ranges::any_of(choice_.stamps, [&](const StampColumn& s) { return s.index == c.index; });
  }

  // --- Time ---

  /// How sure we are that a column is the time; the highest wins, then the first.
  enum class Claim { none, name, unit, name_with_unit };

  static Claim claim(const Column& c) {
    const bool unit = c.unit && c.unit->dimension == dimension::kTime;
    if (c.unit && !unit) return Claim::none;
    const auto name = time_name(c.name);
    if (name) return unit || name->ns_per_unit != 0 ? Claim::name_with_unit : Claim::name;
    return unit ? Claim::unit : Claim::none;
  }

  void choose_time() {
    if (clock_) return use_time(columns_[*clock_], 1);
    if (columns_.size() == 1) return;
    const Column* best = nullptr;
    for (const Column& c : columns_) {
      if (!is_requested(c) && claim(c) != Claim::none && (!best || claim(c) > claim(*best))) best = &c;
    }
    if (!best) {
      choose_unnamed_time();
    } else if (!holds_numbers(*best)) {
      leave_out_textual_time(*best);
    } else {
      choose_named_time(*best);
    }
  }

  bool holds_numbers(const Column& c) const {
    return std::ranges::any_of(layout_.sample, [&](const auto& row) {
      std::int64_t ns = 0;
      return c.index < row.size() &&
             text::parse_stamp(row[c.index], layout_.dialect.decimal_comma, 1, ns) != text::Cell::text;
    });
  }

  void leave_out_textual_time(const Column& c) {
    const std::string found = text::quoted(c.index < layout_.sample[0].size() ? layout_.sample[0][c.index] : "");
    if (!options_.rate_hz) {
      text::fail_at(
          source_, layout_.body_line, 1,
          fmt::format(
              "found {} in the time {}, expected a number; write the time as seconds or as nanoseconds, or give --rate HZ",
              found, described(c)));
    }
    choice_.notes.push_back(
        fmt::format("the time {} holds text ({}) and is not used: gaps cannot be seen, the rate is that of --rate",
                    described(c), found));
  }

  void choose_named_time(const Column& c) {
    if (c.unit) {
      use_time(c, std::llround(c.unit->to_si * noise::kNanosecondsPerSecond));
      return;
    }
    const TimeName name = *time_name(c.name);
    if (name.ns_per_unit == 0) {
      use_time(c, agreeing_unit(c, true).value());
      return;
    }
    use_time(c, name.ns_per_unit);
    choice_.notes.push_back(fmt::format("the unit of time is taken from the name of {}", described(c)));
    if (!name.unit_only) return;
    for (const Column& other : columns_) {  // secs has its nsecs (or usecs) beside it
      const auto part = time_name(other.name);
      if (is_requested(other) || !part || !part->unit_only) continue;
      const auto [fine, coarse] = std::minmax(part->ns_per_unit, name.ns_per_unit);
      constexpr std::int64_t kSecond = noise::kNanosecondsPerSecond, kMicro = 1'000;
      if (coarse != kSecond || fine > kMicro) continue;
      choice_.stamps.push_back({other.index, part->ns_per_unit});
      choice_.notes.push_back(fmt::format("the time is the sum of {} and {}", described(c), described(other)));
      return;
    }
  }

  void use_time(const Column& c, std::int64_t ns_per_unit) {
    if (ns_per_unit < 1) {
      fail_at_heading(
          c, fmt::format("found the unit {} of time, expected one of a nanosecond or more", text::quoted(c.unit_text)));
    }
    choice_.stamps = {{c.index, ns_per_unit}};
    choice_.time_name = described(c);
  }

  /// A first or last column without a name or unit of its own that rises evenly is time, or a counter.
  void choose_unnamed_time() {
    for (const Column* c : {&columns_.front(), &columns_.back()}) {
      if (is_requested(*c) || !c->unit_text.empty() || !rises_evenly(*c)) continue;
      if (!layout_.headings.empty() && kind_of_name(c->name) != NameKind::unknown) continue;
      // Running angles rise evenly too: they are taken for time only where they fit the rate.
      const bool must_be_time = requested_.empty() && options_.input != Input::angle;
      if (const auto unit = agreeing_unit(*c, must_be_time)) {
        use_time(*c, *unit);
        choice_.notes.push_back(fmt::format("{} rises evenly and agrees with --rate in {}: it is read as time",
                                            described(*c), unit_name(*unit)));
        return;
      }
    }
  }

  /// Differences of a column in the first rows, sorted; empty where it is not all numbers.
  std::vector<double> sorted_steps(const Column& c) const {
    std::vector<double> steps;
    std::optional<double> before;
    for (const auto& row : layout_.sample) {
      double value = 0;
      if (c.index >= row.size() ||
          text::parse_number(row[c.index], layout_.dialect.decimal_comma, value) != text::Cell::number) {
        return {};
      }
      if (before) steps.push_back(value - *before);
      before = value;
    }
    std::ranges::sort(steps);
    return steps;
  }

  bool rises_evenly(const Column& c) const {
    const std::vector<double> steps = sorted_steps(c);
    constexpr std::size_t kFewest = 2;
    if (steps.size() < kFewest || steps.front() < 0) return false;
    const double median = steps[steps.size() / 2];
    const auto near = std::ranges::count_if(steps, [&](double s) { return std::abs(s - median) < median / 2; });
    constexpr double kMost = 0.9;
    return median > 0 && static_cast<double>(near) >= kMost * static_cast<double>(steps.size());
  }

  static constexpr std::pair<std::string_view, std::int64_t> kUnlabelled[] = {
      {"s", noise::kNanosecondsPerSecond}, {"ms", 1'000'000}, {"us", 1'000}, {"ns", 1}};

  static std::string_view unit_name(std::int64_t ns) {
    return std::ranges::find(kUnlabelled, ns, [](auto& u) { return u.second; })->first;
  }

  /// The unit in which the steps of the column agree with the given rate.
  /// Where none does: empty, or an error that lists the choices.
  std::optional<std::int64_t> agreeing_unit(const Column& c, bool must) const {
    std::vector<double> steps = sorted_steps(c);
    std::erase_if(steps, [](double s) { return !(s > 0); });
    const double step = steps.empty() ? 0 : steps[steps.size() / 2];
    std::vector<std::string> choices;
    constexpr double kNear = 0.1;  // units are a thousand apart; the rate itself is checked with all stamps
    for (const auto& [name, ns] : kUnlabelled) {
      const double rate = noise::kNanosecondsPerSecond / (step * static_cast<double>(ns));
      if (options_.rate_hz && std::abs(rate / *options_.rate_hz - 1) < kNear) return ns;
      choices.push_back(fmt::format("{:.4g} Hz in {}", rate, name));
    }
    if (!must) return std::nullopt;
    if (step <= 0)
      fail_at_heading(c,
                      fmt::format("the time {} does not rise in the first rows; expected rising time", described(c)));
    if (!options_.rate_hz) {
      fail_at_heading(
          c,
          fmt::format(
              "the time {} has no unit: its step of {:.4g} is {}; write the unit into the header, as in \"time (s)\", or give --rate HZ",
              described(c), step, text::listing(choices, "or")));
    }
    fail_at_heading(
        c,
        fmt::format(
            "{} rises like a time by {:.4g} a row, which is {}, but --rate is {:g} Hz; correct --rate, or choose the data columns with --column",
            described(c), step, text::listing(choices, "or"), *options_.rate_hz));
  }

  // --- Temperature, and whose rows ---

  static bool has_unit_of_temperature(const Column& c) {
    return c.unit && c.unit->dimension == dimension::kTemperature;
  }
  bool is_named_temperature(const Column& c) const {
    return !layout_.headings.empty() && kind_of_name(c.name) == NameKind::temperature;
  }
  /// gyro_x_tempcomp (deg/s): compensated for temperature, says the unit that the header gives it.
  bool is_compensated(const Column& c) const {
    const std::string name = text::lower(c.name);
    const bool sensor = name.find("gyr") != std::string::npos || name.find("acc") != std::string::npos;
    return sensor && c.unit && signal_of(options_.input, c.unit->dimension).has_value();
  }
  /// Never data, whatever else is asked for.
  bool is_temperature(const Column& c) const {
    return has_unit_of_temperature(c) || (is_named_temperature(c) && !is_time(c) && !is_compensated(c));
  }

  /// All numbers of the first rows lie between these.
  bool lies_within(const Column& c, double low, double high) const {
    bool any = false;
    for (const auto& row : layout_.sample) {
      double value = 0;
      if (c.index >= row.size()) return false;
      const auto cell = text::parse_number(row[c.index], layout_.dialect.decimal_comma, value);
      if (cell == text::Cell::text || (cell == text::Cell::number && !(value > low && value < high))) return false;
      any = any || cell == text::Cell::number;
    }
    return any;
  }

  void choose_temperature() {
    constexpr double kKelvin = 273.15, kLowest = -90, kHighest = 200;  // [degC], of electronics
    const Column* best = nullptr;
    for (const Column& c : columns_) {
      const bool plausible = has_unit_of_temperature(c) ||
                             (is_named_temperature(c) && c.unit_text.empty() && lies_within(c, kLowest, kHighest));
      if (is_time(c) || !plausible) continue;
      if (!best || (has_unit_of_temperature(c) && !has_unit_of_temperature(*best)) ||
          (is_requested(c) && !is_requested(*best)))
        best = &c;
    }
    if (!best) return;
    const bool absolute = best->unit_text == "K" || text::lower(best->unit_text) == "kelvin";
    choice_.temperature = DataColumn{
        .index = best->index, .name = best->name, .signal = Signal::dimensionless, .zero = absolute ? -kKelvin : 0};
    choice_.notes.push_back(best->unit_text.empty()
                                ? fmt::format("{} is read as the temperature in degC, by its name", described(*best))
                                : fmt::format("{} is read as the temperature", described(*best)));
  }

  void choose_rows() {
    if (!options_.rows) return;
    const auto found = find_column(options_.rows->column);
    if (!found) fail_unknown_column(options_.rows->column);
    choice_.rows_of = DataColumn{.index = *found, .name = columns_[*found].name, .signal = Signal::dimensionless};
    const Column& c = columns_[*found];
    if (is_time(c) || is_requested(c))
      fail_at_heading(c, fmt::format("{} is {}; rows are chosen by another column", described(c),
                                     is_time(c) ? "the time" : "to be read as data"));
    if (is_the_temperature(c)) choice_.temperature.reset();
  }

  // --- Data ---

  /// A column as data, or the reason why it is none.
  struct Verdict {
    std::optional<DataColumn> data;
    std::string reason;
    bool unit_missing = false;
  };

  static Verdict refused(std::string reason) { return {{}, std::move(reason), false}; }

  Verdict judge(const Column& c, bool requested) const {
    if (is_temperature(c)) return refused("a temperature, which is no rate");
    const bool unknown = !c.unit && !means_counts(c.unit_text);
    if (unknown && !(given_unit_ && requested)) {
      return refused(fmt::format("the unit {} is not understood", text::quoted(c.unit_text)));
    }
    if (!c.unit && !given_unit_) return {{}, "no unit", true};
    const Unit unit = c.unit ? *c.unit : *given_unit_;
    if (!requested) {
      if (const std::string_view reason = reason_against(c, unit); !reason.empty()) return refused(std::string(reason));
    }
    const auto signal = signal_of(options_.input, unit.dimension);
    if (signal) return {DataColumn{c.index, c.name, *signal, options_.scale * unit.to_si}, {}, false};
    return refused(fmt::format("the unit {} is not that of {}{}", text::quoted(c.unit ? c.unit_text : *options_.unit),
                               options_.input == Input::rate ? "a rate or an acceleration" : "an angle or a velocity",
                               fitting_input(unit.dimension)));
  }

  /// Why a column that nobody asked for by name should not be taken.
  std::string_view reason_against(const Column& c, const Unit& unit) const {
    if (c.unit) return unit.dimension == dimension::kNumber && c.unit_text != "1" ? "a plain number" : "";
    const NameKind kind = layout_.headings.empty() ? NameKind::unknown : kind_of_name(c.name);
    if (kind == NameKind::other) return "by its name neither a rate nor an acceleration";
    if (kind == NameKind::accelerometer && unit.dimension.angle != 0) {
      return "named like an accelerometer, while --unit is that of a gyro";
    }
    if (kind == NameKind::gyro && unit.dimension.length != 0) {
      return "named like a gyro, while --unit is that of an accelerometer";
    }
    return {};
  }

  void add_data(const Column& c) {
    Verdict verdict = judge(c, true);
    if (verdict.unit_missing) fail_missing_unit(c);
    if (!verdict.data) fail_at_heading(c, fmt::format("{}: {}", described(c), verdict.reason));
    if (!c.unit && !means_counts(c.unit_text)) {
      choice_.notes.push_back(fmt::format("{}: the unit {} is not understood, --unit {} is used", described(c),
                                          text::quoted(c.unit_text), *options_.unit));
    }
    choice_.data.push_back(*std::move(verdict.data));
  }

  /// Columns that are left out for the same reason.
  struct LeftOut {
    std::string reason;
    std::vector<std::string> names;
  };

  static std::string text(const LeftOut& l) {
    constexpr std::size_t kListed = 12;
    std::vector<std::string> names(l.names.begin(),
                                   l.names.begin() + std::ptrdiff_t(std::min(l.names.size(), kListed)));
    if (l.names.size() > kListed) names.push_back(fmt::format("{} more", l.names.size() - kListed));
    return fmt::format("{} ({})", text::listing(names), l.reason);
  }

  void choose_all_data() {
    std::vector<LeftOut> left_out;
    const Column* without_unit = nullptr;
    for (const Column& c : columns_) {
      if (is_time(c) || is_the_temperature(c) || (choice_.rows_of && choice_.rows_of->index == c.index)) continue;
      Verdict verdict = judge(c, false);
      if (verdict.data) {
        choice_.data.push_back(*std::move(verdict.data));
        continue;
      }
      if (verdict.unit_missing && !without_unit) without_unit = &c;
      auto same = std::ranges::find(left_out, verdict.reason, &LeftOut::reason);
      if (same == left_out.end()) same = left_out.insert(same, {verdict.reason, {}});
      same->names.push_back(layout_.headings.empty() ? c.name : text::quoted(c.name));
    }
    if (choice_.data.empty() && without_unit) fail_missing_unit(*without_unit);
    if (choice_.data.empty()) fail_without_data(left_out);
    for (const LeftOut& l : left_out) choice_.notes.push_back("left out " + text(l));
  }

  void note_unused_unit() {
    const bool used = std::ranges::any_of(choice_.data, [&](const DataColumn& d) {
      const auto c = std::ranges::find(columns_, d.index, &Column::index);
      return c == columns_.end() || !c->unit;
    });
    if (options_.unit && !choice_.data.empty() && !used) {
      choice_.notes.push_back(
          fmt::format("--unit {} is not used: the header gives the columns their units", *options_.unit));
    }
  }

  [[noreturn]] void fail_missing_unit(const Column& c) const {
    const std::string_view usual = options_.input == Input::rate ? "deg/s" : "rad";
    std::string message = fmt::format("{} has no unit, expected one in the header, as in \"{} ({})\", or --unit {}",
                                      described(c), layout_.headings.empty() ? "gyro_x" : c.name, usual, usual);
    if (const std::string_view hint = unit_hint(c.name); !hint.empty()) {
      const auto unit = noise::parse_unit(hint);
      message += fmt::format("; if its name stands for {}, give --unit {}", hint, hint);
      if (!signal_of(options_.input, unit.dimension)) message += fitting_input(unit.dimension);
    } else if (!c.unit_text.empty()) {
      message += "; counts need --scale (units per count) and --unit";
    }
    if (choice_.stamps.empty() && !options_.rate_hz) message += "; there is no time column either: give --rate HZ too";
    fail_at_heading(c, message);
  }

  [[noreturn]] void fail_without_data(const std::vector<LeftOut>& left_out) const {
    const std::int64_t line = layout_.heading_line != 0 ? layout_.heading_line : layout_.body_line;
    if (left_out.empty()) {
      text::fail_at(source_, line, 1, "holds time and no data column, expected a gyro or an accelerometer beside it");
    }
    std::vector<std::string> found;
    for (const LeftOut& l : left_out) found.push_back(text(l));
    text::fail_at(
        source_, line, 1,
        fmt::format("found no data column among {}, expected one with {}; choose it with --column and give --unit",
                    text::listing(found), expected_units(options_.input)));
  }

  void make_names_differ() {
    for (std::size_t i = 1; i < choice_.data.size(); ++i) {
      DataColumn& c = choice_.data[i];
      const auto end = choice_.data.begin() + static_cast<std::ptrdiff_t>(i);
      const bool taken = std::any_of(choice_.data.begin(), end, [&](const DataColumn& d) { return d.name == c.name; });
      if (taken) c.name += fmt::format(" (column {})", c.index + 1);
    }
  }

  const std::string& source_;
  const Layout& layout_;
  const LogOptions& options_;
  std::optional<std::size_t> clock_;
  std::optional<Unit> given_unit_;
  std::vector<Column> columns_;
  std::vector<std::size_t> requested_;
  Choice choice_;
};

}  // namespace

Choice choose_columns(const std::string& source, const Layout& layout, const LogOptions& options,
                      std::optional<std::size_t> clock) {
  return Chooser(source, layout, options, clock).choose();
}

void put_beside(Choice& choice) {
  if (choice.temperature) choice.data.push_back(*choice.temperature);
  if (choice.rows_of) choice.data.push_back(*choice.rows_of);
}

}  // namespace gyrobudget::inline v0::log
