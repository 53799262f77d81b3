// SPDX-License-Identifier: MIT
#include "columns.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "clock_choice.h"
#include "column_set.h"
#include "names.h"

namespace gyrobudget::inline v0::log {
namespace {

namespace dimension = noise::dimension;
using noise::Signal;
using noise::Unit;

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

class Chooser {
 public:
  Chooser(const std::string& source, const Layout& layout, const LogOptions& options, std::optional<std::size_t> clock)
      : set_(source, layout, options.unit.has_value()),
        columns_(set_.all()),
        layout_(layout),
        options_(options),
        clock_(clock) {
    if (options.unit) given_unit_ = noise::parse_unit(*options.unit);  // an unknown one is wrong with any log
  }

  Choice choose() {
    if (!set_.dialect_note().empty()) choice_.notes.push_back(set_.dialect_note());
    requested_ = requested_columns();
    if (clock_)
      use_given_clock();
    else
      choose_clock(set_, options_, requested_, choice_);
    choose_temperature();
    choose_rows();
    if (requested_.empty()) {
      choose_all_data();
    } else {
      for (const std::size_t i : requested_) {
        if (!is_the_temperature(columns_[i])) add_data(columns_[i]);
      }
      if (choice_.data.empty())
        fail_without_data({{"a temperature, which is no rate", {set_.described(columns_[requested_[0]])}}});
    }
    if (choice_.stamps.empty() && !options_.rate_hz) {
      set_.fail_at_header("has no time column and no rate is given; give the sample rate: --rate HZ");
    }
    note_unused_unit();
    make_names_differ();
    return std::move(choice_);
  }

 private:
  // --- --column ---

  std::vector<std::size_t> requested_columns() const {
    std::vector<std::size_t> result;
    const auto add = [&](std::size_t i) {
      if (std::ranges::find(result, i) == result.end()) result.push_back(i);
    };
    for (const std::string& wanted : options_.columns) {
      if (const auto found = set_.find(wanted)) {
        add(*found);
        continue;
      }
      for (const std::string_view part : split(wanted, ',')) {  // --column gx,gy,gz
        add(set_.get(part));
      }
    }
    return result;
  }

  bool is_requested(const Column& c) const { return std::ranges::find(requested_, c.index) != requested_.end(); }
  bool is_the_temperature(const Column& c) const {
    return choice_.temperature && choice_.temperature->index == c.index;
  }
  bool is_time(const Column& c) const {
    return std::ranges::any_of(choice_.stamps, [&](const StampColumn& s) { return s.index == c.index; });
  }

  void use_given_clock() {
    if (options_.time) set_.fail_at_header("has a clock of its own; leave out --time");
    choice_.stamps = {{*clock_, 1}};
    choice_.time_name = set_.described(columns_[*clock_]);
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
    choice_.notes.push_back(
        best->unit_text.empty()
            ? fmt::format("{} is read as the temperature in degC, by its name", set_.described(*best))
            : fmt::format("{} is read as the temperature", set_.described(*best)));
  }

  void choose_rows() {
    if (!options_.rows) return;
    const Column& c = columns_[set_.get(options_.rows->column)];
    choice_.rows_of =
        DataColumn{.index = c.index, .name = c.name, .signal = Signal::dimensionless, .word = options_.rows->word};
    if (is_time(c) || is_requested(c))
      set_.fail_at_heading(c, fmt::format("{} is {}; rows are chosen by another column", set_.described(c),
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
    if (!requested && !c.unit && !clock_ && set_.is_empty(c)) return refused("empty");
    if (options_.input != Input::angle && !choice_.time_asked && looks_like_a_clock(set_, c)) {
      return refused(fmt::format("rises like a time or a counter{}",
                                 requested ? "; tell what the time is with --time (--time none: this is none)" : ""));
    }
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
    if (!verdict.data) set_.fail_at_heading(c, fmt::format("{}: {}", set_.described(c), verdict.reason));
    if (!c.unit && !means_counts(c.unit_text)) {
      choice_.notes.push_back(fmt::format("{}: the unit {} is not understood, --unit {} is used", set_.described(c),
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
                                      set_.described(c), layout_.headings.empty() ? "gyro_x" : c.name, usual, usual);
    if (const std::string_view hint = unit_hint(c.name); !hint.empty()) {
      const auto unit = noise::parse_unit(hint);
      message += fmt::format("; if its name stands for {}, give --unit {}", hint, hint);
      if (!signal_of(options_.input, unit.dimension)) message += fitting_input(unit.dimension);
    } else if (!c.unit_text.empty()) {
      message += "; counts need --scale (units per count) and --unit";
    }
    if (choice_.stamps.empty() && !options_.rate_hz) message += "; there is no time column either: give --rate HZ too";
    set_.fail_at_heading(c, message);
  }

  [[noreturn]] void fail_without_data(const std::vector<LeftOut>& left_out) const {
    if (left_out.empty())
      set_.fail_at_header("holds time and no data column, expected a gyro or an accelerometer beside it");

    std::vector<std::string> found;
    for (const LeftOut& l : left_out) found.push_back(text(l));
    set_.fail_at_header(
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

  ColumnSet set_;
  const std::vector<Column>& columns_;
  const Layout& layout_;
  const LogOptions& options_;
  std::optional<std::size_t> clock_;
  std::optional<Unit> given_unit_;
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
