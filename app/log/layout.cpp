// SPDX-License-Identifier: MIT
#include "layout.h"

#include "gyrobudget/app/text/number.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "dialects.h"
#include "top_lines.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kSampleRows = 256;  // rows kept for a first look at the numbers
constexpr std::size_t kLongestPreamble = 512;
constexpr std::size_t kMostColumns = 4096;
constexpr std::size_t kMostCells = kMostColumns + 2;  // of a row; enough to tell that there are too many

/// What stands at the top of the file.
struct Top {
  std::vector<NumberedLine> comments;  ///< above the last of the lines, the last ones where there are many
  std::vector<NumberedLine> lines;     ///< preamble, header and first rows
};

Top read_top(const Bytes& source) {
  const std::string_view text = source.text();
  Top top;
  std::int64_t number = 1;
  for (std::size_t begin = 0; begin < text.size() && top.lines.size() < kSampleRows + kLongestPreamble; ++number) {
    const std::size_t end = line_end(text, begin);
    if (end == std::string_view::npos) fail_long_line(source.name(), number, text.substr(begin));
    const NumberedLine line{text.substr(begin, end - begin), begin, number};
    const LineKind kind = kind_of(line.text);
    if (kind == LineKind::data) top.lines.push_back(line);
    if (kind == LineKind::comment) {
      if (top.comments.size() == kLongestPreamble) top.comments.erase(top.comments.begin());
      top.comments.push_back(line);
    }
    begin = end + 1;
  }
  return top;
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
  Heading result{text::printable(text::to_utf8(text)), {}, column};
  const std::size_t open = opening_bracket(text);
  if (open == 0 || open == std::string_view::npos) return result;
  result.unit = text::printable(text::to_utf8(text::trim(text.substr(open + 1, text.size() - open - 2))));
  result.bracketed_behind = text[open] == '[' && !text::is_blank(text[open - 1]);
  text = text::trim(text.substr(0, open));
  if (text.size() > 1 && text.back() == '_') text.remove_suffix(1);  // gyro_x_[deg/s]
  result.name = text::printable(text::to_utf8(text));
  return result;
}

bool is_index(const Heading& h) { return !h.unit.empty() && std::ranges::all_of(h.unit, text::is_digit); }

/// gyro_rad[0] is a name. Only "(1)", or " [1]" behind a blank, is a unit where no other column differs by its index.
std::vector<Heading> with_indices(std::vector<Heading> headings) {
  std::vector<std::size_t> indexed;
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const Heading& h = headings[i];
    const bool among_others = std::ranges::any_of(headings, [&](const Heading& other) {
      return is_index(other) && other.name == h.name && other.unit != h.unit;
    });
    if (is_index(h) && (h.unit != "1" || h.bracketed_behind || among_others)) indexed.push_back(i);
  }
  for (const std::size_t i : indexed) {
    headings[i].name = fmt::format("{}[{}]", headings[i].name, std::exchange(headings[i].unit, {}));
  }
  return headings;
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
  return with_indices(std::move(result));
}

/// A comment above rows that are parted by blanks may be prose with as many words: names and units look different.
bool reads_like_names(const std::vector<Heading>& candidates) {
  return std::ranges::any_of(candidates, [](const Heading& h) {
    const std::string name = text::lower(h.name);
    return !h.unit.empty() || name.find('_') != std::string::npos || name == "t" || name.starts_with("time") ||
           name.starts_with("gyr") || name.starts_with("acc") || name == "gx" || name == "wx" || name == "ax";
  });
}

/// Sentences have words, and say "Device: A"; a name has a few words at most.
bool reads_like_prose(const std::vector<Heading>& candidates) {
  constexpr std::ptrdiff_t kMostBlanks = 3;
  return std::ranges::any_of(candidates, [&](const Heading& h) {
    const auto blanks = std::ranges::count(h.name, ' ');
    if (blanks > kMostBlanks || h.name.find(": ") != std::string::npos || h.name.ends_with('.')) return true;
    // Every line has as many cells as rows of one column: there a name is one word, with an axis or without.
    const bool axis = h.name.size() > 1 && h.name[h.name.size() - 2] == ' ';
    return candidates.size() == 1 && blanks > (axis ? 1 : 0);
  });
}

