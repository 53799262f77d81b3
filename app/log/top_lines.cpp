// SPDX-License-Identifier: MIT
#include "top_lines.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "names.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kDialectRows = 32;  // rows that vote on the dialect

// In the order of preference where several explain the rows equally well.
constexpr std::array<Dialect, 7> kDialects{
    {{',', false}, {';', false}, {'\t', false}, {' ', false}, {';', true}, {'\t', true}, {' ', true}}};

bool starts_with_bracket(std::string_view text) {
  text = text::trim(text);
  return text.starts_with('(') || text.starts_with('[');
}

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

// --- The preamble --------------------------------------------------------------------------------------------------

bool has_values(const std::vector<std::string_view>& cells, Dialect dialect) {
  return count_numbers(cells, dialect.decimal_comma) > 0 || std::ranges::any_of(cells, is_missing);
}

bool is_all_numbers(const std::vector<std::string_view>& cells, Dialect dialect) {
  return count_numbers(cells, dialect.decimal_comma) == cells.size();
}

bool reads_as_unit(std::string_view cell) {
  if (cell.size() > 2 && starts_with_bracket(cell)) return true;
  try {
    return noise::parse_unit(cell).to_si > 0;
  } catch (const std::invalid_argument&) {
    return cell == "-" || cell == "na";
  }
}

/// Names of a time or a sensor, which no line of units has.
bool reads_as_names(const std::vector<std::string_view>& cells) {
  const auto is_known = [](std::string_view cell) {
    const NameKind kind = kind_of_name(cell);
    return time_name(cell) || kind == NameKind::gyro || kind == NameKind::accelerometer;
  };
  return std::ranges::none_of(cells, reads_as_unit) && std::ranges::any_of(cells, is_known);
}

/// Names without numbers, as many as a row has cells; rows may end in a delimiter that the names lack.
bool is_header_over(const NumberedLine& line, const std::vector<std::string_view>& row, Dialect dialect) {
  const auto cells = split_header(line.text, dialect.delimiter);
  if (count_numbers(split(line.text, dialect.delimiter), dialect.decimal_comma) > 0) return false;
  return cells.size() == row.size() || (cells.size() + 1 == row.size() && row.back().empty()) ||
         (cells.size() == row.size() + 1 && text::trim(cells.back()).empty());
}

/// Where the rows begin that the last of the lines belongs to.
std::size_t first_row(const std::vector<NumberedLine>& lines, Dialect dialect) {
  const std::size_t cells = split(lines.back().text, dialect.delimiter).size();
  std::size_t begin = lines.size();
  while (begin > 0) {
    const auto above = split(lines[begin - 1].text, dialect.delimiter);
    if (above.size() != cells || !has_values(above, dialect)) break;
    --begin;
  }
  return begin;
}

/// What stands above the rows, as one dialect sees it.
struct Beginning {
  Dialect dialect;
  std::size_t first = 0;  ///< row
};

Beginning find_beginning(const std::vector<NumberedLine>& lines, std::optional<char> told) {
  const std::vector<NumberedLine> last(lines.end() - static_cast<std::ptrdiff_t>(std::min(lines.size(), kDialectRows)),
                                       lines.end());
  std::optional<Beginning> best;
  Score best_score;
  for (const Dialect dialect : kDialects) {
    if (told && dialect.delimiter != *told) continue;
    const std::size_t first = first_row(lines, dialect);
    if (first + 1 >= lines.size()) continue;
    const Score s = score(dialect, lines[first == 0 ? 0 : first - 1], last);
    if (best && !(s > best_score)) continue;
    best = {dialect, first};
    best_score = s;
  }
  return best.value_or(Beginning{{}, 0});
}

/// The line of names above the rows, with one of units between them or not; empty where there is none.
std::optional<std::size_t> header_above(const std::vector<NumberedLine>& lines, const Beginning& b) {
  const auto row = split(lines[b.first].text, b.dialect.delimiter);
  if (b.first == 0 || !is_header_over(lines[b.first - 1], row, b.dialect)) return std::nullopt;
  const auto cells = split_header(lines[b.first - 1].text, b.dialect.delimiter);
  const auto units = std::ranges::count_if(cells, [](std::string_view c) { return reads_as_unit(text::trim(c)); });
  const bool of_units = 2 * static_cast<std::size_t>(units) > cells.size();
  return b.first - (of_units && b.first > 1 && is_header_over(lines[b.first - 2], row, b.dialect) ? 2 : 1);
}

