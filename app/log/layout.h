// SPDX-License-Identifier: MIT
// How the text of a log is laid out, found from its first lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"

namespace gyrobudget::inline v0::log {

/// How a row is cut into cells.
struct Dialect {
  char delimiter = ',';        ///< ' ' stands for any run of blanks and tabs
  bool decimal_comma = false;  ///< 0,5 is a half
};

enum class LineKind { blank, comment, data };
/// A line without its '\n'. Comments start with #, % or //.
[[nodiscard]] LineKind kind_of(std::string_view line);

/// The cells of a row, trimmed.
[[nodiscard]] std::vector<std::string_view> split(std::string_view line, char delimiter);

/// A name in the header: `gyro_x (deg/s)` has the unit "deg/s"; without brackets at its end it has none. An integer in
/// brackets belongs to the name, `gyro_rad[0]`, except the 1 of `x (1)`.
struct Heading {
  std::string name;
  std::string unit;
  std::int64_t column = 1;        ///< where it stands in its line, from 1
  bool bracketed_behind = false;  ///< the unit stood in [] right behind the name
};

struct Layout {
  Dialect dialect;
  std::size_t columns = 0;
  std::vector<Heading> headings;                      ///< one for each column, or empty
  std::int64_t heading_line = 0;                      ///< its number, from 1; 0 without header
  std::size_t body = 0;                               ///< where the first row starts in the text
  std::int64_t body_line = 0;                         ///< its number, from 1
  std::vector<std::vector<std::string_view>> sample;  ///< the cells of the first rows
  std::vector<std::string_view> preamble;             ///< lines above header and rows that are neither, nor comments
  bool is_cut = false;                                ///< the preamble is the end of a row
  std::string_view first_line;                        ///< of the text, whatever it is
  std::vector<std::string> notes;                     ///< which line was taken for what, where that is not plain
};

/// Finds delimiter, decimal mark, header and units. The header is a first line without numbers, or the comment line
/// just above the rows that has as many cells and is no prose; a line of units may follow it. Lines above the header
/// that have other cells than rows and names (a preamble, `sep=;`) are skipped, and so is a first row that was cut.
/// @throws InputError where there are no rows, or where commas may be delimiters and decimal marks alike.
[[nodiscard]] Layout read_layout(const Bytes&);

}  // namespace gyrobudget::inline v0::log
