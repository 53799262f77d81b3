// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

// Text for terminals: columns and lines of one width.
namespace gyrobudget::inline v0::report {

inline constexpr std::size_t kLineWidth = 100;

/// Columns that take, on a terminal, as many cells as the text has code points.
[[nodiscard]] std::size_t width(std::string_view text);

enum class Align { left, right };

/// A table whose columns are as wide as what stands in them.
class TextTable {
 public:
  explicit TextTable(std::vector<Align> columns) : columns_(std::move(columns)) {}
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Every row as a line.
  [[nodiscard]] std::string text() const;
  /// The lines one by one, without line feed.
  [[nodiscard]] std::vector<std::string> lines() const;

 private:
  [[nodiscard]] std::string line(const std::vector<std::string>& cells, const std::vector<std::size_t>& widths) const;

  std::vector<Align> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Text broken into lines that start with `first`, then `later`; a number stays with the word behind it. Empty text
/// gives nothing.
[[nodiscard]] std::string wrapped(std::string_view text, std::string_view first, std::string_view later);

}  // namespace gyrobudget::inline v0::report
