// SPDX-License-Identifier: MIT
#include "log.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "binary.h"
#include "bytes.h"
#include "clock.h"
#include "columns.h"
#include "grid.h"
#include "join.h"
#include "layout.h"
#include "recorded.h"
#include "recording.h"
#include "resample.h"
#include "segments.h"
#include "table.h"

namespace gyrobudget::inline v0::log {
namespace {

void check(const LogOptions& options) {
  if (options.rate_hz && !(std::isfinite(*options.rate_hz) && *options.rate_hz > 0)) {
    throw std::invalid_argument(fmt::format("rate_hz is {} Hz; it must be above 0 and finite", *options.rate_hz));
  }
  if (!std::isfinite(options.scale) || options.scale == 0) {
    throw std::invalid_argument(fmt::format("scale is {}; it must be finite and not 0", options.scale));
  }
  if (options.resample_hz && !(std::isfinite(*options.resample_hz) && *options.resample_hz > 0)) {
    throw std::invalid_argument(
        fmt::format("resample_hz is {} Hz; it must be above 0 and finite", *options.resample_hz));
  }
  if (options.file_columns < 1) {
    throw std::invalid_argument(fmt::format("file_columns is {}; it must be at least 1", options.file_columns));
  }
}

/// n angles give n - 1 rates.
std::int64_t fewest_rows(Input input) { return input == Input::angle ? 3 : 2; }

void check_length(const std::string& source, std::int64_t found, Input input, std::string_view what,
                  std::string_view where) {
  if (found >= fewest_rows(input)) return;
  text::fail(source, fmt::format("holds {} {}{}{}, expected at least {}; record longer: a datasheet needs hours", found,
                                 what, found == 1 ? "" : "s", where, fewest_rows(input)));
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
std::int64_t count_missing(const allan::Record& record) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto in_range = [&](const Range& range, std::int64_t sum) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      bool missing = false;
      for (const allan::Axis& axis : record.axes) missing |= std::isnan(axis.rate[i]);
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

void note_compression(const Bytes& source, std::vector<std::string>& notes) {
  if (source.compression() != Compression::none)
    notes.push_back(fmt::format("{} was unpacked into memory", name(source.compression())));
}

/// Notes on how the text was read, where it was not the obvious way.
std::vector<std::string> notes_on_text(const Bytes& source, const Layout& layout, const Table& table) {
  std::vector<std::string> notes = layout.notes;
  note_compression(source, notes);
  if (layout.dialect.decimal_comma) notes.emplace_back("commas are read as decimal marks");
  if (table.inner_blank > 0)
    notes.push_back(fmt::format("{} blank lines among the rows are skipped", table.inner_blank));
  return notes;
}

/// Rows that become one record.
struct Piece {
  Stretch rows;
  std::int64_t line = 1;  ///< of its first row
  Grid grid;
  std::optional<Resampler> resampler;
};

/// Columns of numbers, read but not yet rates.
struct Raw {
  std::string source;
  Choice choice;
  Table table;
  std::vector<double> temperature = {};  ///< as long as the columns, where there is one [degC]
  std::vector<Piece> pieces;
  std::vector<std::string> notes;
};

using LineOfRow = std::function<std::int64_t(std::size_t)>;

/// A counter that nobody asked for gives way where it counts something else.
void place_by_count(Piece& piece, const std::vector<std::int64_t>& stamps, const Raw& raw, const TimeColumn& column,
                    const LogOptions& options) {
  CountedGrid counted = make_counted_grid(stamps, raw.choice.count_ns, *options.rate_hz, column);
  if (counted.fault.empty()) {
    piece.grid = std::move(counted.grid);
    return;
  }
  if (raw.choice.time_asked)
    text::fail_at(raw.source, column.line_of_row(counted.at_row), 1,
                  fmt::format("{}, expected a count of samples; correct --time", counted.fault));
  piece.grid = {*options.rate_hz, static_cast<std::int64_t>(piece.rows.rows), {}, {}};
  piece.grid.notes.push_back(fmt::format("{} (line {}) and is not taken for a count of samples", counted.fault,
                                         column.line_of_row(counted.at_row)));
}

void place_on_grid(Piece& piece, std::vector<std::int64_t> stamps, const Raw& raw, const LineOfRow& line_of_row,
                   const LogOptions& options) {
  piece.line = line_of_row(piece.rows.first);
  if (stamps.empty()) {
    piece.grid = {*options.rate_hz, static_cast<std::int64_t>(piece.rows.rows), {}, {}};
    return;
  }
  const TimeColumn column{raw.source, raw.choice.time_name,
                          [&](std::size_t row) { return line_of_row(piece.rows.first + row); }};
  if (raw.choice.count_ns > 0 && !options.resample_hz) return place_by_count(piece, stamps, raw, column, options);
  if (options.resample_hz) {
    const Resampler& by = piece.resampler.emplace(std::move(stamps), *options.resample_hz, options.input, column);
    piece.grid = {by.rate_hz(), by.cells(), {}, {by.note()}};
    return;
  }
  std::optional<std::string> counted;
  if (options.rate_hz) counted = count_through(stamps, *options.rate_hz, column.name);
  piece.grid = make_grid(stamps, options.rate_hz, column);
  if (counted) piece.grid.notes.push_back(*counted);
}

Stretches cut_or_fail(const Raw& raw, const LogOptions& options, double longest_gap_s) {
  Stretches cuts = cut(raw.table, options.rate_hz.value_or(1), longest_gap_s);
  if (!cuts.kept.empty()) return cuts;
  text::fail(
      raw.source,
      fmt::format(
          "no segment without a gap above {:g} s has {} rows (the longest has {}); give --segments a gap longer than the sample interval and the short gaps that may stay",
          longest_gap_s, kFewestRows, cuts.longest_rows));
}

/// The pieces of the table, each on its grid: the whole, or what is left between long gaps.
void arrange(Raw& raw, const LineOfRow& line_of_row, const LogOptions& options, std::optional<double> longest_gap_s) {
  if (options.resample_hz && raw.choice.stamps.empty())
    text::fail(raw.source, "has no time column, which resampling needs; leave out --resample");
  if (!longest_gap_s) {
    Piece& whole = raw.pieces.emplace_back();
    whole.rows.rows = raw.table.rows;
    place_on_grid(whole, std::exchange(raw.table.stamps, {}), raw, line_of_row, options);
    append(raw.notes, std::move(raw.choice.notes));
    append(raw.notes, std::exchange(whole.grid.notes, {}));
    return;
  }
  const Stretches cuts = cut_or_fail(raw, options, *longest_gap_s);
  std::vector<std::string> lengths;
  for (const Stretch& stretch : cuts.kept) {
    Piece& piece = raw.pieces.emplace_back();
    piece.rows = stretch;
    std::vector<std::int64_t> stamps;
    if (!raw.table.stamps.empty()) {
      const auto first = raw.table.stamps.begin() + static_cast<std::ptrdiff_t>(stretch.first);
      stamps.assign(first, first + static_cast<std::ptrdiff_t>(stretch.rows));
    }
    place_on_grid(piece, std::move(stamps), raw, line_of_row, options);
    lengths.push_back(
        text::duration_text(static_cast<double>(piece.grid.points) / piece.grid.rate_hz, text::DurationForm::planned));
  }
  append(raw.notes, std::move(raw.choice.notes));
  raw.notes.push_back(describe(cuts, lengths, *longest_gap_s));
}

/// Takes the columns that are no data off the end of the table: the temperature, and what chooses the rows.
/// @param first_line  of the rows, for messages
/// @returns the rows that were chosen; empty for all
std::vector<std::size_t> take_beside(Raw& raw, const LogOptions& options, std::int64_t first_line) {
  Choice& choice = raw.choice;
  std::vector<std::size_t> rows;
  const auto take_last = [&] {
    std::vector<double> column = std::move(raw.table.numbers.back());
    raw.table.numbers.pop_back();
    choice.data.pop_back();
    return column;
  };
  if (choice.rows_of) {
    const std::vector<double> whose = take_last();
    for (std::size_t i = 0; i < whose.size(); ++i)
      if (whose[i] == (choice.rows_of->word ? 1 : options.rows->value)) rows.push_back(i);
    const std::string value =
        choice.rows_of->word ? text::quoted(*choice.rows_of->word) : fmt::format("{}", options.rows->value);
    if (rows.empty())
      text::fail_at(
          raw.source, first_line, 1,
          fmt::format("no row has {} in column {}; correct --rows", value, text::quoted(choice.rows_of->name)));
    raw.notes.push_back(fmt::format("{} of {} rows are read: those with {} in column {}", rows.size(), whose.size(),
                                    value, text::quoted(choice.rows_of->name)));
    for (auto& column : raw.table.numbers) {
      for (std::size_t i = 0; i < rows.size(); ++i) column[i] = column[rows[i]];
      column.resize(rows.size());
    }
    auto& stamps = raw.table.stamps;
    for (std::size_t i = 0; i < rows.size() && !stamps.empty(); ++i) stamps[i] = stamps[rows[i]];
    if (!stamps.empty()) stamps.resize(rows.size());
    raw.table.rows = rows.size();
  }
  if (choice.temperature) {
    raw.temperature = take_last();
    for (double& t : raw.temperature) t += choice.temperature->zero;
  }
  return rows;
}

/// Columns that nobody asked for and that hold no number go, as long as another one holds some.
void leave_out_empty(Raw& raw, const LogOptions& options) {
  if (!options.columns.empty() || raw.table.complete) return;
  auto& numbers = raw.table.numbers;
  std::vector<bool> is_empty;
  for (const auto& column : numbers) is_empty.push_back(count_numbers(column) == 0);
  if (std::ranges::find(is_empty, false) == is_empty.end()) return;
  std::vector<std::string> names;
  for (std::size_t i = is_empty.size(); i-- > 0;) {
    if (!is_empty[i]) continue;
    names.insert(names.begin(), text::quoted(raw.choice.data[i].name));
    raw.choice.data.erase(raw.choice.data.begin() + static_cast<std::ptrdiff_t>(i));
    numbers.erase(numbers.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (!names.empty()) raw.choice.notes.push_back(fmt::format("left out {} (empty)", text::listing(names)));
}

/// A text log, read but not yet on a grid.
class TextLog {
 public:
  explicit TextLog(const LogOptions& options)
      : source_(options.path), layout_(read_layout(source_)), reader_(source_, layout_, options.chunk_bytes) {
    raw.source = source_.name();
    raw.choice = choose_columns(source_.name(), layout_, options);
    put_beside(raw.choice);
    raw.table = reader_.read(raw.choice);
    raw.notes = notes_on_text(source_, layout_, raw.table);
    rows_ = take_beside(raw, options, layout_.body_line);
    if (auto note = unroll(raw.table.stamps, raw.choice)) raw.choice.notes.push_back(*std::move(note));
    leave_out_empty(raw, options);
    check_length(raw.source, static_cast<std::int64_t>(raw.table.rows), options.input, "sample", "");
  }
  [[nodiscard]] std::int64_t line_of_row(std::size_t row) const {
    return reader_.line_of_row(rows_.empty() ? row : rows_[row]);
  }

  Raw raw;

 private:
  Bytes source_;
  Layout layout_;
  TableReader reader_;
  std::vector<std::size_t> rows_;  ///< that were chosen; empty: all
};

/// The name of a file without folder and endings.
std::string stem_of(const std::string& path) {
  const std::filesystem::path stem = std::filesystem::path(path).stem();  // of x.csv.gz this is x.csv
  return (stem.has_extension() ? stem.stem() : stem).string();
}

/// Puts the columns of `other` behind those of `base`.
void join_to(Raw& base, Raw other) {
  const auto append_new = [](std::vector<std::string>& notes, std::vector<std::string>& more) {
    for (std::string& note : more)
      if (std::ranges::find(notes, note) == notes.end()) notes.push_back(std::move(note));
  };
  append_new(base.notes, other.notes);
  append_new(base.choice.notes, other.choice.notes);
  if (base.choice.count_ns > 0 || other.choice.count_ns > 0)
    text::fail(other.source, "a count of samples is no time that logs could be joined by; leave out --with");
  for (DataColumn& c : other.choice.data) {
    if (std::ranges::find(base.choice.data, c.name, &DataColumn::name) != base.choice.data.end())
      c.name = fmt::format("{} of {}", c.name, text::printable(stem_of(other.source)));
    base.choice.data.push_back(std::move(c));
  }
  Joinable joined{base.source, std::move(base.table)};
  append(base.choice.notes, join(joined, {other.source, std::move(other.table)}));
  base.table = std::move(joined.table);
}

Raw read_text(const LogOptions& options, std::optional<double> longest_gap_s) {
  std::vector<std::unique_ptr<TextLog>> logs;
  logs.push_back(std::make_unique<TextLog>(options));
  for (const With& with : options.with) {
    LogOptions further = options;
    further.path = with.path, further.unit = with.unit;
    further.columns.clear(), further.rows.reset(), further.format.reset();
    logs.push_back(std::make_unique<TextLog>(further));
  }
  std::size_t base = 0;
  for (std::size_t i = 1; i < logs.size(); ++i)
    if (is_faster(logs[i]->raw.table, logs[base]->raw.table)) base = i;
  Raw raw = std::move(logs[base]->raw);
  for (std::size_t i = 0; i < logs.size(); ++i)
    if (i != base) join_to(raw, std::move(logs[i]->raw));
  arrange(
      raw, [&](std::size_t row) { return logs[base]->line_of_row(row); }, options, longest_gap_s);
  return raw;
}

Raw read_binary(const LogOptions& options, Format format, std::optional<double> longest_gap_s) {
  const Bytes source(options.path, Content::bytes);
  const std::string_view bytes = source.text();
  const BinaryLayout layout = binary_layout(source.name(), bytes, format, options.file_columns);
  const std::string_view body = bytes.substr(layout.offset);
  const std::int64_t rows = count_rows(source.name(), layout, body.size());
  check_length(source.name(), rows, options.input, "sample", "");
  Raw raw{source.name(), choose_binary_columns(source.name(), layout, options), {}, {}, {}, {}};
  note_compression(source, raw.notes);
  put_beside(raw.choice);
  raw.table.rows = static_cast<std::size_t>(rows);
  raw.table.complete = false;
  raw.table.numbers.assign(raw.choice.data.size(), std::vector<double>(raw.table.rows));
  decode(body, layout, raw.choice, std::vector<std::span<double>>(raw.table.numbers.begin(), raw.table.numbers.end()));
  const auto chosen = take_beside(raw, options, 1);
  check_length(source.name(), static_cast<std::int64_t>(raw.table.rows), options.input, "sample", "");
  arrange(
      raw, [&](std::size_t row) { return static_cast<std::int64_t>(chosen.empty() ? row : chosen[row]) + 1; }, options,
      longest_gap_s);
  return raw;
}

Raw read_recording(const Recording& recording, const LogOptions& options, std::optional<double> longest_gap_s) {
  Recorded recorded = read_recorded(recording, options);
  Raw raw{recorded.source, std::move(recorded.choice), {}, {}, {}, std::move(recorded.notes)};
  raw.table.numbers = std::move(recorded.numbers);
  raw.table.stamps = std::move(recorded.stamps);
  raw.table.rows = raw.table.numbers.front().size();
  raw.table.complete = false;
  const auto rows = take_beside(raw, options, 1);
  if (auto note = unroll(raw.table.stamps, raw.choice)) raw.choice.notes.push_back(*std::move(note));
  check_length(raw.source, static_cast<std::int64_t>(raw.table.rows), options.input, "sample", "");
  arrange(
      raw, [&](std::size_t row) { return static_cast<std::int64_t>(rows.empty() ? row : rows[row]) + 1; }, options,
      longest_gap_s);
  return raw;
}

/// Refuses what text logs alone can give.
void check_text_alone(const LogOptions& options) {
  if (!options.with.empty()) throw std::invalid_argument("--with joins text logs by their time; leave it out");
  if (options.rows && options.rows->word)
    throw std::invalid_argument("--rows chooses by words in text logs only; give the number that the rows have");
}

Raw read_raw(const LogOptions& options, std::optional<double> longest_gap_s) {
  check(options);
  if (!options.format) {
    if (const auto recording = open_recording(options.path))
      return check_text_alone(options), read_recording(*recording, options, longest_gap_s);
  }
  if (options.topic)
    throw std::invalid_argument(fmt::format("--topic {}: {} is no recording with topics",
                                            text::printable(*options.topic), text::input_name(options.path)));
  const Format format = options.format.value_or(format_of_input(options.path));
  if (format != Format::csv) check_text_alone(options);
  return format == Format::csv ? read_text(options, longest_gap_s) : read_binary(options, format, longest_gap_s);
}

/// The values of a column in the rows of a piece; the only piece takes them all.
std::vector<double> take(std::vector<double>& column, const Piece& piece) {
  if (piece.rows.rows == column.size()) return std::move(column);
  const auto first = column.begin() + static_cast<std::ptrdiff_t>(piece.rows.first);
  return {first, first + static_cast<std::ptrdiff_t>(piece.rows.rows)};
}

/// How often an angle was unwrapped, and how many numbers there were, of each column.
struct Counts {
  std::vector<std::int64_t> turns, numbers;
};

allan::Record to_record(Raw& raw, const Piece& piece, Input input, Counts& counts) {
  const std::size_t axes = raw.choice.data.size();
  const bool complete = raw.table.complete && piece.grid.places.empty() && !piece.resampler;
  allan::Record record;
  record.source = raw.source;
  record.rate_hz = piece.grid.rate_hz;
  record.start_s = piece.rows.start_s;
  record.first_row = piece.line;
  record.axes.resize(axes);
  tbb::parallel_for(std::size_t{0}, axes, [&](std::size_t i) {
    const DataColumn& column = raw.choice.data[i];
    std::vector<double> values = take(raw.table.numbers[i], piece);
    if (piece.resampler) {
      if (input == Input::angle && column.signal == noise::Signal::angular_rate) counts.turns[i] += unwrap(values);
      values = (*piece.resampler)(values);
      counts.numbers[i] += count_numbers(values);
    } else {
      put_on_grid(piece.grid, values);
      counts.numbers[i] += complete ? static_cast<std::int64_t>(piece.rows.rows) : count_numbers(values);
      counts.turns[i] += to_rate(values, input, column.signal, piece.grid.rate_hz);
    }
    record.axes[i] = {column.name, column.signal, std::move(values)};
  });
  record.samples = static_cast<std::int64_t>(record.axes.front().rate.size());
  if (!raw.temperature.empty()) {
    std::vector<double> values = take(raw.temperature, piece);
    if (piece.resampler) {
      if (input == Input::rate) record.temperature = (*piece.resampler)(values);
    } else {
      put_on_grid(piece.grid, values);
      values.resize(static_cast<std::size_t>(record.samples));  // n angles give n - 1 rates
      record.temperature = std::move(values);
    }
  }
  record.missing_samples = complete ? 0 : count_missing(record);
  return record;
}

std::vector<allan::Record> to_records(Raw raw, Input input) {
  const std::size_t axes = raw.choice.data.size();
  Counts counts{std::vector<std::int64_t>(axes), std::vector<std::int64_t>(axes)};
  std::vector<allan::Record> records;
  for (Piece& piece : raw.pieces) records.push_back(to_record(raw, piece, input, counts));
  for (std::size_t i = 0; i < axes; ++i) {
    const DataColumn& column = raw.choice.data[i];
    check_length(raw.source, counts.numbers[i], input, "number", " in column " + text::quoted(column.name));
    if (counts.turns[i] > 0)
      raw.notes.push_back(fmt::format("{} is unwrapped {} times", text::quoted(column.name), counts.turns[i]));
  }
  records.front().notes = std::move(raw.notes);
  return records;
}

/// Gives all segments the rate of the longest, which is known best. Their own notes follow, marked.
void share_rate(std::vector<allan::Record>& records, const std::vector<Grid>& grids, bool resampled) {
  const auto longest = std::ranges::max_element(records, {}, &allan::Record::samples) - records.begin();
  const double rate = records[static_cast<std::size_t>(longest)].rate_hz;
  const auto name = [](std::size_t i) { return fmt::format("segment {}", i + 1); };
  for (std::size_t i = 0; i < records.size(); ++i) {
    allan::Record& record = records[i];
    if (std::abs(record.rate_hz / rate - 1) > kRateTolerance) {
      text::fail(
          record.source,
          fmt::format(
              "the time of {} (from line {}) says {:.6g} Hz, that of {} {:.6g} Hz; segments must have one rate: cut the log there",
              name(i), record.first_row, record.rate_hz, name(static_cast<std::size_t>(longest)), rate));
    }
    record.rate_hz = rate;
    const bool first_is_rate = !resampled;  // the rate of each is of no interest, but that of the longest
    for (std::size_t k = 0; k < grids[i].notes.size(); ++k) {
      if (k > 0 || !first_is_rate || i == static_cast<std::size_t>(longest))
        record.notes.push_back(fmt::format("{}: {}", name(i), grids[i].notes[k]));
    }
  }
}

}  // namespace

allan::Record read_log(const LogOptions& options) {
  return std::move(to_records(read_raw(options, {}), options.input).front());
}

std::vector<allan::Record> read_segments(const LogOptions& options, double longest_gap_s) {
  if (!(longest_gap_s > 0) || !std::isfinite(longest_gap_s)) {
    throw std::invalid_argument(fmt::format("longest gap is {} s; it must be above 0 and finite", longest_gap_s));
  }
  Raw raw = read_raw(options, longest_gap_s);
  std::vector<Grid> grids;
  for (const Piece& piece : raw.pieces) grids.push_back({piece.grid.rate_hz, 0, {}, piece.grid.notes});
  std::vector<allan::Record> records = to_records(std::move(raw), options.input);
  share_rate(records, grids, options.resample_hz.has_value());
  return records;
}

}  // namespace gyrobudget::inline v0::log
