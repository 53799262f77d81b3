// SPDX-License-Identifier: MIT
#include "inspection.h"

#include "gyrobudget/app/log/calendar.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

#include "json_text.h"
#include "layout.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using log::InspectedColumn;
using log::InspectedStream;
using Json = nlohmann::ordered_json;

// --- Text ----------------------------------------------------------------------------------------------------------

/// "2012-11-14 15:40:14.798 UTC" for a stamp that may be since 1970; else "47.58 s".
/// @param clock  its name, which may be that of another scale
std::string stamp_text(std::int64_t ns, const std::string& clock) {
  constexpr std::int64_t kYear2000 = 946'684'800, kYear2100 = 4'102'444'800;
  const std::int64_t seconds = ns / noise::kNanosecondsPerSecond;
  if (seconds < kYear2000 || seconds > kYear2100)
    return fmt::format("{:.6f} s", static_cast<double>(ns) * noise::kNanosecond);
  return fmt::format("{} {}", log::calendar_text(ns), clock == "GPST" || clock == "JST" ? clock : "UTC");
}

std::string rate_text(const InspectedStream& s) { return s.rate_hz ? fmt::format("{:.5g} Hz", *s.rate_hz) : "-"; }

std::string kind_text(const InspectedStream& s) {
  return s.kind == log::StreamKind::other ? (s.is_read ? "" : "not read") : std::string(log::name(s.kind));
}

std::string streams_table(const log::Inspection& log) {
  using enum Align;
  TextTable table({left, left, left, right, right});
  table.row({"stream", "type", "kind", "rows", "rate"});
  for (const InspectedStream& s : log.streams)
    table.row({printable(s.name), printable(s.type), kind_text(s), count_text(s.samples), rate_text(s)});
  return table.text();
}

std::string columns_table(const InspectedStream& s) {
  using enum Align;
  TextTable table({left, left, left, right, right, right, right});
  table.row({"  column", "unit", "from", "mean", "std", "least", "most"});
  const auto cell = [](const std::optional<double>& x) { return x ? fmt::format("{:.6g}", *x) : std::string("-"); };
  for (const InspectedColumn& c : s.columns)
    table.row({"  " + printable(c.name), c.unit.empty() ? "-" : printable(c.unit), printable(c.unit_from), cell(c.mean),
               cell(c.std), cell(c.least), cell(c.most)});
  return table.text();
}

/// Its numbers were read, not only its rows counted.
bool is_looked_at(const InspectedStream& s) { return s.first_ns || s.columns.empty() || s.columns.front().numbers > 0; }

std::string stream_text(const InspectedStream& s) {
  std::string text = fmt::format("\n{}\n", printable(s.name));
  if (s.first_ns)
    text += wrapped(fmt::format("Clock: {}, from {} to {}; median rate {}, mean rate {}.", printable(s.clock),
                                stamp_text(*s.first_ns, s.clock), stamp_text(*s.last_ns, s.clock), rate_text(s),
                                s.mean_rate_hz ? fmt::format("{:.5g} Hz", *s.mean_rate_hz) : "unknown"),
                    "  ", "    ");
  else
    text += "  Clock: none was found.\n";
  for (const std::string& odd : s.odd) text += wrapped("Odd: " + printable(odd) + ".", "  ", "    ");
  return text + columns_table(s);
}

// --- JSON ----------------------------------------------------------------------------------------------------------

Json or_null(const std::optional<double>& value) { return value ? number_or_null(*value) : Json(nullptr); }

Json stamp_json(const std::optional<std::int64_t>& ns) {
  return ns ? Json(static_cast<double>(*ns) * noise::kNanosecond) : Json(nullptr);
}

Json column_json(const InspectedColumn& c) {
  return {{"name", c.name},
          {"unit", c.unit.empty() ? Json(nullptr) : Json(c.unit)},
          {"unit_source", c.unit_from.empty() ? Json(nullptr) : Json(c.unit_from)},
          {"numbers", c.numbers},
          {"mean", or_null(c.mean)},
          {"std", or_null(c.std)},
          {"least", or_null(c.least)},
          {"most", or_null(c.most)}};
}

Json stream_json(const InspectedStream& s) {
  Json columns = Json::array();
  for (const InspectedColumn& c : s.columns) columns.push_back(column_json(c));
  return {{"name", s.name},
          {"type", s.type},
          {"kind", log::name(s.kind)},
          {"samples", s.samples},
          {"read", s.is_read},
          {"clock", s.clock.empty() ? Json(nullptr) : Json(s.clock)},
          {"rate_hz", or_null(s.rate_hz)},
          {"mean_rate_hz", or_null(s.mean_rate_hz)},
          {"first_s", stamp_json(s.first_ns)},
          {"last_s", stamp_json(s.last_ns)},
          {"gaps", s.gaps},
          {"largest_gap_s", or_null(s.largest_gap_s)},
          {"repeats", s.repeats},
          {"back", s.back},
          {"odd", s.odd},
          {"columns", columns}};
}

}  // namespace

std::string inspection_text(const InspectionResult& result) {
  const log::Inspection& log = result.log;
  std::string text = fmt::format("{}: {}\n\n", printable(log.source), log.format) + streams_table(log);
  for (const InspectedStream& s : log.streams)
    if (s.is_read && is_looked_at(s)) text += stream_text(s);
  if (!log.notes.empty()) text += "\n";
  for (const std::string& note : log.notes) text += wrapped("Note: " + printable(note) + ".", "", "  ");
  if (!log.calibrate.empty()) text += "\nNext:\n";
  for (const std::string& line : log.calibrate) text += fmt::format("  gyrobudget calibrate {}\n", printable(line));
  return text;
}

std::string inspection_json(const InspectionResult& result) {
  const log::Inspection& log = result.log;
  Json streams = Json::array(), commands = Json::array();
  for (const InspectedStream& s : log.streams) streams.push_back(stream_json(s));
  for (const std::string& line : log.calibrate) commands.push_back("gyrobudget calibrate " + line);
  return dense_json({{"schema", "gyrobudget.inspect/1"},
                     {"version", kVersion},
                     {"command", result.command},
                     {"source", log.source},
                     {"format", log.format},
                     {"streams", streams},
                     {"notes", log.notes},
                     {"next", commands}});
}

}  // namespace gyrobudget::inline v0::report
