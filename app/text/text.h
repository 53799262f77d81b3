// SPDX-License-Identifier: MIT
// Words, messages and places in files.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "error.h"

namespace gyrobudget::inline v0::text {

[[nodiscard]] constexpr bool is_blank(char c) { return c == ' ' || c == '\t'; }
[[nodiscard]] constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Without blanks and carriage returns at either end.
[[nodiscard]] std::string_view trim(std::string_view);
/// ASCII letters in lower case; other bytes as they are.
[[nodiscard]] std::string lower(std::string_view);
/// A word of a command line, between quotes where a shell would read something into it; as $'a\x1b' where it holds what
/// printable() would take out.
[[nodiscard]] std::string shell_word(const std::string& word);
/// 'what was found', fit for one line of a message: control bytes as \xNN, at most 40 bytes shown.
[[nodiscard]] std::string quoted(std::string_view found);
/// The text as UTF-8: as it is where it is valid, read as Latin-1 otherwise (the degree sign of old loggers).
[[nodiscard]] std::string to_utf8(std::string_view);
/// Text of a user's as one line of well-formed UTF-8: control codes (those that a terminal obeys, and those that turn
/// the direction of writing) become blanks, bytes that are no UTF-8 "?".
[[nodiscard]] std::string printable(std::string_view text);
/// The same of a text that may have lines and tabs.
[[nodiscard]] std::string printable_lines(std::string_view text);
/// Number of characters (code points) of UTF-8; a byte that is none counts as one.
[[nodiscard]] std::size_t length(std::string_view utf8);
/// At most `limit` (2 or more) characters of well-formed UTF-8, the middle left out: "gyro_…_left".
/// @throws std::exception for text that is not well formed.
[[nodiscard]] std::string shortened(const std::string& utf8, std::size_t limit);
/// " (did you mean 'x'?)" with the nearest of the known words, empty where none is near.
[[nodiscard]] std::string suggestion(std::string_view word, std::span<const std::string> known);
/// "a, b and c".
[[nodiscard]] std::string listing(std::span<const std::string> words, std::string_view last = "and");

/// How long something lasts, as it is quoted, planned or guessed.
enum class DurationForm {
  quoted,   ///< four digits: "90.25 s", "45 min", "10 h", "12.5 days"
  planned,  ///< three digits, minutes below an hour, never days: "90 s", "45 min", "1.5 h", "300 h"
  rough,    ///< whole numbers, hours to a tenth below 100 h: "90 s", "45 min", "10.0 h"
};
[[nodiscard]] std::string duration_text(double seconds, DurationForm form = DurationForm::quoted);
/// "3 600 000": thousands apart.
[[nodiscard]] std::string count_text(std::int64_t count);

/// @throws InputError "name: message"
[[noreturn]] void fail(std::string_view name, std::string_view message);
/// @throws InputError "name:line:column: message"; line and column count from 1, columns in bytes.
[[noreturn]] void fail_at(std::string_view name, std::int64_t line, std::int64_t column, std::string_view message);

}  // namespace gyrobudget::inline v0::text
