// SPDX-License-Identifier: MIT
#include "inspect.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "binary.h"
#include "bytes.h"
#include "columns.h"
#include "layout.h"
#include "recorded.h"
#include "table.h"

namespace gyrobudget::inline v0::log {
namespace {

// --- Numbers of a stream -------------------------------------------------------------------------------------------

void summarise(InspectedColumn& column, const std::vector<double>& values) {
  double mean = 0, squares = 0, least = HUGE_VAL, most = -HUGE_VAL;
  for (const double x : values) {
    if (!std::isfinite(x)) continue;
    const double n = static_cast<double>(++column.numbers), off = x - mean;
    mean += off / n;
    squares += off * (x - mean);
    least = std::min(least, x), most = std::max(most, x);
  }
  if (column.numbers == 0) return;
  column.mean = mean, column.least = least, column.most = most;
  if (column.numbers > 1) column.std = std::sqrt(squares / static_cast<double>(column.numbers - 1));
}

/// What the stamps say; those that are missing are left out.
void look_at_clock(InspectedStream& stream, std::vector<std::int64_t> stamps) {
  std::erase(stamps, text::kNoStamp);
  if (stamps.empty()) return;
  stream.first_ns = stamps.front(), stream.last_ns = stamps.back();
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double step = static_cast<double>(stamps[i]) - static_cast<double>(stamps[i - 1]);
    // Of stamps near one another the difference is exact as whole numbers, which as doubles it is not.
    std::int64_t exact = 0;
    steps.push_back(__builtin_sub_overflow(stamps[i], stamps[i - 1], &exact) ? step : static_cast<double>(exact));
    stream.repeats += steps.back() == 0;
    stream.back += steps.back() < 0;
  }
  std::vector<double> rising;
  std::ranges::copy_if(steps, std::back_inserter(rising), [](double s) { return s > 0; });
  if (rising.empty()) return;
  const auto middle = rising.begin() + static_cast<std::ptrdiff_t>(rising.size() / 2);
  std::ranges::nth_element(rising, middle);
  const double median = *middle;
  constexpr double kGap = 1.5;
  stream.gaps = std::ranges::count_if(rising, [&](double s) { return s > kGap * median; });
  stream.largest_gap_s = *std::ranges::max_element(rising) * noise::kNanosecond;
  stream.rate_hz = 1 / (median * noise::kNanosecond);
  const double span = std::accumulate(steps.begin(), steps.end(), 0.0) * noise::kNanosecond;
  if (span > 0) stream.mean_rate_hz = static_cast<double>(steps.size()) / span;
}

std::string count_text(std::int64_t n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

/// "'x' is", "'x', 'y' and 3 more are"
std::string some(std::vector<std::string> names, const char* one, const char* several) {
  constexpr std::size_t kListed = 4;
  const char* verb = names.size() == 1 ? one : several;
  if (names.size() > kListed + 1) {
    const std::size_t more = names.size() - kListed;
    names.resize(kListed);
    names.push_back(fmt::format("{} more", more));
  }
  return fmt::format("{} {}", text::listing(names), verb);
}

void say_what_is_odd(InspectedStream& s) {
  if (s.back > 0) s.odd.push_back(fmt::format("its time goes back {}", count_text(s.back, "time")));
  if (s.repeats > 0) s.odd.push_back(fmt::format("{} the stamp before", count_text(s.repeats, "row") + " repeat"));
  if (s.gaps > 0)
    s.odd.push_back(fmt::format("{}, the longest of {:.3g} s", count_text(s.gaps, "gap"), *s.largest_gap_s));
  std::vector<std::string> empty;
  std::map<double, std::vector<std::string>> constant;
  for (const InspectedColumn& c : s.columns) {
    const std::string name = text::quoted(c.name);
    if (c.numbers == 0)
      empty.push_back(name);
    else if (c.std && *c.std == 0 && c.numbers > 2)
      constant[*c.mean].push_back(name);
    else if (c.numbers < s.samples)
      s.odd.push_back(fmt::format("{} lacks {}", name, count_text(s.samples - c.numbers, "number")));
  }
  if (!empty.empty()) s.odd.push_back(fmt::format("{} no number", some(empty, "holds", "hold")));
  for (const auto& [value, names] : constant)
    s.odd.push_back(fmt::format("{} {} throughout", some(names, "is", "are"), value));
}

// --- Recordings ----------------------------------------------------------------------------------------------------

/// @param with_numbers  what its columns hold too, which has to read them
InspectedStream looked_at(const Recording& recording, std::size_t place, bool with_numbers) {
  const StreamInfo& info = recording.streams()[place];
  InspectedStream stream{.name = info.name,
                         .type = info.type,
                         .kind = info.kind,
                         .samples = info.count,
                         .is_read = !info.fields.empty(),
                         .clock = info.clock};
  for (const Field& f : info.fields) stream.columns.push_back({f.name, f.unit, f.unit_from});
  if (!with_numbers) return stream;
  std::vector<std::size_t> fields(info.fields.size());
  std::iota(fields.begin(), fields.end(), std::size_t{0});
  Rows rows = recording.read(place, fields);
  for (std::size_t i = 0; i < fields.size(); ++i) summarise(stream.columns[i], rows.columns[i]);
  if (!rows.columns.empty()) stream.samples = static_cast<std::int64_t>(rows.columns[0].size());
  if (!rows.clock.empty()) stream.clock = rows.clock;
  look_at_clock(stream, std::move(rows.stamps_ns));
  stream.odd = std::move(rows.notes);
  say_what_is_odd(stream);
  return stream;
}

Inspection of_recording(const Recording& recording, const std::string& path) {
  Inspection result{.source = text::input_name(path), .format = recording.format(), .notes = recording.notes()};
  const std::vector<std::size_t> sensors = sensor_streams(recording);
  for (std::size_t i = 0; i < recording.streams().size(); ++i) {
    const StreamInfo& info = recording.streams()[i];
    const bool is_sensor = std::ranges::find(sensors, i) != sensors.end();
    const bool with_numbers = !info.fields.empty() && (is_sensor || info.kind != StreamKind::other);
    result.streams.push_back(looked_at(recording, i, with_numbers));
  }
  for (const std::size_t i : sensors) {
    const InspectedStream& s = result.streams[i];
    if (!s.is_read) continue;
    std::string line = text::shell_word(path);
    if (sensors.size() > 1) line += " --topic " + text::shell_word(s.name);
    const bool has_unit = std::ranges::any_of(s.columns, [](const auto& c) { return !c.unit.empty(); });
    if (!has_unit) line += " --unit UNIT";
    if (s.clock.empty()) line += " --rate HZ";
    result.calibrate.push_back(line);
  }
  return result;
}

// --- Text and .npy -------------------------------------------------------------------------------------------------

/// Whether the first rows of a column hold numbers.
bool holds_numbers(const Layout& layout, std::size_t column) {
  return std::ranges::any_of(layout.sample, [&](const auto& row) {
    double value = 0;
    return column < row.size() &&
           text::parse_number(row[column], layout.dialect.decimal_comma, value) == text::Cell::number;
  });
}

/// What the units of the columns are of.
StreamKind kind_by_units(const std::vector<InspectedColumn>& columns) {
  bool turns = false, accelerates = false;
  for (const InspectedColumn& c : columns) {
    try {
      const noise::Dimension d = noise::parse_unit(c.unit).dimension;
      turns = turns || d == noise::dimension::kAngularRate;
      accelerates = accelerates || d == noise::dimension::kSpecificForce;
    } catch (const std::invalid_argument&) {
      // of another kind, or none
    }
  }
  if (turns) return accelerates ? StreamKind::imu : StreamKind::gyroscope;
  return accelerates ? StreamKind::accelerometer : StreamKind::other;
}

Inspection of_text(const std::string& path) {
  const Bytes source(path);
  const Layout layout = read_layout(source);
  Inspection result{.source = source.name(), .format = "text"};
  InspectedStream& stream = result.streams.emplace_back(InspectedStream{.name = "rows", .is_read = true});
  Choice all;
  for (std::size_t i = 0; i < layout.columns; ++i) {
    InspectedColumn& column = stream.columns.emplace_back();
    column.name = layout.headings.empty() || layout.headings[i].name.empty() ? fmt::format("column {}", i + 1)
                                                                             : layout.headings[i].name;
    if (!layout.headings.empty()) column.unit = layout.headings[i].unit;
    if (!column.unit.empty()) column.unit_from = "header";
  }
  stream.kind = kind_by_units(stream.columns);
  std::string line = text::shell_word(path);
  try {
    const Choice chosen = choose_columns(source.name(), layout, {.path = path});
    all.stamps = chosen.stamps;
    stream.clock = chosen.time_name;
    result.notes = chosen.notes;
  } catch (const text::InputError& error) {
    stream.odd.push_back(fmt::format("calibrate needs more: {}", error.what()));
    line += " --unit UNIT --rate HZ";
  }
  const auto is_stamp = [&](std::size_t i) {
    return std::ranges::find(all.stamps, i, &StampColumn::index) != all.stamps.end();
  };
  for (std::size_t i = 0; i < layout.columns; ++i)
    if (!is_stamp(i) && holds_numbers(layout, i)) all.data.push_back({.index = i, .name = stream.columns[i].name});
  constexpr std::size_t kPiece = std::size_t{1} << 20;  // of the text for one task
  Table table = TableReader(source, layout, kPiece).read(all);
  for (std::size_t i = 0; i < all.data.size(); ++i) summarise(stream.columns[all.data[i].index], table.numbers[i]);
  stream.samples = static_cast<std::int64_t>(table.rows);
  for (const StampColumn& s : all.stamps)
    stream.columns[s.index].numbers = std::ranges::count_if(table.stamps, [](auto t) { return t != text::kNoStamp; });
  look_at_clock(stream, std::move(table.stamps));
  say_what_is_odd(stream);
  result.calibrate.push_back(line);
  return result;
}

Inspection of_npy(const std::string& path) {
  const Bytes source(path, Content::bytes);
  const BinaryLayout layout = binary_layout(source.name(), source.text(), Format::npy, 1);
  Inspection result{.source = source.name(), .format = "NumPy .npy"};
  InspectedStream& stream = result.streams.emplace_back(InspectedStream{.name = "rows", .is_read = true});
  const std::string_view body = source.text().substr(layout.offset);
  stream.samples = count_rows(source.name(), layout, body.size());
  Choice all;
  for (std::int64_t i = 0; i < layout.columns; ++i)
    all.data.push_back({.index = static_cast<std::size_t>(i), .name = binary_column_name(i)});
  std::vector<std::vector<double>> numbers(all.data.size(),
                                           std::vector<double>(static_cast<std::size_t>(stream.samples)));
  decode(body, layout, all, std::vector<std::span<double>>(numbers.begin(), numbers.end()));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    summarise(stream.columns.emplace_back(InspectedColumn{.name = all.data[i].name}), numbers[i]);
  say_what_is_odd(stream);
  result.calibrate.push_back(text::shell_word(path) + " --unit UNIT --rate HZ");
  return result;
}

}  // namespace

Inspection inspect(const std::string& path) {
  if (const auto recording = open_recording(path)) return of_recording(*recording, path);
  return format_of_input(path) == Format::npy ? of_npy(path) : of_text(path);
}

}  // namespace gyrobudget::inline v0::log
