// SPDX-License-Identifier: MIT
#include "gyrobudget/io/log.h"

#include "gyrobudget/io/binary.h"
#include "gyrobudget/io/columns.h"
#include "gyrobudget/io/grid.h"
#include "gyrobudget/io/layout.h"
#include "gyrobudget/io/source.h"
#include "gyrobudget/io/table.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::io {
namespace {

void check(const LogOptions& options) {
  if (options.rate_hz && !(std::isfinite(*options.rate_hz) && *options.rate_hz > 0)) {
    throw std::invalid_argument(
        fmt::format("rate_hz is {} Hz; it must be above 0 and finite", *options.rate_hz));
  }
  if (!std::isfinite(options.scale) || options.scale == 0) {
    throw std::invalid_argument(fmt::format("scale is {}; it must be finite and not 0", options.scale));
  }
  if (options.file_columns < 1) {
    throw std::invalid_argument(
        fmt::format("file_columns is {}; it must be at least 1", options.file_columns));
  }
}

/// n angles give n - 1 rates.
std::int64_t fewest_rows(Input input) { return input == Input::angle ? 3 : 2; }

void check_length(const std::string& source, std::int64_t found, Input input, std::string_view what,
                  std::string_view where) {
  if (found >= fewest_rows(input)) return;
  fail(source, fmt::format("holds {} {}{}{}, expected at least {}; record longer: a datasheet needs hours",
                           found, what, found == 1 ? "" : "s", where, fewest_rows(input)));
}

std::int64_t count_numbers(const std::vector<double>& values) {
  return std::ranges::count_if(values, [](double v) { return !std::isnan(v); });
}

// --- From what the file holds to rates -----------------------------------------------------------------------------

/// Unwraps an angle that is kept within one turn. @returns how often it went round
std::int64_t unwrap(std::vector<double>& angle) {
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kRounding = 1e-6;
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (const double a : angle) {
    least = std::fmin(least, a);
    most = std::fmax(most, a);
  }
  if (most - least > kTurn * (1 + kRounding)) return 0;
  std::int64_t turns = 0;
  double offset = 0;
  double before = std::numeric_limits<double>::quiet_NaN();
  for (double& a : angle) {
    const double step = a - before;  // NaN at the start and behind a gap: no turn can be told
    if (std::abs(step) > kTurn / 2) {
      offset -= std::copysign(kTurn, step);
      ++turns;
    }
    before = a;
    a += offset;
  }
  return turns;
}

/// @returns how often an angle was unwrapped
std::int64_t to_rate(std::vector<double>& values, Input input, noise::Signal signal, double rate_hz) {
  if (input == Input::increment) {
    for (double& v : values) v *= rate_hz;
  }
  if (input != Input::angle) return 0;
  const std::int64_t turns = signal == noise::Signal::angular_rate ? unwrap(values) : 0;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) values[i] = (values[i + 1] - values[i]) * rate_hz;
  values.pop_back();
  return turns;
}

/// Grid points at which any axis has no number.
std::int64_t count_missing(const Record& record) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto in_range = [&](const Range& range, std::int64_t sum) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      bool missing = false;
      for (const Axis& axis : record.axes) missing |= std::isnan(axis.rate[i]);
      sum += missing ? 1 : 0;
    }
    return sum;
  };
  return tbb::parallel_reduce(Range(0, static_cast<std::size_t>(record.samples)), std::int64_t{0}, in_range,
                              std::plus<>());
}

void append(std::vector<std::string>& notes, std::vector<std::string> more) {
  std::ranges::move(more, std::back_inserter(notes));
}

/// Notes on how the text was read, where it was not the obvious way.
std::vector<std::string> notes_on_text(const Source& source, const Layout& layout, const Table& table) {
  std::vector<std::string> notes;
  if (source.unpacked()) notes.emplace_back("gzip was unpacked into memory");
  if (layout.dialect.decimal_comma) notes.emplace_back("commas are read as decimal marks");
  if (table.inner_blank > 0)
    notes.push_back(fmt::format("{} blank lines among the rows are skipped", table.inner_blank));
  return notes;
}

