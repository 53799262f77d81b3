// SPDX-License-Identifier: MIT
// The numbers of a log, parsed on all cores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bytes.h"
#include "columns.h"
#include "layout.h"

namespace gyrobudget::inline v0::log {

struct Table {
  std::vector<std::vector<double>> numbers;  ///< one for each data column, times its to_si; NaN where missing
  std::vector<std::int64_t> stamps;          ///< [ns], kNoStamp where missing; empty without time column
  std::size_t rows = 0;
  std::size_t inner_blank = 0;  ///< blank lines between the first and the last row
  bool complete = true;         ///< no number is missing: there is no NaN to look for
};

/// The rows of a log, in chunks of whole lines.
class TableReader {
 public:
  /// Counts the rows. @throws InputError for a line of more than kLongestLine bytes.
  TableReader(const Bytes&, const Layout&, std::size_t chunk_bytes);

  /// Parses the chosen columns, the others are only counted.
  /// @throws InputError for the first row in the file that is not as it should be.
  [[nodiscard]] Table read(const Choice&) const;

  /// Number of the line in which a row stands, from 1.
  [[nodiscard]] std::int64_t line_of_row(std::size_t row) const;

 private:
  struct Chunk {
    std::size_t begin = 0, end = 0;             ///< the lines that start here are its own
    std::int64_t lines = 0;                     ///< in it; after construction: above it, in the whole file
    std::size_t rows = 0;                       ///< in it; after construction: in all chunks before it
    std::size_t blank = 0, trailing_blank = 0;  ///< blank lines, and those behind its last row
    std::size_t long_line = std::string_view::npos;
  };
  void count(Chunk&) const;
  /// Fast, for chunks that hold nothing but rows. @returns false where this one does not
  bool count_plain(Chunk&) const;
  void count_kinds(Chunk&) const;
  template <class Parser>
  void parse_rows(const Parser&) const;

  const Bytes& source_;
  const Layout& layout_;
  std::vector<Chunk> chunks_;
  std::size_t rows_ = 0;
  std::size_t inner_blank_ = 0;
};

}  // namespace gyrobudget::inline v0::log
