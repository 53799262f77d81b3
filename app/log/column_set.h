// SPDX-License-Identifier: MIT
// Inside the choice of columns: the columns of a layout, and what their first rows hold.
#pragma once

#include "gyrobudget/noise/units.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calendar.h"
#include "layout.h"

namespace gyrobudget::inline v0::log {

struct Column {
  std::size_t index = 0;
  std::string name;                 ///< without unit; "column 3" where there is no header
  std::string unit_text;            ///< of the header
  std::optional<noise::Unit> unit;  ///< of the header, where it is understood
  std::int64_t place = 1;           ///< where its heading stands in its line
};

/// The columns of one log. Source and layout must outlive it.
class ColumnSet {
 public:
  /// @param unit_is_given  by the user, for data: then a dialect tells of the clock alone
  ColumnSet(const std::string& source, const Layout& layout, bool unit_is_given);

  [[nodiscard]] const std::string& source() const { return source_; }
  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] const std::vector<Column>& all() const { return columns_; }
  /// Which dialect told the units; empty where none did.
  [[nodiscard]] const std::string& dialect_note() const { return dialect_note_; }
  [[nodiscard]] bool has_header() const { return !layout_.headings.empty(); }
  /// "column 'gx'", or "column 3" without a header.
  [[nodiscard]] std::string described(const Column& column) const;

  /// By its name, with its unit or without, or by its number (from 1); empty where there is none.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view wanted) const;
  /// The same. @throws InputError where there is none, with what there is.
  [[nodiscard]] std::size_t get(std::string_view wanted) const;

  /// @throws InputError at the heading of the column, or at the first row.
  [[noreturn]] void fail_at_heading(const Column& column, const std::string& message) const;
  /// @throws InputError at the header, or at the first row.
  [[noreturn]] void fail_at_header(const std::string& message) const;

  // What the first rows hold.

  /// Its cells, without those of rows that are too short.
  [[nodiscard]] std::vector<std::string_view> cells(const Column& column) const;
  /// Every cell is empty, nan or the like.
  [[nodiscard]] bool is_empty(const Column& column) const;
  [[nodiscard]] bool holds_stamps(const Column& column) const;  ///< a number at least once
  /// The form of all its dates or times of day; empty where there is other text, or none but numbers.
  [[nodiscard]] std::optional<StampForm> calendar(const Column& column) const;
  /// Its numbers; empty where there is anything else.
  [[nodiscard]] std::vector<double> numbers(const Column& column) const;

 private:
  [[nodiscard]] Column column(std::size_t index) const;

  const std::string& source_;
  const Layout& layout_;
  std::vector<Column> columns_;
  std::string dialect_note_;
};

/// What a header says where a column holds raw counts: the size of one must come from the options.
[[nodiscard]] bool means_counts(const std::string& unit);

}  // namespace gyrobudget::inline v0::log