Grid grid_of(Table& table, const Choice& choice, const TableReader& reader, const std::string& source,
             const LogOptions& options) {
  if (choice.stamps.empty()) return {*options.rate_hz, static_cast<std::int64_t>(table.rows), {}, {}};
  const std::vector<std::int64_t> stamps = std::exchange(table.stamps, {});  // freed here
  return make_grid(stamps, options.rate_hz,
                   {source, choice.time_name, [&](std::size_t row) { return reader.line_of_row(row); }});
}

/// Columns of numbers, read but not yet rates.
struct Raw {
  std::string source;
  Choice choice;
  Table table;
  Grid grid;
  std::vector<std::string> notes;
};

Raw read_text(const LogOptions& options) {
  const Source source(options.path);
  const Layout layout = read_layout(source);
  Raw raw{source.name(), choose_columns(source.name(), layout, options), {}, {}, {}};
  const TableReader reader(source, layout, options.chunk_bytes);
  raw.table = reader.read(raw.choice);
  check_length(raw.source, static_cast<std::int64_t>(raw.table.rows), options.input, "sample", "");
  raw.grid = grid_of(raw.table, raw.choice, reader, raw.source, options);
  raw.notes = notes_on_text(source, layout, raw.table);
  return raw;
}

Raw read_binary(const LogOptions& options, Format format) {
  const Source source(options.path, Content::bytes);
  const std::string_view bytes = source.text();
  const BinaryLayout layout = binary_layout(source.name(), bytes, format, options.file_columns);
  const std::string_view body = bytes.substr(layout.offset);
  const std::int64_t rows = count_rows(source.name(), layout, body.size());
  check_length(source.name(), rows, options.input, "sample", "");
  Raw raw{source.name(),
          choose_binary_columns(source.name(), layout, options),
          {},
          {*options.rate_hz, rows, {}, {}},
          {}};
  raw.table.rows = static_cast<std::size_t>(rows);
  raw.table.complete = false;
  raw.table.numbers.assign(raw.choice.data.size(), std::vector<double>(raw.table.rows));
  decode(body, layout, raw.choice,
         std::vector<std::span<double>>(raw.table.numbers.begin(), raw.table.numbers.end()));
  return raw;
}

}  // namespace

Record read_log(const LogOptions& options) {
  check(options);
  const Format format = options.format.value_or(format_of(options.path));
  Raw raw = format == Format::csv ? read_text(options) : read_binary(options, format);
  Table& table = raw.table;

  Record record;
  record.source = raw.source;
  record.rate_hz = raw.grid.rate_hz;
  record.notes = std::move(raw.notes);
  append(record.notes, std::move(raw.choice.notes));
  append(record.notes, std::move(raw.grid.notes));

  const bool complete = table.complete && raw.grid.places.empty();
  const std::size_t axes = raw.choice.data.size();
  std::vector<std::int64_t> turns(axes), numbers(axes);
  tbb::parallel_for(std::size_t{0}, axes, [&](std::size_t i) {
    put_on_grid(raw.grid, table.numbers[i]);
    numbers[i] = complete ? static_cast<std::int64_t>(table.rows) : count_numbers(table.numbers[i]);
    turns[i] = to_rate(table.numbers[i], options.input, raw.choice.data[i].signal, raw.grid.rate_hz);
  });
  for (std::size_t i = 0; i < axes; ++i) {
    const DataColumn& column = raw.choice.data[i];
    check_length(raw.source, numbers[i], options.input, "number", " in column " + quoted(column.name));
    if (turns[i] > 0) {
      record.notes.push_back(fmt::format("{} is unwrapped {} times", quoted(column.name), turns[i]));
    }
    record.axes.push_back({column.name, column.signal, std::move(table.numbers[i])});
  }
  record.samples = static_cast<std::int64_t>(record.axes.front().rate.size());
  record.missing_samples = complete ? 0 : count_missing(record);
  return record;
}

}  // namespace gyrobudget::inline v0::io
