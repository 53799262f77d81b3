// SPDX-License-Identifier: MIT
// The fast reading of decimal numbers is that of std::from_chars, to the bit and to the character.
#include "gyrobudget/app/text/number.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <random>
#include <string>

namespace gyrobudget::text {
namespace {

/// As it stands in a log: something follows, and it is not of the number.
std::string in_text(const std::string& number) { return number + "," + std::string(kDecimalRoom, 'x'); }

/// @returns what differs from std::from_chars, or nothing
std::string difference(const std::string& number) {
  const std::string text = in_text(number);
  const char* end = text.data() + text.size();
  double expected = 0, found = 0;
  const auto [stop, error] = std::from_chars(text.data(), end, expected);
  const char* found_stop = scan_number(text.data(), end, false, found);
  if (error != std::errc{}) return found_stop == nullptr ? "" : number + " is read as a number";
  if (found_stop != stop) return number + " ends elsewhere";
  return std::bit_cast<std::uint64_t>(found) == std::bit_cast<std::uint64_t>(expected)
             ? ""
             : fmt::format("{} is {:a}, not {:a}", number, expected, found);
}

class Numbers {
 public:
  std::uint64_t below(std::uint64_t limit) { return engine_() % limit; }
  std::uint64_t bits() { return engine_(); }

  /// Up to 21 digits with a sign, a point and an exponent anywhere.
  std::string decimal() {
    const std::uint64_t count = 1 + below(21);
    const std::uint64_t point = below(count + 2);
    std::string text = below(2) == 0 ? "-" : "";
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i == point) text += '.';
      text += static_cast<char>('0' + (below(4) == 0 ? 0 : below(10)));
    }
    if (point == count) text += '.';
    constexpr int kLargest = 40;
    const int exponent = static_cast<int>(below(2 * kLargest + 1)) - kLargest;
    constexpr const char* kForms[] = {"{}", "{}e{}", "{}E{:+}", "{}e{:03}"};
    return fmt::format(fmt::runtime(kForms[below(4)]), text, exponent);
  }

 private:
  std::mt19937_64 engine_{1};
};

constexpr int kNumbers = 400'000;

TEST(ScanNumber, DecimalsOfAnyShapeAreThoseOfFromChars) {
  Numbers numbers;
  for (int i = 0; i < kNumbers; ++i) ASSERT_EQ(difference(numbers.decimal()), "");
}

TEST(ScanNumber, ShortestFormsOfDoublesAreThoseOfFromChars) {
  Numbers numbers;
  constexpr int kNear = 60;  // powers of two about 1, where logs live; every other number has any exponent
  for (int i = 0; i < kNumbers; ++i) {
    const std::uint64_t near = numbers.bits() >> 12 | (1023 - kNear / 2 + numbers.below(kNear)) << 52;
    const auto value = std::bit_cast<double>(i % 2 == 0 ? near : numbers.bits());
    ASSERT_EQ(difference(fmt::format("{}", value)), "");
    ASSERT_EQ(difference(fmt::format("{:.17g}", value)), "");
  }
}

TEST(ScanNumber, ATieBetweenTwoDoublesGoesToTheEvenOne) {
  // (2^53 + odd)/2^places lies halfway between two doubles and has at most 19 digits as (2^53 + odd) 5^places.
  Numbers numbers;
  for (int i = 0; i < kNumbers / 4; ++i) {
    std::uint64_t digits = (std::uint64_t{1} << 53) + 2 * numbers.below(std::uint64_t{1} << 52) + 1;
    const int places = 1 + static_cast<int>(numbers.below(4));
    for (int k = 0; k < places; ++k) digits *= 5;
    for (const std::uint64_t near : {digits - 1, digits, digits + 1}) {
      double value = 0;
      ASSERT_TRUE(to_double({near, -places, false}, value));  // without from_chars
      std::string text = fmt::format("{}", near);
      ASSERT_EQ(difference(text.insert(text.size() - static_cast<std::size_t>(places), 1, '.')), "");
    }
  }
}

TEST(ScanNumber, EveryLengthOfDigitsIsReadToItsEnd) {
  for (std::size_t whole = 0; whole < 26; ++whole) {
    for (std::size_t places = 0; places < 26; ++places) {
      std::string text;
      for (std::size_t i = 0; i < whole + places; ++i) text += static_cast<char>('1' + i % 9);
      EXPECT_EQ(difference(text), "");
      EXPECT_EQ(difference(text.insert(whole, 1, '.')), "");
    }
  }
}

TEST(ScanNumber, WhatIsNoPlainNumberIsLeftToTheWholeCell) {
  for (const char* text : {"",    "-",   ".",     "-.",      "+1",    "e5",  "1e", "1e+", "1e5000", "--1", "0x10",
                           "nan", "inf", "1e400", "-1e-400", "1.2.3", "1,5", " 1", "/",   ":",      "\xb0"}) {
    EXPECT_EQ(difference(text), "") << text;
  }
}

TEST(ScanNumber, ANumberAtTheEndOfTheTextIsReadAsWell) {
  for (const std::string text : {"0.25", "-1e-3", "12345678901234567890", "0.099134701513277898"}) {
    double expected = 0, found = 0;
    std::from_chars(text.data(), text.data() + text.size(), expected);
    EXPECT_EQ(scan_number(text.data(), text.data() + text.size(), false, found), text.data() + text.size());
    EXPECT_EQ(found, expected);
  }
}

TEST(ScanNumber, ADecimalCommaIsThePointOfItsFile) {
  const std::string text = in_text("-0,25;");
  double value = 0;
  EXPECT_EQ(scan_number(text.data(), text.data() + text.size(), true, value), text.data() + 5);
  EXPECT_EQ(value, -0.25);
}

TEST(ScanStamp, IsThatOfTheWholeCell) {
  Numbers numbers;
  for (int i = 0; i < kNumbers / 4; ++i) {
    const std::string number = numbers.decimal(), text = in_text(number);
    for (const std::int64_t unit : {1, 1'000, 1'000'000'000}) {
      std::int64_t expected = 0, found = 0;
      const char* stop = scan_stamp(text.data(), text.data() + text.size(), false, unit, found);
      if (!stop) continue;
      ASSERT_EQ(parse_stamp(number, false, unit, expected), Cell::number) << number;
      ASSERT_EQ(found, expected) << number;
      ASSERT_EQ(stop, text.data() + number.size()) << number;
    }
  }
}

}  // namespace
}  // namespace gyrobudget::text