/// Whether a comment names the columns under it.
bool is_header(const std::vector<Heading>& candidates, const Layout& layout) {
  return candidates.size() == layout.sample[0].size() && !reads_like_prose(candidates) &&
         (layout.dialect.delimiter != ' ' || reads_like_names(candidates));
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

namespace {

/// @throws InputError with what to do where the text is that of a program which is not read as it stands.
void refuse_foreign(const Bytes& source, const Top& top) {
  constexpr std::size_t kFirst = 64;
  for (const auto* lines : {&top.comments, &top.lines}) {
    for (const NumberedLine& line : std::span(*lines).first(std::min(lines->size(), kFirst)))
      if (const auto advice = advice_on(line.text); !advice.empty())
        text::fail_at(source.name(), line.number, 1, advice);
  }
}

/// Takes the lines away that are neither names nor rows, and says so.
void skip_preamble(const Bytes& source, Top& top, Layout& layout) {
  std::vector<NumberedLine>& lines = top.lines;
  const auto drop = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) layout.preamble.push_back(lines[i].text);
    lines.erase(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(count));
  };
  const auto dialect = [&](std::optional<char> told) {
    const std::vector<NumberedLine> behind_first(lines.begin() + (lines.size() > 1 ? 1 : 0), lines.end());
    return find_dialect(source, lines[0], behind_first, told);
  };
  const auto told = told_delimiter(lines[0].text);
  if (told && lines.size() > 1) drop(1);
  layout.dialect = dialect(told);
  const Preamble preamble = find_preamble(lines, layout.dialect, told);
  if (preamble.length > 0) {
    const NumberedLine first = lines[0];
    drop(preamble.length);
    layout.dialect = dialect(told);
    if (preamble.is_cut_row)
      layout.notes.push_back(fmt::format("line {} ({}) is the end of a row and left out", first.number,
                                         text::quoted(text::trim(first.text))));
  }
  layout.is_cut = preamble.is_cut_row;
  lines.resize(std::min(lines.size(), kSampleRows));
}

void say_where_the_header_is(Layout& layout) {
  if (layout.preamble.empty() || layout.is_cut) return;
  const std::string what = layout.preamble.size() == 1
                               ? "a line above it is left out"
                               : fmt::format("{} lines above it are left out", layout.preamble.size());
  const std::string start = text::quoted(text::trim(layout.preamble.front()));
  if (layout.heading_line != 0)
    layout.notes.push_back(fmt::format("the header is line {}; {}, from {} on", layout.heading_line, what, start));
  else
    layout.notes.push_back(
        fmt::format("there is no header, and the first row is line {}; {}, from {} on", layout.body_line, what, start));
}

}  // namespace

Layout read_layout(const Bytes& source) {
  Top top = read_top(source);
  std::vector<NumberedLine>& lines = top.lines;
  refuse_foreign(source, top);
  if (lines.empty())
    text::fail(source.name(), "holds no samples, only blank and comment lines; check how it was written");

  Layout layout;
  layout.first_line = text::trim(source.text().substr(0, source.text().find('\n')));
  skip_preamble(source, top, layout);
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
  const auto behind = std::ranges::lower_bound(top.comments, layout.body, {}, &NumberedLine::begin);
  if (layout.headings.empty() && behind != top.comments.begin()) {
    const NumberedLine& comment = *std::prev(behind);
    std::vector<Heading> candidates = headings(comment, delimiter);
    if (is_header(candidates, layout)) {
      layout.headings = std::move(candidates);
      layout.heading_line = comment.number;
    }
  }
  if (layout.headings.empty()) {
    if (auto known = headings_of_known_rows(layout)) {
      layout.headings = std::move(known->headings);
      layout.notes.push_back(std::move(known->note));
    }
  }
  count_columns(source, layout);
  say_where_the_header_is(layout);
  return layout;
}

}  // namespace gyrobudget::inline v0::log