/// A line that was cut at its start stands above whole rows.
bool is_cut_row(const std::vector<NumberedLine>& lines, const Beginning& b) {
  constexpr std::size_t kFewestWhole = 8;
  const auto cells = split(lines[0].text, b.dialect.delimiter);
  return b.first == 1 && lines.size() > kFewestWhole && is_all_numbers(cells, b.dialect) &&
         cells.size() < split(lines[1].text, b.dialect.delimiter).size();
}

/// Names whose number is not that of the columns are a fault to be told, not prose.
bool is_unfit_header(const NumberedLine& line, const std::vector<std::string_view>& row, Dialect dialect) {
  return split_header(line.text, dialect.delimiter).size() >= std::max<std::size_t>(2, (row.size() + 1) / 2);
}

/// The first line is one of names, with units under it or not, or a row, and those behind it are rows.
bool rows_stand_at_the_top(const std::vector<NumberedLine>& lines, Dialect dialect) {
  constexpr std::size_t kFewest = 3;
  if (lines.size() < kFewest) return true;
  const auto second = split(lines[1].text, dialect.delimiter), last = split(lines.back().text, dialect.delimiter);
  if (second.size() != last.size()) return false;
  if (has_values(split(lines[0].text, dialect.delimiter), dialect) && !is_header_over(lines[0], last, dialect))
    return split(lines[0].text, dialect.delimiter).size() == last.size() && has_values(second, dialect);
  if (!is_header_over(lines[0], last, dialect)) return false;
  return has_values(second, dialect) ||
         (has_values(split(lines[2].text, dialect.delimiter), dialect) && !reads_as_names(second));
}

}  // namespace

std::optional<char> told_delimiter(std::string_view line) {
  line = text::trim(line);
  if (line.size() > 2 && line.front() == '"' && line.back() == '"') line = line.substr(1, line.size() - 2);
  constexpr std::string_view kSeparator = "sep=";
  if (line.size() != kSeparator.size() + 1 || !line.starts_with(kSeparator)) return std::nullopt;
  const char c = line.back();
  return std::string_view(",;\t ").find(c) == std::string_view::npos ? std::nullopt : std::optional(c);
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

Dialect find_dialect(const Bytes& source, const NumberedLine& above, std::vector<NumberedLine> rows,
                     std::optional<char> told) {
  rows.resize(std::min(rows.size(), kDialectRows));
  Dialect best = kDialects[0];
  Score best_score;
  for (const Dialect candidate : kDialects) {
    if (told && candidate.delimiter != *told) continue;
    const Score s = score(candidate, above, rows);
    if (s > best_score || best.delimiter != told.value_or(best.delimiter)) {
      best_score = s;
      best = candidate;
    }
  }
  if (!told && best.delimiter == ',' && commas_may_be_decimal(rows)) {
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

Preamble find_preamble(const std::vector<NumberedLine>& lines, Dialect dialect, std::optional<char> told) {
  if (rows_stand_at_the_top(lines, dialect)) return {};
  const Beginning b = find_beginning(lines, told);
  if (b.first == 0) return {};
  if (is_cut_row(lines, b)) return {1, true};
  const auto row = split(lines[b.first].text, b.dialect.delimiter);
  const auto header = header_above(lines, b);
  if (!header && is_unfit_header(lines[b.first - 1], row, b.dialect)) return {};
  const std::size_t length = header.value_or(b.first);
  for (std::size_t i = 0; i < length; ++i) {
    const auto cells = split(lines[i].text, b.dialect.delimiter);
    if (cells.size() > 1 && is_all_numbers(cells, b.dialect)) return {};  // a row of another length is a fault
  }
  return {length, false};
}

}  // namespace gyrobudget::inline v0::log
