// SPDX-License-Identifier: MIT
#include "number.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "decimal.h"
#include "text.h"

namespace gyrobudget::inline v0::text {
namespace {

/// What programs write where there is no number, beside what from_chars reads as NaN and Inf.
constexpr std::array<std::string_view, 11> kMissing = {"na",      "n/a",     "null",   "none",   "nil",    "-",
                                                       "1.#qnan", "-1.#ind", "1.#ind", "1.#inf", "-1.#inf"};

bool is_missing_word(std::string_view cell) {
  constexpr std::size_t kLongest = 8;
  return cell.size() <= kLongest && std::ranges::find(kMissing, lower(cell)) != kMissing.end();
}

std::string_view unquoted(std::string_view cell) {
  cell = trim(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') return trim(cell.substr(1, cell.size() - 2));
  return cell;
}

/// 0,5 as 0.5; empty where it is no decimal number with at most one comma between digits.
std::string with_point(std::string_view cell) {
  std::string result(cell);
  const std::size_t comma = result.find(',');
  if (comma == std::string::npos) return result.find('.') == std::string::npos ? result : std::string();
  const bool between_digits =
      comma > 0 && is_digit(result[comma - 1]) && comma + 1 < result.size() && is_digit(result[comma + 1]);
  if (!between_digits || result.find_first_of(",.", comma + 1) != std::string::npos) return {};
  result[comma] = '.';
  return result.find('.') == comma ? result : std::string();
}

// --- Time stamps -----------------------------------------------------------------------------------------------

__extension__ using Wide = unsigned __int128;

/// Reads as many characters as belong to the number; null where there is none.
const char* read_decimal(const char* at, const char* end, char point, Decimal& d) {
  d.negative = at < end && *at == '-';
  if (at < end && (*at == '-' || *at == '+')) ++at;
  constexpr std::uint64_t kFull = (std::numeric_limits<std::uint64_t>::max() - 9) / 10;
  bool any = false;
  bool behind_point = false;
  for (; at < end; ++at) {
    if (*at == point && !behind_point) {
      behind_point = true;
    } else if (is_digit(*at)) {
      any = true;
      if (d.digits <= kFull) {
        d.digits = 10 * d.digits + static_cast<std::uint64_t>(*at - '0');
        d.exponent -= behind_point ? 1 : 0;
      } else {
        d.exponent += behind_point ? 0 : 1;  // more digits than matter
      }
    } else {
      break;
    }
  }
  if (!any) return nullptr;
  if (at < end && (*at == 'e' || *at == 'E')) {
    int exponent = 0;
    const char* first = at + 1 + (end - at > 1 && at[1] == '+' ? 1 : 0);
    const auto [stop, error] = std::from_chars(first, end, exponent);
    if (error == std::errc::invalid_argument) return nullptr;
    constexpr int kEnough = 1000;
    d.exponent += error == std::errc{} ? std::clamp(exponent, -kEnough, kEnough) : (*first == '-' ? -kEnough : kEnough);
    at = stop;
  }
  return at;
}

/// digits * 10^exponent * unit, rounded; false where it does not fit.
bool to_nanoseconds(const Decimal& d, std::int64_t unit, std::int64_t& ns) {
  if (d.exponent <= 0 && -d.exponent < static_cast<int>(kPowersOfTen.size())) {  // the usual case, in 64 bits
    const std::int64_t power = kPowersOfTen[static_cast<std::size_t>(-d.exponent)];
    if (unit % power == 0 && !__builtin_mul_overflow(d.digits, unit / power, &ns)) {
      if (d.negative) ns = -ns;
      return true;
    }
  }
  Wide value = static_cast<Wide>(d.digits) * static_cast<std::uint64_t>(unit);
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  for (int i = 0; i < d.exponent && value != 0; ++i) {
    if (value > kLargest) return false;
    value *= 10;
  }
  constexpr int kMostDigits = 38;  // of Wide; what is beyond them is zero
  if (-d.exponent > kMostDigits) value = 0;
  if (d.exponent < 0 && value != 0) {
    Wide power = 1;
    for (int i = 0; i < -d.exponent; ++i) power *= 10;
    value = value / power + (value % power >= power - value % power ? 1 : 0);
  }
  if (value > kLargest) return false;
  ns = static_cast<std::int64_t>(value) * (d.negative ? -1 : 1);
  return true;
}

Cell parse_point_number(std::string_view cell, double& value) {
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return Cell::text;
  if (error == std::errc::result_out_of_range) {  // too large or too small?
    Decimal decimal;
    read_decimal(cell.data(), end, '.', decimal);
    if (decimal.digits != 0 && decimal.exponent > 0) return Cell::beyond;
    value = decimal.negative ? -0.0 : 0.0;
    return Cell::number;
  }
  return std::isfinite(value) ? Cell::number : Cell::missing;
}

}  // namespace

Cell parse_number(std::string_view cell, bool decimal_comma, double& value) {
  cell = unquoted(cell);
  Cell kind = Cell::missing;
  if (!cell.empty()) {
    std::string_view number = cell;
    if (number.size() > 1 && number[0] == '+' && number[1] != '-') number.remove_prefix(1);
    const std::string converted = decimal_comma ? with_point(number) : std::string();
    kind = parse_point_number(decimal_comma && !converted.empty() ? converted : number, value);
    // A number with a point in a file of decimal commas may be a thousands separator: no guess.
    if (decimal_comma && converted.empty() && kind == Cell::number) kind = Cell::text;
    if (kind == Cell::text && is_missing_word(cell)) kind = Cell::missing;
  }
  if (kind != Cell::number) value = std::numeric_limits<double>::quiet_NaN();
  return kind;
}

Cell parse_stamp(std::string_view cell, bool decimal_comma, std::int64_t ns_per_unit, std::int64_t& ns) {
  cell = unquoted(cell);
  const char* end = cell.data() + cell.size();
  Decimal decimal;
  if (!cell.empty() && read_decimal(cell.data(), end, decimal_comma ? ',' : '.', decimal) == end) {
    if (to_nanoseconds(decimal, ns_per_unit, ns)) return Cell::number;
    ns = kNoStamp;
    return Cell::beyond;
  }
  ns = kNoStamp;
  double ignored = 0;
  return parse_number(cell, decimal_comma, ignored) == Cell::missing ? Cell::missing : Cell::text;
}

const char* scan_unusual_number(const char* begin, const char* end, bool decimal_comma, double& value) {
  if (decimal_comma) return nullptr;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc{} ? stop : nullptr;
}

const char* scan_stamp(const char* begin, const char* end, bool decimal_comma, std::int64_t ns_per_unit,
                       std::int64_t& ns) {
  Decimal decimal;
  const char* stop = scan_decimal(begin, end, decimal_comma ? ',' : '.', decimal);
  return stop && to_nanoseconds(decimal, ns_per_unit, ns) ? stop : nullptr;
}

}  // namespace gyrobudget::inline v0::text
