// SPDX-License-Identifier: MIT
#include "curve_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "bytes.h"
#include "columns.h"
#include "layout.h"
#include "table.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;
constexpr std::array kSignals{noise::Signal::angular_rate, noise::Signal::specific_force, noise::Signal::dimensionless};

std::optional<noise::Unit> unit_of(const Heading& heading) {
  if (heading.unit.empty()) return std::nullopt;
  try {
    return noise::parse_unit(heading.unit);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // not a unit: a remark in brackets
  }
}

std::optional<DataColumn> tau_column(const Layout& layout) {
  for (std::size_t i = 0; i < layout.headings.size(); ++i) {
    const Heading& heading = layout.headings[i];
    const auto unit = unit_of(heading);
    if (unit && unit->dimension == noise::dimension::kTime) return DataColumn{i, heading.name, {}, unit->to_si};
    if (!unit && (heading.name == "tau" || heading.name == "tau_s")) return DataColumn{i, heading.name, {}, 1};
  }
  return std::nullopt;
}

bool is_limit(const std::string& name) {
  return std::ranges::any_of(std::array{"lower", "upper", "min", "max"},
                             [&](const char* word) { return name.rfind(word, 0) == 0; });
}

bool is_wanted(const Heading& heading, std::size_t index, const CurveOptions& options, bool has_unit) {
  if (options.columns.empty()) return (has_unit || options.unit) && !is_limit(heading.name);
  return std::ranges::any_of(options.columns, [&](const std::string& wanted) {
    return wanted == heading.name || wanted == std::to_string(index + 1);
  });
}

std::optional<DataColumn> deviation_column(const std::string& source, const Heading& heading, std::size_t index,
                                           const CurveOptions& options) {
  auto unit = unit_of(heading);
  if (!is_wanted(heading, index, options, unit.has_value())) return std::nullopt;
  if (!unit && options.unit) unit = noise::parse_unit(*options.unit);
  if (!unit) {
    throw text::InputError(
        fmt::format("{}: column '{}' has no unit, expected one in the header, as in \"{} (deg/h)\", or --unit", source,
                    heading.name, heading.name));
  }
  for (const auto signal : kSignals) {
    if (noise::dimension_of(signal) == unit->dimension) return DataColumn{index, heading.name, signal, unit->to_si};
  }
  return std::nullopt;  // another quantity: a count, an index
}

Choice choose(const std::string& source, const Layout& layout, const CurveOptions& options) {
  const auto tau = tau_column(layout);
  if (!tau) {
    throw text::InputError(fmt::format(
        "{}: found no column of averaging times, expected a header with one named tau or with a unit of time, as in \"tau (s),adev (deg/h)\"",
        source));
  }
  Choice choice;
  choice.data.push_back(*tau);
  for (std::size_t i = 0; i < layout.headings.size(); ++i) {
    if (i == tau->index) continue;
    if (auto column = deviation_column(source, layout.headings[i], i, options))
      choice.data.push_back(std::move(*column));
  }
  if (choice.data.size() == 1) {
    throw text::InputError(fmt::format(
        "{}: found no column of deviations, expected one with a unit in the header, as in \"adev (deg/h)\", or --unit, or --column",
        source));
  }
  return choice;
}

void check(const allan::DeviationTable& table, const TableReader& reader) {
  for (std::size_t i = 0; i < table.tau_s.size(); ++i) {
    const auto complain = [&](std::string_view what) {
      throw text::InputError(fmt::format("{}:{}: {}", table.source, reader.line_of_row(i), what));
    };
    const bool ascends = i == 0 || table.tau_s[i] > table.tau_s[i - 1];
    if (!(table.tau_s[i] > 0) || !ascends)
      complain("found a tau that is not above the one before; sort the table by tau");
    for (const auto& column : table.columns) {
      if (!(column.deviation[i] > 0)) complain("found a deviation that is not above 0; leave the row out");
    }
  }
}

}  // namespace

allan::DeviationTable read_curve(const CurveOptions& options) {
  const Bytes source(options.path);
  const Layout layout = read_layout(source);
  const Choice choice = choose(source.name(), layout, options);
  const TableReader reader(source, layout, kChunk);
  Table numbers = reader.read(choice);
  allan::DeviationTable table;
  table.source = source.name();
  table.tau_s = std::move(numbers.numbers.front());
  for (std::size_t i = 1; i < choice.data.size(); ++i) {
    table.columns.push_back({choice.data[i].name, choice.data[i].signal, std::move(numbers.numbers[i])});
  }
  check(table, reader);
  return table;
}

}  // namespace gyrobudget::inline v0::log
