// SPDX-License-Identifier: MIT
#include "layout.h"

#include "gyrobudget/app/text/number.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kDialectRows = 32;  // rows that vote on the dialect
constexpr std::size_t kSampleRows = 256;  // rows kept for a first look at the numbers
constexpr std::size_t kMostColumns = 4096;
constexpr std::size_t kMostCells = kMostColumns + 2;  // of a row; enough to tell that there are too many

struct NumberedLine {
  std::string_view text;
  std::size_t begin = 0;
  std::int64_t number = 0;
};

/// What stands at the top of the file.
struct Top {
  std::optional<NumberedLine> comment;  ///< the last one above the first other line
  std::vector<NumberedLine> lines;      ///< header and first rows
};

Top read_top(const Bytes& source) {
  const std::string_view text = source.text();
  Top top;
  std::int64_t number = 1;
  for (std::size_t begin = 0; begin < text.size() && top.lines.size() < kSampleRows; ++number) {
    const std::size_t end = line_end(text, begin);
    if (end == std::string_view::npos) fail_long_line(source.name(), number, text.substr(begin));
    const NumberedLine line{text.substr(begin, end - begin), begin, number};
    const LineKind kind = kind_of(line.text);
    if (kind == LineKind::data) top.lines.push_back(line);
    if (kind == LineKind::comment && top.lines.empty()) top.comment = line;
    begin = end + 1;
  }
  return top;
}

std::size_t count_numbers(const std::vector<std::string_view>& cells, bool decimal_comma) {
  double ignored = 0;
  return static_cast<std::size_t>(std::ranges::count_if(cells, [&](std::string_view cell) {
    return text::parse_number(cell, decimal_comma, ignored) == text::Cell::number;
  }));
}

bool is_missing(std::string_view cell) {
  double ignored = 0;
  return text::parse_number(cell, false, ignored) == text::Cell::missing;
}

bool starts_with_bracket(std::string_view text) {
  text = text::trim(text);
  return text.starts_with('(') || text.starts_with('[');
}

/// Cells of a header: a delimiter inside quotes or brackets does not count, and "time (s)" is one cell among blanks.
std::vector<std::string_view> split_header(std::string_view line, char delimiter) {
  const bool blanks = delimiter == ' ';
  std::vector<std::string_view> cells;
  int depth = 0;
  bool inside_quotes = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') inside_quotes = !inside_quotes;
    if (inside_quotes) continue;
    if (c == '(' || c == '[') ++depth;
    if ((c == ')' || c == ']') && depth > 0) --depth;
    if (depth > 0 || (blanks ? !text::is_blank(c) : c != delimiter)) continue;
    if (blanks && begin == i) {  // a further blank of a run, or one at the start
      ++begin;
      continue;
    }
    if (blanks && text::is_blank(line[i - 1])) continue;
    if (blanks && starts_with_bracket(line.substr(i))) continue;
    cells.push_back(line.substr(begin, i - begin));
    begin = i + 1;
  }
  if (!blanks || !text::trim(line.substr(begin)).empty()) cells.push_back(line.substr(begin));
  return cells;
}

// --- The dialect ---------------------------------------------------------------------------------------------------

/// How well a dialect explains rows: rows without any text and with as many cells as the first one, then whether the
/// line above them has as many cells too, then cells that are numbers.
struct Score {
  std::size_t clean_rows = 0;
  bool header_fits = false;
  std::size_t numbers = 0;
  friend auto operator<=>(const Score&, const Score&) = default;
};

Score score(Dialect dialect, const NumberedLine& above, const std::vector<NumberedLine>& rows) {
  Score result;
  const std::size_t cells_expected = split(rows[0].text, dialect.delimiter).size();
  result.header_fits = split_header(above.text, dialect.delimiter).size() == cells_expected;
  const bool one_name = split_header(above.text, ',').size() == 1 &&
                        count_numbers(split(above.text, dialect.delimiter), dialect.decimal_comma) == 0;
  for (const NumberedLine& row : rows) {
    const auto cells = split(row.text, dialect.delimiter);
    const std::size_t numbers = count_numbers(cells, dialect.decimal_comma);
    const auto missing = static_cast<std::size_t>(std::ranges::count_if(cells, is_missing));
    // "1,5" alone may be two columns; under one name it is one.
    if (dialect.decimal_comma && cells.size() < 2 && !(one_name && result.header_fits)) continue;
    const bool clean = numbers > 0 && numbers + missing == cells.size() && cells.size() == cells_expected;
    result.numbers += numbers;
    result.clean_rows += clean ? 1 : 0;
  }
  return result;
}

