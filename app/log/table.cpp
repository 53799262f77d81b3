// SPDX-License-Identifier: MIT
#include "table.h"

#include "gyrobudget/app/text/number.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>

namespace gyrobudget::inline v0::log {
namespace {

/// Why a row cannot be read, and where in its line.
struct Fault {
  std::int64_t line = 0;
  std::size_t offset = 0;
  std::string message;
};

/// What becomes of each column of the file.
struct Role {
  enum Kind : unsigned char { skip, number, stamp, word } kind = skip;
  double* numbers = nullptr;
  double to_si = 1;
  std::int64_t ns_per_unit = 1;
  bool further_part = false;  ///< adds to a stamp that another column has begun
  StampForm form = StampForm::number;
  std::string_view wanted = {};  ///< word: the number is 1 where the cell is this, else 0
  const std::string* name = nullptr;
};

std::vector<Role> roles_of(const Layout& layout, const Choice& choice, Table& table) {
  std::vector<Role> roles(layout.columns);
  for (std::size_t i = 0; i < choice.data.size(); ++i) {
    const DataColumn& c = choice.data[i];
    roles[c.index] = {c.word ? Role::word : Role::number,
                      table.numbers[i].data(),
                      c.to_si,
                      1,
                      false,
                      StampForm::number,
                      c.word ? *c.word : std::string_view{},
                      &c.name};
  }
  std::size_t first = layout.columns;
  for (const StampColumn& s : choice.stamps) {
    roles[s.index] = {Role::stamp, nullptr, 1, s.ns_per_unit, true, s.form, {}, &choice.time_name};
    first = std::min(first, s.index);
  }
  if (first < layout.columns) roles[first].further_part = false;
  return roles;
}

/// Parses one row after the other into the columns of a table.
template <bool kBlanks>
class RowParser {
 public:
  RowParser(Dialect dialect, const std::vector<Role>& roles, Table& table, std::atomic<bool>& complete)
      : dialect_(dialect), roles_(roles), stamps_(table.stamps.data()), complete_(complete) {}

  /// The usual case, fast: a row of plain numbers and of cells that are passed over.
  /// @returns where the next line starts; null where the row is another case (its end is not looked for)
  const char* parse_plain(const char* at, const char* end, std::size_t row) const {
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      if (i > 0) {
        if (at == end || !is_delimiter(*at)) return nullptr;
        do {
          ++at;
        } while (at != end && (*at == ' ' || (kBlanks && *at == '\t')));
      }
      at = parse_plain_cell(roles_[i], at, end, row);
      if (!at) return nullptr;
    }
    if (at != end && *at == '\r') ++at;
    return at != end && *at == '\n' ? at + 1 : nullptr;
  }

  /// @returns the fault where the row is not as it should be
  std::optional<Fault> parse(const char* begin, const char* end, std::size_t row) const {
    if (end > begin && end[-1] == '\r') --end;
    const char* at = begin;
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      at = skip_blanks(at, end);
      if (kBlanks && at == end) return too_few(begin, end, i);
      if (!parse_cell(roles_[i], at, end, row)) return bad_cell(roles_[i], begin, at, end);
      if (at != end) {
        ++at;  // the delimiter
      } else if (i + 1 < roles_.size()) {
        return too_few(begin, end, i + 1);
      } else {
        return std::nullopt;
      }
    }
    // A delimiter behind the last cell is allowed, a further cell is not.
    if (skip_blanks(at, end) != end) return too_many(begin, at, end);
    return std::nullopt;
  }

 private:
  bool is_delimiter(char c) const { return kBlanks ? text::is_blank(c) : c == dialect_.delimiter; }

  /// Blanks around a cell; a tab may be a delimiter.
  const char* skip_blanks(const char* at, const char* end) const {
    while (at < end && text::is_blank(*at) && (kBlanks || *at != dialect_.delimiter)) ++at;
    return at;
  }

  const char* cell_end(const char* at, const char* end) const {
    if constexpr (kBlanks) {
      while (at < end && !text::is_blank(*at)) ++at;
      return at;
    }
    const void* found = std::memchr(at, dialect_.delimiter, static_cast<std::size_t>(end - at));
    return found ? static_cast<const char*>(found) : end;
  }

