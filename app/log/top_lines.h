// SPDX-License-Identifier: MIT
// Inside the reading of layouts: what the first lines of a text are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "layout.h"

namespace gyrobudget::inline v0::log {

struct NumberedLine {
  std::string_view text;
  std::size_t begin = 0;
  std::int64_t number = 0;
};

[[nodiscard]] std::size_t count_numbers(const std::vector<std::string_view>& cells, bool decimal_comma);
/// An empty cell, nan and the like.
[[nodiscard]] bool is_missing(std::string_view cell);
/// Cells of a header: a delimiter inside quotes or brackets does not count, and "time (s)" is one cell among blanks.
[[nodiscard]] std::vector<std::string_view> split_header(std::string_view line, char delimiter);

/// The delimiter that a line `sep=;` tells, as spreadsheets write and read it; empty for every other line.
[[nodiscard]] std::optional<char> told_delimiter(std::string_view line);

/// The dialect that explains the rows best.
/// @param source  for messages
/// @param above   the line over the rows, a header or not
/// @param told    delimiter that the file tells
/// @throws InputError where commas may be delimiters and decimal marks alike.
[[nodiscard]] Dialect find_dialect(const Bytes& source, const NumberedLine& above, std::vector<NumberedLine> rows,
                                   std::optional<char> told);

/// Lines above the header, or above the first row, that are neither.
struct Preamble {
  std::size_t length = 0;   ///< lines
  bool is_cut_row = false;  ///< the only line of it is the end of a row
};
/// Judged by the last of the lines, which are rows if anything is. Where the lines are in order, or where nothing but a
/// fault explains them, there is no preamble.
/// @param dialect  what find_dialect says of them
[[nodiscard]] Preamble find_preamble(const std::vector<NumberedLine>& lines, Dialect dialect, std::optional<char> told);

}  // namespace gyrobudget::inline v0::log