/// Rows like "0,123" or "0,123,-0,456": no point anywhere, and digits behind every second comma that start with zero.
bool commas_may_be_decimal(const std::vector<NumberedLine>& rows) {
  bool leading_zero = false;
  for (const NumberedLine& row : rows) {
    const auto cells = split(row.text, ',');
    if (cells.size() % 2 != 0 || row.text.find('.') != std::string_view::npos) return false;
    for (std::size_t i = 1; i < cells.size(); i += 2) {
      if (cells[i].find_first_not_of("0123456789") != std::string_view::npos) return false;
      leading_zero |= cells[i].size() > 1 && cells[i].front() == '0';
    }
  }
  return leading_zero;
}

/// Cells like "0,5" in quotes.
bool commas_stand_in_quotes(std::string_view row) {
  return std::ranges::any_of(split(row, ','), [](std::string_view cell) {
    return cell.size() > 1 && cell.front() == '"' && text::is_digit(cell.back()) &&
           cell.find('"', 1) == std::string_view::npos;
  });
}

Dialect find_dialect(const Bytes& source, const NumberedLine& above, std::vector<NumberedLine> rows) {
  rows.resize(std::min(rows.size(), kDialectRows));
  // In the order of preference where several explain the rows equally well.
  constexpr Dialect kCandidates[] = {{',', false}, {';', false}, {'\t', false}, {' ', false},
                                     {';', true},  {'\t', true}, {' ', true}};
  Dialect best = kCandidates[0];
  Score best_score;
  for (const Dialect candidate : kCandidates) {
    const Score s = score(candidate, above, rows);
    if (s > best_score) {
      best_score = s;
      best = candidate;
    }
  }
  if (best.delimiter == ',' && commas_may_be_decimal(rows)) {
    text::fail_at(
        source.name(), rows[0].number, 1,
        fmt::format(
            "found {}, where the commas may be decimal marks or part the columns; write decimal points, part the columns by semicolons, or name the columns in a header line, as in \"gyro_x (deg/s)\"",
            text::quoted(rows[0].text)));
  }
  if (best_score.clean_rows == 0 && commas_stand_in_quotes(rows[0].text)) {
    text::fail_at(
        source.name(), rows[0].number, 1,
        fmt::format(
            "found {}, decimal commas in quotes between commas; write decimal points, or part the columns by semicolons and leave the quotes out",
            text::quoted(rows[0].text)));
  }
  return best;
}

// --- The header ----------------------------------------------------------------------------------------------------

/// Where the bracket that closes at the end of the text opens; npos where none does.
std::size_t opening_bracket(std::string_view text) {
  const char close = text.empty() ? '\0' : text.back();
  if (close != ')' && close != ']') return std::string_view::npos;
  const char open = close == ')' ? '(' : '[';
  int depth = 0;
  for (std::size_t i = text.size(); i-- > 0;) {
    if (text[i] == close) ++depth;
    if (text[i] == open && --depth == 0) return i;
  }
  return std::string_view::npos;
}

Heading heading(std::string_view cell, std::int64_t column) {
  std::string_view text = text::trim(cell);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text::trim(text.substr(1, text.size() - 2));
  Heading result{text::to_utf8(text), {}, column};
  const std::size_t open = opening_bracket(text);
  if (open == 0 || open == std::string_view::npos) return result;
  result.unit = text::to_utf8(text::trim(text.substr(open + 1, text.size() - open - 2)));
  text = text::trim(text.substr(0, open));
  if (text.size() > 1 && text.back() == '_') text.remove_suffix(1);  // gyro_x_[deg/s]
  result.name = text::to_utf8(text);
  return result;
}

std::vector<Heading> headings(const NumberedLine& line, char delimiter) {
  std::string_view text = line.text;
  while (!text.empty() && (text::is_blank(text.front()) || text.front() == '#' || text.front() == '%'))
    text.remove_prefix(1);
  if (text.starts_with("//")) text.remove_prefix(2);
  std::vector<Heading> result;
  for (const std::string_view cell : split_header(text, delimiter)) {
    result.push_back(
        heading(cell, 1 + (text::trim(cell).empty() ? cell.data() : text::trim(cell).data()) - line.text.data()));
  }
  return result;
}

/// A comment above rows that are parted by blanks may be prose with as many words: names and units look different.
bool reads_like_names(const std::vector<Heading>& candidates) {
  return std::ranges::any_of(candidates, [](const Heading& h) {
    const std::string name = text::lower(h.name);
    return !h.unit.empty() || name.find('_') != std::string::npos || name == "t" || name.starts_with("time") ||
           name.starts_with("gyr") || name.starts_with("acc") || name == "gx" || name == "wx" || name == "ax";
  });
}