  /// The end of the cell; null where it is not plain.
  const char* parse_plain_cell(const Role& role, const char* at, const char* end, std::size_t row) const {
    switch (role.kind) {
      case Role::number: {
        double value = 0;
        const char* stop = text::scan_number(at, end, dialect_.decimal_comma, value);
        value *= role.to_si;
        role.numbers[row] = value;
        return std::isfinite(value) ? stop : nullptr;
      }
      case Role::stamp:
        return role.further_part || role.form != StampForm::number
                   ? nullptr
                   : text::scan_stamp(at, end, dialect_.decimal_comma, role.ns_per_unit, stamps_[row]);
      case Role::word:
        return nullptr;
      case Role::skip:
        break;
    }
    while (at != end && *at != '\n' && *at != '\r' && !is_delimiter(*at)) ++at;
    return at;
  }

  /// Moves `at` to the end of the cell, or leaves it at the start of a bad one.
  bool parse_cell(const Role& role, const char*& at, const char* end, std::size_t row) const {
    const char* stop = cell_end(at, end);
    if (!parse_any(role, {at, static_cast<std::size_t>(stop - at)}, row)) return false;
    at = stop;
    return true;
  }

  bool parse_any(const Role& role, std::string_view cell, std::size_t row) const {
    if (role.kind == Role::number) {
      double value = 0;
      const text::Cell kind = text::parse_number(cell, dialect_.decimal_comma, value);
      role.numbers[row] = value * role.to_si;
      if (kind == text::Cell::missing && complete_.load(std::memory_order_relaxed)) complete_ = false;
      return kind == text::Cell::missing || (kind == text::Cell::number && std::isfinite(role.numbers[row]));
    }
    if (role.kind == Role::word) {
      cell = text::trim(cell);
      if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
      role.numbers[row] = cell == role.wanted ? 1 : 0;
    }
    if (role.kind == Role::stamp) {
      std::int64_t ns = 0;
      const text::Cell kind = role.form == StampForm::number
                                  ? text::parse_stamp(cell, dialect_.decimal_comma, role.ns_per_unit, ns)
                                  : parse_calendar(cell, role.form, ns);
      if (!role.further_part) {
        stamps_[row] = ns;
      } else if (ns == text::kNoStamp || stamps_[row] == text::kNoStamp) {
        stamps_[row] = text::kNoStamp;
      } else if (__builtin_add_overflow(stamps_[row], ns, &stamps_[row])) {
        return false;
      }
      return kind == text::Cell::number || kind == text::Cell::missing;
    }
    return true;
  }

  // --- Faults ---

  Fault bad_cell(const Role& role, const char* begin, const char* at, const char* end) const {
    const std::string_view cell = text::trim({at, static_cast<std::size_t>(cell_end(at, end) - at)});
    const bool named = role.kind == Role::number && !role.name->starts_with("column ");
    return {0, static_cast<std::size_t>(at - begin),
            fmt::format("found {} in {}, expected {}", text::quoted(cell),
                        named ? "column " + text::quoted(*role.name) : *role.name, expectation(role, cell))};
  }

  /// What should stand instead of a bad cell, and how to mend it.
  std::string expectation(const Role& role, std::string_view cell) const {
    constexpr std::string_view kMend = "correct it, or write nan where a sample is missing";
    if (role.kind == Role::stamp && role.form != StampForm::number) {
      return fmt::format("{} like those of the first rows, from 1700 to 2260; {}",
                         role.form == StampForm::time_of_day ? "a time of day" : "a date", kMend);
    }
    double ignored = 0;
    if (text::parse_number(cell, dialect_.decimal_comma, ignored) != text::Cell::text) {
      return fmt::format("{}; {}",
                         role.kind == Role::number ? "a number within the range of double (1.8e308)"
                                                   : "a time within 292 years of its zero",
                         kMend);
    }
    if (text::parse_number(cell, !dialect_.decimal_comma, ignored) == text::Cell::number) {
      return fmt::format(
          "a number with a decimal {} as in the first rows; write all numbers alike, without marks between thousands",
          dialect_.decimal_comma ? "comma" : "point");
    }
    return fmt::format("a number; {}", kMend);
  }

  Fault too_few(const char* begin, const char* end, std::size_t found) const {
    return {0, static_cast<std::size_t>(end - begin), wrong_count(found)};
  }

  Fault too_many(const char* begin, const char* at, const char* end) const {
    const std::string_view line(begin, static_cast<std::size_t>(end - begin));
    return {0, static_cast<std::size_t>(at - begin), wrong_count(split(line, dialect_.delimiter).size())};
  }

