// SPDX-License-Identifier: MIT
#include "named_columns.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

// "0.1 arcsec" is a unit too: that of a count.
noise::Unit unit_with_factor(std::string_view text) {
  double factor = 1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), factor);
  const std::string_view rest = text::trim(text.substr(static_cast<std::size_t>(end - text.data())));
  if (error != std::errc{} || rest.empty() || factor == 0 || !std::isfinite(factor)) return noise::parse_unit(text);
  noise::Unit unit = noise::parse_unit(rest);
  unit.to_si *= factor;
  return unit;
}

std::string examples(const std::vector<noise::Dimension>& dimensions) {
  std::string text;
  for (const auto& d : dimensions) text += (text.empty() ? "" : "; ") + noise::example_units(d);
  return text;
}

}  // namespace

std::optional<NamedColumns::Mapped> NamedColumns::mapped(const Wanted& wanted) const {
  const auto at = map_.find(std::string(wanted.name));
  if (at == map_.end()) return std::nullopt;
  const std::string_view text = text::trim(at->second);
  const std::size_t open = text.find(" (");
  if (open == std::string_view::npos || !text.ends_with(')')) return Mapped{std::string(text), {}};
  return Mapped{std::string(text::trim(text.substr(0, open))),
                std::string(text.substr(open + 2, text.size() - open - 3))};
}

std::optional<std::size_t> NamedColumns::place(std::string_view name) const {
  for (std::size_t i = 0; i < layout_.headings.size(); ++i) {
    if (layout_.headings[i].name == name) return i;
  }
  std::size_t number = 0;  // a column by its number, from 1
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error == std::errc{} && end == name.data() + name.size() && number >= 1 && number <= layout_.columns)
    return number - 1;
  return std::nullopt;
}

std::optional<std::size_t> NamedColumns::find(const Wanted& wanted) const {
  if (const auto given = mapped(wanted)) {
    if (const auto index = place(given->name)) return index;
    std::vector<std::string> names;
    for (const Heading& h : layout_.headings) names.push_back(h.name);
    text::fail(source_, fmt::format("found no column {} for {}{}{}", text::quoted(given->name), wanted.name,
                                    text::suggestion(given->name, names),
                                    names.empty() ? fmt::format("; without a header columns are numbers from 1 to {}",
                                                                layout_.columns)
                                                  : "; there are " + text::listing(names)));
  }
  for (std::size_t i = 0; i < layout_.headings.size(); ++i) {
    const std::string name = text::lower(layout_.headings[i].name);
    if (name.empty()) continue;
    if (name == wanted.name || std::ranges::find(wanted.others, name) != wanted.others.end()) return i;
  }
  return std::nullopt;
}

std::pair<DataColumn, std::size_t> NamedColumns::get(const Wanted& wanted,
                                                     const std::vector<noise::Dimension>& dimensions) const {
  const auto index = find(wanted);
  if (!index) text::fail(source_, fmt::format("found no column {}, {}", text::quoted(wanted.name), expected_));
  const Heading heading =
      layout_.headings.empty() ? Heading{std::to_string(*index + 1), {}, 1} : layout_.headings[*index];
  const auto given = mapped(wanted);
  const std::string unit = given && !given->unit.empty() ? given->unit : heading.unit;
  DataColumn column{*index, heading.name, {}, 1};
  if (unit.empty() && dimensions.front() == noise::dimension::kNumber) return {column, 0};
  std::string found = unit.empty() ? "no unit" : "the unit " + text::quoted(unit);
  try {
    if (!unit.empty()) {
      const noise::Unit parsed = unit_with_factor(unit);
      column.to_si = parsed.to_si;
      const auto at = std::ranges::find(dimensions, parsed.dimension);
      if (at != dimensions.end()) return {column, static_cast<std::size_t>(at - dimensions.begin())};
    }
  } catch (const std::invalid_argument& error) {
    found += fmt::format(" ({})", error.what());
  }
  const std::string example = noise::example_units(dimensions.front());
  const bool has_header = layout_.heading_line > 0;
  const std::string message =
      fmt::format("column {} has {}, expected one like {}, in {} as in \"{} ({})\"", text::quoted(heading.name), found,
                  examples(dimensions), has_header ? "the header" : "the columns that are asked for", heading.name,
                  example.substr(0, example.find(',')));
  if (has_header) text::fail_at(source_, layout_.heading_line, heading.column, message);
  text::fail(source_, message);
}

DataColumn NamedColumns::get(const Wanted& wanted) const { return get(wanted, {wanted.dimension}).first; }

void add_stamps(Choice& choice, const DataColumn& time) {
  choice.stamps.push_back({time.index, std::llround(time.to_si * noise::kNanosecondsPerSecond)});
  choice.time_name = time.name;
}

}  // namespace gyrobudget::inline v0::log
