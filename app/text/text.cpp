// SPDX-License-Identifier: MIT
#include "text.h"

#include <fmt/format.h>
#include <utf8.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <vector>

namespace gyrobudget::inline v0::text {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

// Calls `valid` with each stretch of well-formed UTF-8 and `invalid` for each byte between them.
template <class Valid, class Invalid>
void for_each_stretch(std::string_view text, const Valid& valid, const Invalid& invalid) {
  while (!text.empty()) {
    const std::size_t end = std::min(utf8::find_invalid(text), text.size());
    valid(text.substr(0, end));
    if (end == text.size()) return;
    invalid();
    text.remove_prefix(end + 1);
  }
}

/// What a terminal obeys instead of showing it: C0, DEL, C1, and what turns the direction of the text around it.
bool is_control(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || (c >= 0x202a && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

/// One line of well-formed UTF-8, control codes but those of `kept` as blanks.
std::string without_controls(std::string_view text, std::string_view kept) {
  std::string out;
  out.reserve(text.size());
  const auto copy = [&](std::string_view valid) {
    for (auto at = valid.begin(); at != valid.end();) {
      const auto begin = at;
      const std::uint32_t c = utf8::unchecked::next(at);
      const bool stays = !is_control(c) || (c < 0x80 && kept.find(static_cast<char>(c)) != std::string_view::npos);
      stays ? out.append(begin, at) : out.append(1, ' ');
    }
  };
  for_each_stretch(text, copy, [&] { out += '?'; });
  return out;
}

/// $'a\x1b': as shells since 2023's POSIX read it.
std::string ansi_c_word(std::string_view word) {
  std::string line = "$'";
  for (const char c : word) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte > 0x7e) {
      line += fmt::format("\\x{:02x}", byte);
      continue;
    }
    if (c == '\'' || c == '\\') line += '\\';
    line += c;
  }
  return line + "'";
}

}  // namespace

std::string_view trim(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

std::string shell_word(const std::string& word) {
  if (printable(word) != word) return ansi_c_word(word);
  if (!word.empty() && word.find_first_of(" \t\n'\"\\$`*?[](){}<>|&;#~!") == std::string::npos) return word;
  std::string line = "'";
  for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return line + "'";
}

std::string quoted(std::string_view found) {
  constexpr std::size_t kShown = 40;
  std::string result = "'";
  for (const char c : found.substr(0, kShown)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      result += fmt::format("\\x{:02x}", byte);
    } else {
      result += c;
    }
  }
  return to_utf8(result) + (found.size() > kShown ? "...'" : "'");
}

std::string to_utf8(std::string_view text) {
  if (utf8::is_valid(text)) return std::string(text);
  std::string result;
  for (const char c : text) utf8::append(static_cast<char32_t>(static_cast<unsigned char>(c)), result);
  return result;
}

std::string printable(std::string_view text) { return without_controls(text, ""); }
std::string printable_lines(std::string_view text) { return without_controls(text, "\n\t"); }

std::size_t length(std::string_view text) {
  std::size_t count = 0;
  for_each_stretch(
      text, [&](std::string_view s) { count += static_cast<std::size_t>(utf8::distance(s.begin(), s.end())); },
      [&] { ++count; });
  return count;
}

std::string shortened(const std::string& text, std::size_t limit) {
  const std::size_t all = length(text);
  if (all <= limit) return text;
  const std::size_t half = limit / 2;
  auto first = text.begin(), last = text.begin();
  utf8::advance(first, half - 1, text.end());
  utf8::advance(last, all - half, text.end());
  return std::string(text.begin(), first) + "…" + std::string(last, text.end());
}

std::string duration_text(double seconds, DurationForm form) {
  constexpr double kMinute = 60, kHour = 3600, kDay = 86400;
  const bool is_short = seconds < 2 * kMinute;
  switch (form) {
    case DurationForm::quoted:
      if (is_short) return fmt::format("{:.4g} s", seconds);
      if (seconds < 2 * kHour) return fmt::format("{:.4g} min", seconds / kMinute);
      if (seconds < 3 * kDay) return fmt::format("{:.4g} h", seconds / kHour);
      return fmt::format("{:.4g} days", seconds / kDay);
    case DurationForm::planned:
      if (is_short) return fmt::format("{:.3g} s", seconds);
      if (seconds < kHour) return fmt::format("{:.3g} min", seconds / kMinute);
      return fmt::format("{:.3g} h", seconds / kHour);
    case DurationForm::rough:
      if (is_short) return fmt::format("{:.0f} s", seconds);
      if (seconds < 2 * kHour) return fmt::format("{:.0f} min", seconds / kMinute);
      return fmt::format("{:.{}f} h", seconds / kHour, seconds < 100 * kHour ? 1 : 0);
  }
  throw std::invalid_argument("a duration has no such form");
}

std::string count_text(std::int64_t count) {
  std::string text = fmt::format("{}", count);
  for (auto at = static_cast<std::int64_t>(text.size()) - 3; at > (count < 0 ? 1 : 0); at -= 3) {
    text.insert(static_cast<std::size_t>(at), 1, ' ');
  }
  return text;
}

std::string suggestion(std::string_view word, std::span<const std::string> known) {
  constexpr std::size_t kLongest = 64;  // longer ones are no misspelt names
  if (word.empty() || word.size() > kLongest) return {};
  std::size_t best = 2 + word.size() / 4;
  const std::string* nearest = nullptr;
  for (const std::string& candidate : known) {
    if (candidate.size() > kLongest) continue;
    const std::size_t distance = edit_distance(lower(word), lower(candidate));
    if (distance < best && distance < candidate.size()) {
      best = distance;
      nearest = &candidate;
    }
  }
  return nearest ? fmt::format(" (did you mean '{}'?)", *nearest) : std::string();
}

std::string listing(std::span<const std::string> words, std::string_view last) {
  std::string result;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) result += i + 1 < words.size() ? ", " : fmt::format(" {} ", last);
    result += words[i];
  }
  return result;
}

void fail(std::string_view name, std::string_view message) { throw InputError(fmt::format("{}: {}", name, message)); }

void fail_at(std::string_view name, std::int64_t line, std::int64_t column, std::string_view message) {
  throw InputError(fmt::format("{}:{}:{}: {}", name, line, column, message));
}

}  // namespace gyrobudget::inline v0::text
