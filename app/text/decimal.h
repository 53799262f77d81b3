// SPDX-License-Identifier: MIT
// Decimal digits as integers, eight at a time, and such integers as correctly rounded doubles.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "text.h"

namespace gyrobudget::inline v0::text {

/// digits * 10^exponent, as written.
struct Decimal {
  std::uint64_t digits = 0;
  int exponent = 0;
  bool negative = false;
};

inline constexpr auto kPowersOfTen = [] {
  std::array<std::int64_t, 19> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 10 * powers[i - 1];
  return powers;
}();

/// The value of eight characters less '0' each, the first one in the lowest byte: pairs, fours, then all eight.
[[nodiscard]] constexpr std::uint64_t value_of_eight(std::uint64_t digits) {
  digits = digits * 10 + (digits >> 8);
  constexpr std::uint64_t kEvery32 = 0x000000FF000000FF;
  constexpr std::uint64_t kFirstPairs = 0x000F424000000064, kSecondPairs = 0x0000271000000001;
  return ((digits & kEvery32) * kFirstPairs + (digits >> 16 & kEvery32) * kSecondPairs) >> 32;
}

/// Text that must follow the start of a decimal: it is read in whole words, wherever it ends.
inline constexpr std::ptrdiff_t kDecimalRoom = 64;

/// Appends the digits that start at `at`, up to 24 of them (then `digits` has wrapped round). @returns behind them
[[nodiscard]] inline const char* scan_digits(const char* at, std::uint64_t& digits) {
  static_assert(std::endian::native == std::endian::little, "the first character must be the lowest byte");
  for (int words = 0; words < 3; ++words) {
    std::uint64_t word = 0;
    std::memcpy(&word, at, sizeof word);
    word ^= 0x3030303030303030;  // digits become 0 to 9, every other character more
    const std::uint64_t others = ((word + 0x7676767676767676) | word) & 0x8080808080808080;
    if (others != 0) {
      const int bits = std::countr_zero(others) & ~7;  // of the digits in front; they move to the top
      const auto count = static_cast<std::size_t>(bits / 8);
      digits = digits * static_cast<std::uint64_t>(kPowersOfTen[count]) + value_of_eight((word << 1) << (63 - bits));
      return at + count;
    }
    digits = digits * 100'000'000 + value_of_eight(word);
    at += sizeof word;
  }
  return at;
}

/// A plain number of at most 19 digits, leading zeros counted: -12, 0.5, .5, 5., 1.5e-07.
/// @returns behind it; null for any other, which may be a number all the same, and within kDecimalRoom of the end
[[nodiscard]] inline const char* scan_decimal(const char* at, const char* end, char point, Decimal& d) {
  constexpr std::ptrdiff_t kMostDigits = 19;  // fewer than 2^64
  if (end - at < kDecimalRoom) return nullptr;
  d.negative = *at == '-';
  at += d.negative ? 1 : 0;
  d.digits = 0;
  d.exponent = 0;
  const char* first = at;
  if (is_digit(at[0]) && at[1] == point) {  // by far the most
    d.digits = static_cast<std::uint64_t>(*at++ - '0');
  } else {
    at = scan_digits(at, d.digits);
  }
  std::ptrdiff_t count = at - first;
  if (*at == point) {
    first = ++at;
    at = scan_digits(at, d.digits);
    count += at - first;
    d.exponent = -static_cast<int>(at - first);
  }
  if (count == 0 || count > kMostDigits) return nullptr;
  if ((*at | 0x20) != 'e') return at;
  const bool negative = at[1] == '-';
  at += negative || at[1] == '+' ? 2 : 1;
  if (!is_digit(*at)) return nullptr;
  int exponent = *at++ - '0';
  if (is_digit(*at)) exponent = 10 * exponent + (*at++ - '0');
  if (is_digit(*at)) return nullptr;
  d.exponent += negative ? -exponent : exponent;
  return at;
}

/// digits / 10^places, correctly rounded (to nearest, ties to even), for digits above 0 and places from 1 to 27.
///
/// 5^27 has 63 bits. With both numbers shifted to 64 bits the quotient of digits * 2^63 has at least 63 bits; one more
/// bit for a remainder other than zero, and the rounding of 64 bits to the 53 of a double is that of the true value.
[[nodiscard]] inline double divided_by_power_of_ten(std::uint64_t digits, int places) {
  constexpr auto kPowersOfFive = [] {
    std::array<std::uint64_t, 28> powers{1};
    for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 5 * powers[i - 1];
    return powers;
  }();
  const std::uint64_t five = kPowersOfFive[static_cast<std::size_t>(places)];
  const int up = std::countl_zero(digits), down = std::countl_zero(five);
  __extension__ using Wide = unsigned __int128;
  const Wide dividend = static_cast<Wide>(digits << up) << 63;
  const std::uint64_t divisor = five << down;
  const auto quotient = static_cast<std::uint64_t>(dividend / divisor);
  const bool remainder = static_cast<std::uint64_t>(dividend) != quotient * divisor;
  constexpr int kBias = 1023, kMantissa = 52;  // of a double; the power of two is far from its limits
  const auto power = static_cast<std::uint64_t>(kBias + down - up - places - 63) << kMantissa;
  return static_cast<double>(quotient | (remainder ? 1U : 0U)) * std::bit_cast<double>(power);
}

/// The double nearest to a decimal number; false where it is none of the usual ones (value is not set).
[[nodiscard]] inline bool to_double(const Decimal& d, double& value) {
  constexpr std::uint64_t kExact = std::uint64_t{1} << 53;
  constexpr int kMostExact = 22, kMostPlaces = 27;  // 10^22 is a double, 5^27 a 64-bit integer
  constexpr auto kPowers = [] {
    std::array<double, kMostExact + 1> powers{1};
    for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = 10 * powers[i - 1];
    return powers;
  }();
  double magnitude = 0;
  if (d.digits <= kExact && d.exponent <= 0 && d.exponent >= -kMostExact) {  // both exact: one rounding
    magnitude =
        static_cast<double>(static_cast<std::int64_t>(d.digits)) / kPowers[static_cast<std::size_t>(-d.exponent)];
  } else if (d.digits <= kExact && d.exponent > 0 && d.exponent <= kMostExact) {
    magnitude =
        static_cast<double>(static_cast<std::int64_t>(d.digits)) * kPowers[static_cast<std::size_t>(d.exponent)];
  } else if (d.digits != 0 && d.exponent < 0 && d.exponent >= -kMostPlaces) {
    magnitude = divided_by_power_of_ten(d.digits, -d.exponent);
  } else {
    return false;
  }
  // Signs change at random: no branch.
  const std::uint64_t sign = static_cast<std::uint64_t>(d.negative) << 63;
  value = std::bit_cast<double>(std::bit_cast<std::uint64_t>(magnitude) | sign);
  return true;
}

}  // namespace gyrobudget::inline v0::text