  std::string wrong_count(std::size_t found) const {
    return fmt::format("found {} cell{}, expected {} as in the first row; complete the row or delete it", found,
                       found == 1 ? "" : "s", roles_.size());
  }

  Dialect dialect_;
  const std::vector<Role>& roles_;
  std::int64_t* stamps_;
  std::atomic<bool>& complete_;
};

/// Calls visit(begin, end) with each line that starts in [begin, end) of the text, until it returns false or a line is
/// too long: then it returns where that one starts, else npos.
template <class Visit>
std::size_t for_each_line(std::string_view text, std::size_t begin, std::size_t end, Visit visit) {
  while (begin < end) {
    const std::size_t stop = line_end(text, begin);
    if (stop == std::string_view::npos) return begin;
    if (!visit(begin, stop)) break;
    begin = stop + 1;
  }
  return std::string_view::npos;
}

/// Surely a row, from its first character.
bool starts_row(char c) { return text::is_digit(c) || c == '-'; }

/// Lines that start behind the first byte of a text, and those among them that are surely rows.
struct LineStarts {
  std::size_t lines = 0, rows = 0;
};

/// memchr takes many bytes at once: for rows of a hundred characters 9 times the speed of a loop over each.
LineStarts count_line_starts(std::string_view text) {
  LineStarts result;
  for (std::size_t at = text.find('\n'); at != std::string_view::npos && at + 1 < text.size();
       at = text.find('\n', at + 1)) {
    ++result.lines;
    if (starts_row(text[at + 1])) ++result.rows;
  }
  return result;
}

/// kind_of, with a short cut.
LineKind quick_kind(std::string_view text, std::size_t begin, std::size_t end) {
  if (begin < end && starts_row(text[begin])) return LineKind::data;
  return kind_of(text.substr(begin, end - begin));
}

/// Parses the lines that start in [begin, end); `line` and `row` count those before them. @returns the first fault
template <class Parser>
std::optional<Fault> parse_chunk(const Parser& parser, std::string_view text, std::size_t begin, std::size_t end,
                                 std::int64_t line, std::size_t row) {
  const char* text_end = text.data() + text.size();
  while (begin < end) {
    ++line;
    if (starts_row(text[begin])) {
      if (const char* next = parser.parse_plain(text.data() + begin, text_end, row)) {
        ++row;
        begin = static_cast<std::size_t>(next - text.data());
        continue;
      }
    }
    const std::size_t stop = line_end(text, begin);
    if (quick_kind(text, begin, stop) == LineKind::data) {
      if (auto fault = parser.parse(text.data() + begin, text.data() + stop, row++)) {
        fault->line = line;
        return fault;
      }
    }
    begin = stop + 1;
  }
  return std::nullopt;
}

/// Room for the numbers of a column in large pages: fewer faults while it is filled.
template <class Number>
void make_room(std::vector<Number>& numbers, std::size_t rows) {
  numbers.reserve(rows);
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const auto begin = (reinterpret_cast<std::uintptr_t>(numbers.data()) + kPage - 1) / kPage * kPage;
  const auto end = reinterpret_cast<std::uintptr_t>(numbers.data() + rows) / kPage * kPage;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  numbers.resize(rows);
}

}  // namespace

TableReader::TableReader(const Bytes& source, const Layout& layout, std::size_t chunk_bytes)
    : source_(source), layout_(layout) {
  const std::string_view text = source.text();
  const std::size_t size = std::max<std::size_t>(chunk_bytes, 1);
  for (std::size_t begin = layout.body; begin < text.size(); begin += size) {
    chunks_.push_back({begin, std::min(begin + size, text.size()), 0, 0, 0, 0, std::string_view::npos});
  }
  tbb::parallel_for(std::size_t{0}, chunks_.size(), [&](std::size_t i) { count(chunks_[i]); });

  std::int64_t lines = layout.body_line - 1;
  std::size_t pending_blank = 0;
  for (Chunk& c : chunks_) {
    if (c.long_line != std::string_view::npos) {
      fail_long_line(source.name(), lines + c.lines + 1, text.substr(c.long_line));
    }
    if (c.rows > 0) inner_blank_ += pending_blank + c.blank - c.trailing_blank;
    pending_blank = c.rows > 0 ? c.trailing_blank : pending_blank + c.blank;
    lines += std::exchange(c.lines, lines);
    rows_ += std::exchange(c.rows, rows_);
  }
}