/// A line under the header with a unit, in brackets or not, for each column.
bool is_line_of_units(const std::vector<std::string_view>& cells, const Layout& layout) {
  return cells.size() == layout.headings.size() && count_numbers(cells, layout.dialect.decimal_comma) == 0 &&
         !std::ranges::all_of(cells, is_missing) &&
         std::ranges::all_of(layout.headings, [](const Heading& h) { return h.unit.empty(); });
}

void take_units(const std::vector<std::string_view>& cells, std::vector<Heading>& headings) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::string_view unit = cells[i];
    if (opening_bracket(unit) == 0) unit = text::trim(unit.substr(1, unit.size() - 2));
    headings[i].unit = text::to_utf8(unit);
  }
}

bool ends_with_delimiter(const std::vector<std::string_view>& cells) {
  return cells.size() > 1 && cells.back().empty();
}

void count_columns(const Bytes& source, Layout& layout) {
  layout.columns = layout.sample[0].size();
  const std::size_t named = layout.headings.size();
  const bool surplus = std::ranges::all_of(layout.sample, ends_with_delimiter);
  if (surplus && (named == 0 || named + 1 == layout.columns || layout.headings.back().name.empty())) --layout.columns;
  if (named == layout.columns + 1 && layout.headings.back().name.empty()) layout.headings.pop_back();
  if (layout.columns > kMostColumns) {
    text::fail_at(
        source.name(), layout.body_line, 1,
        fmt::format(
            "found {} or more numbers in one line, expected at most {}; put each sample on a line of its own (tr -s ' ' '\\n')",
            layout.columns, kMostColumns));
  }
  if (named != 0 && layout.headings.size() != layout.columns) {
    text::fail_at(source.name(), layout.body_line, 1,
                  fmt::format("found {} cells under a header of {} names; give each column one name{}", layout.columns,
                              named, layout.dialect.delimiter == ' ' ? ", without blanks in it" : ""));
  }
}

}  // namespace

LineKind kind_of(std::string_view line) {
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (text::is_blank(c) || c == '\r') continue;
    const bool slashes = c == '/' && i + 1 < line.size() && line[i + 1] == '/';
    return c == '#' || c == '%' || slashes ? LineKind::comment : LineKind::data;
  }
  return LineKind::blank;
}

std::vector<std::string_view> split(std::string_view line, char delimiter) {
  std::vector<std::string_view> cells;
  if (delimiter == ' ') {
    line = text::trim(line);
    while (!line.empty() && cells.size() < kMostCells) {
      const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
      cells.push_back(line.substr(0, end));
      line = text::trim(line.substr(end));
    }
    return cells;
  }
  while (cells.size() < kMostCells) {
    const std::size_t end = line.find(delimiter);
    cells.push_back(text::trim(line.substr(0, end)));
    if (end == std::string_view::npos) break;
    line.remove_prefix(end + 1);
  }
  return cells;
}

Layout read_layout(const Bytes& source) {
  Top top = read_top(source);
  std::vector<NumberedLine>& lines = top.lines;
  if (lines.empty())
    text::fail(source.name(), "holds no samples, only blank and comment lines; check how it was written");

  Layout layout;
  const std::vector<NumberedLine> behind_first(lines.begin() + (lines.size() > 1 ? 1 : 0), lines.end());
  layout.dialect = find_dialect(source, lines[0], behind_first);
  const char delimiter = layout.dialect.delimiter;

  const auto first = split(lines[0].text, delimiter);
  if (count_numbers(first, layout.dialect.decimal_comma) == 0 && !std::ranges::all_of(first, is_missing)) {
    layout.headings = headings(lines[0], delimiter);
    layout.heading_line = lines[0].number;
    lines.erase(lines.begin());
    if (!lines.empty() && is_line_of_units(split(lines[0].text, delimiter), layout)) {
      take_units(split(lines[0].text, delimiter), layout.headings);
      lines.erase(lines.begin());
    }
    if (lines.empty()) {
      text::fail(source.name(),
                 fmt::format("holds a header (line {}) but no samples under it; check how it was written",
                             layout.heading_line));
    }
  }
  layout.body = lines[0].begin;
  layout.body_line = lines[0].number;
  for (const NumberedLine& line : lines) layout.sample.push_back(split(line.text, delimiter));
  if (layout.headings.empty() && top.comment) {
    std::vector<Heading> candidates = headings(*top.comment, delimiter);
    if (candidates.size() == layout.sample[0].size() && (delimiter != ' ' || reads_like_names(candidates))) {
      layout.headings = std::move(candidates);
      layout.heading_line = top.comment->number;
    }
  }
  count_columns(source, layout);
  return layout;
}

}  // namespace gyrobudget::inline v0::log
