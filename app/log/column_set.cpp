// SPDX-License-Identifier: MIT
#include "column_set.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dialects.h"
#include "top_lines.h"

namespace gyrobudget::inline v0::log {
namespace {

std::optional<noise::Unit> try_unit(const std::string& text) {
  try {
    return noise::parse_unit(text);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

bool means_counts(const std::string& unit) {
  static const std::vector<std::string> kWords = {"count", "counts", "cnt", "lsb",   "raw", "adc",
                                                  "digit", "digits", "-",   "ticks", ""};
  return std::ranges::find(kWords, text::lower(unit)) != kWords.end();
}

ColumnSet::ColumnSet(const std::string& source, const Layout& layout, bool unit_is_given)
    : source_(source), layout_(layout) {
  for (std::size_t i = 0; i < layout.columns; ++i) columns_.push_back(column(i));
  const auto dialect = recognise(layout);
  if (!dialect) return;
  for (Column& c : columns_) {
    const ToldUnit& told = dialect->columns[c.index];
    if (!c.unit_text.empty() || told.unit.empty()) continue;
    noise::Unit unit = noise::parse_unit(told.unit);
    // What the file itself says of its counts holds whatever the user takes them for.
    if (unit_is_given && unit.dimension != noise::dimension::kTime && told.scale == 1) continue;
    unit.to_si *= told.scale;
    c.unit = unit;
    c.unit_text = told.unit;
    dialect_note_ = dialect->note;
  }
}

Column ColumnSet::column(std::size_t i) const {
  if (layout_.headings.empty()) return {i, fmt::format("column {}", i + 1), {}, {}, 1};
  const Heading& h = layout_.headings[i];
  return {i, h.name.empty() ? fmt::format("column {}", i + 1) : h.name, h.unit,
          h.unit.empty() ? std::nullopt : try_unit(h.unit), h.column};
}

std::string ColumnSet::described(const Column& c) const {
  return layout_.headings.empty() ? c.name : fmt::format("column {}", text::quoted(c.name));
}

std::optional<std::size_t> ColumnSet::find(std::string_view wanted) const {
  const auto first = [&](auto same) -> std::optional<std::size_t> {
    const auto found = std::ranges::find_if(columns_, same);
    return found == columns_.end() ? std::nullopt : std::optional(found->index);
  };
  if (const auto exact = first([&](const Column& c) { return c.name == wanted; })) return exact;
  if (const auto loose = first([&](const Column& c) {
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

std::size_t ColumnSet::get(std::string_view wanted) const {
  if (const auto found = find(wanted)) return *found;
  std::vector<std::string> names;
  names.reserve(columns_.size());
  for (const Column& c : columns_) names.push_back(c.name);
  const std::string numbers =
      columns_.size() == 1 ? "there is column 1" : fmt::format("there are columns 1 to {}", columns_.size());
  constexpr std::size_t kListed = 20;
  std::vector<std::string> listed(names.begin(), names.begin() + std::ptrdiff_t(std::min(names.size(), kListed)));
  if (names.size() > kListed) listed.emplace_back("more");
  fail_at_header(fmt::format("has no column {}{}; {}{}", text::quoted(wanted), text::suggestion(wanted, names), numbers,
                             layout_.headings.empty() ? "" : ": " + text::listing(listed)));
}

void ColumnSet::fail_at_heading(const Column& c, const std::string& message) const {
  if (layout_.heading_line == 0) text::fail_at(source_, layout_.body_line, 1, message);
  text::fail_at(source_, layout_.heading_line, c.place, message);
}

void ColumnSet::fail_at_header(const std::string& message) const {
  const std::int64_t line = layout_.heading_line != 0 ? layout_.heading_line : layout_.body_line;
  if (line == 0) text::fail(source_, message);  // a recording has no lines
  text::fail_at(source_, line, 1, message);
}

std::vector<std::string_view> ColumnSet::cells(const Column& c) const {
  std::vector<std::string_view> cells;
  for (const auto& row : layout_.sample)
    if (c.index < row.size()) cells.push_back(row[c.index]);
  return cells;
}

bool ColumnSet::is_empty(const Column& c) const {
  const auto found = cells(c);
  return !found.empty() && std::ranges::all_of(found, is_missing);
}

bool ColumnSet::holds_stamps(const Column& c) const {
  return std::ranges::any_of(cells(c), [&](std::string_view cell) {
    std::int64_t ns = 0;
    return text::parse_stamp(cell, layout_.dialect.decimal_comma, 1, ns) != text::Cell::text;
  });
}

std::optional<StampForm> ColumnSet::calendar(const Column& c) const {
  std::optional<StampForm> form;
  for (const std::string_view cell : cells(c)) {
    if (is_missing(cell)) continue;
    const auto found = calendar_form(cell);
    if (!found || (form && *form != *found)) return std::nullopt;
    form = found;
  }
  return form;
}

std::vector<double> ColumnSet::numbers(const Column& c) const {
  std::vector<double> numbers;
  for (const auto& row : layout_.sample) {
    double value = 0;
    if (c.index >= row.size() ||
        text::parse_number(row[c.index], layout_.dialect.decimal_comma, value) != text::Cell::number)
      return {};
    numbers.push_back(value);
  }
  return numbers;
}

}  // namespace gyrobudget::inline v0::log