void TableReader::count(Chunk& c) const {
  const std::string_view text = source_.text();
  const std::string_view nominal = text.substr(0, c.end);
  if (c.begin != layout_.body) {  // the line that the chunk before it has begun is not ours
    const std::size_t newline = nominal.find('\n', c.begin - 1);
    c.begin = newline == std::string_view::npos ? c.end : newline + 1;
  }
  if (!count_plain(c)) count_kinds(c);
  source_.release(text.substr(c.begin, c.end - c.begin));
}

bool TableReader::count_plain(Chunk& c) const {
  const std::string_view text = source_.text();
  if (c.begin == c.end) return true;
  if (c.end - c.begin > kLongestLine || !starts_row(text[c.begin])) return false;
  const LineStarts starts = count_line_starts(text.substr(c.begin, c.end - c.begin));
  if (starts.rows != starts.lines) return false;
  // Only the last line can be too long: the others end within the chunk.
  const std::size_t newline = text.substr(c.begin, c.end - 1 - c.begin).rfind('\n');
  const std::size_t last = newline == std::string_view::npos ? c.begin : c.begin + newline + 1;
  const bool too_long = line_end(text, last) == std::string_view::npos;
  if (too_long) c.long_line = last;
  c.rows = starts.rows + (too_long ? 0 : 1);
  c.lines = static_cast<std::int64_t>(c.rows);
  return true;
}

void TableReader::count_kinds(Chunk& c) const {
  const std::string_view text = source_.text();
  c.long_line = for_each_line(text, c.begin, c.end, [&](std::size_t begin, std::size_t end) {
    const LineKind kind = quick_kind(text, begin, end);
    ++c.lines;
    if (kind == LineKind::data) {
      ++c.rows;
      c.trailing_blank = 0;
    } else if (kind == LineKind::blank) {
      ++c.blank;
      ++c.trailing_blank;
    }
    return true;
  });
}

Table TableReader::read(const Choice& choice) const {
  Table table;
  table.rows = rows_;
  table.inner_blank = inner_blank_;
  table.numbers.resize(choice.data.size());
  const std::size_t columns = table.numbers.size();
  tbb::parallel_for(std::size_t{0}, columns + (choice.stamps.empty() ? 0 : 1), [&](std::size_t i) {
    if (i < columns) {
      make_room(table.numbers[i], rows_);
    } else {
      make_room(table.stamps, rows_);
    }
  });

  const std::vector<Role> roles = roles_of(layout_, choice, table);
  std::atomic<bool> complete{true};
  if (layout_.dialect.delimiter == ' ') {
    parse_rows(RowParser<true>(layout_.dialect, roles, table, complete));
  } else {
    parse_rows(RowParser<false>(layout_.dialect, roles, table, complete));
  }
  table.complete = complete;
  return table;
}

template <class Parser>
void TableReader::parse_rows(const Parser& parser) const {
  std::vector<std::optional<Fault>> faults(chunks_.size());
  std::atomic<std::size_t> first_fault{chunks_.size()};
  tbb::parallel_for(std::size_t{0}, chunks_.size(), [&](std::size_t i) {
    if (i > first_fault.load(std::memory_order_relaxed)) return;  // an earlier one will be reported
    faults[i] =
        parse_chunk(parser, source_.text(), chunks_[i].begin, chunks_[i].end, chunks_[i].lines, chunks_[i].rows);
    std::size_t before = first_fault.load();
    while (faults[i] && i < before && !first_fault.compare_exchange_weak(before, i)) {
    }
    source_.release(source_.text().substr(chunks_[i].begin, chunks_[i].end - chunks_[i].begin));
  });
  if (first_fault == faults.size()) return;
  const Fault& f = *faults[first_fault];
  text::fail_at(source_.name(), f.line, static_cast<std::int64_t>(f.offset) + 1, f.message);
}

std::int64_t TableReader::line_of_row(std::size_t row) const {
  const auto next = std::ranges::upper_bound(chunks_, row, {}, &Chunk::rows);
  const Chunk& c = *std::prev(next);
  std::int64_t line = c.lines;
  std::size_t at = c.rows;
  for_each_line(source_.text(), c.begin, c.end, [&](std::size_t begin, std::size_t end) {
    ++line;
    return quick_kind(source_.text(), begin, end) != LineKind::data || at++ != row;
  });
  return line;
}

}  // namespace gyrobudget::inline v0::log
