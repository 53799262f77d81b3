// SPDX-License-Identifier: MIT
#include "layout.h"

#include "gyrobudget/app/text/text.h"

#include <algorithm>
#include <cctype>

namespace gyrobudget::inline v0::report {

std::size_t width(std::string_view text) { return text::length(text); }

std::vector<std::string> TextTable::lines() const {
  std::vector<std::size_t> widths(columns_.size(), 0);
  for (const auto& cells : rows_) {
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], width(cells[i]));
  }
  std::vector<std::string> list;
  for (const auto& cells : rows_) list.push_back(line(cells, widths));
  return list;
}

std::string TextTable::text() const {
  std::string out;
  for (const std::string& l : lines()) out += l + '\n';
  return out;
}

std::string TextTable::line(const std::vector<std::string>& cells, const std::vector<std::size_t>& widths) const {
  std::string out;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string padding(widths[i] - width(cells[i]), ' ');
    out += "  " + (columns_[i] == Align::left ? cells[i] + padding : padding + cells[i]);
  }
  out.erase(out.find_last_not_of(' ') + 1);
  return out;
}

namespace {

/// The next piece of a text that must not be broken: a word, or numbers with the word behind them ("0.70 deg/h").
std::string_view take_piece(std::string_view& text) {
  std::size_t end = text.find(' ');
  while (end != std::string_view::npos && end > 0 && std::isdigit(static_cast<unsigned char>(text[end - 1])) != 0) {
    end = text.find(' ', end + 1);
  }
  const std::string_view piece = text.substr(0, end);
  text.remove_prefix(std::min(piece.size() + 1, text.size()));
  return piece;
}

}  // namespace

std::string wrapped(std::string_view text, std::string_view first, std::string_view later) {
  std::string out, line(first);
  bool empty = true;
  while (!text.empty()) {
    const std::string_view piece = take_piece(text);
    if (!empty && width(line) + 1 + width(piece) > kLineWidth) {
      out += line + '\n';
      line = later;
      empty = true;
    }
    if (!empty) line += ' ';
    line += piece;
    empty = false;
  }
  return empty ? out : out + line + '\n';
}

}  // namespace gyrobudget::inline v0::report
