// SPDX-License-Identifier: MIT
#include "gyrobudget/app/text/text.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace gyrobudget::text {
namespace {

// --- UTF-8 ----------------------------------------------------------------------------------------------------------

constexpr const char* kRocket = "\xf0\x9f\x9a\x80";

TEST(Utf8, IsKeptAndOtherBytesAreLatin1) {
  EXPECT_EQ(to_utf8("°/s √h"), "°/s √h");
  EXPECT_EQ(to_utf8(kRocket), kRocket);
  EXPECT_EQ(to_utf8("\xb0/s"), "°/s");
  EXPECT_EQ(to_utf8("\xff"), "ÿ");
  EXPECT_EQ(to_utf8("\xc0\x80"), "\xc3\x80\xc2\x80");  // overlong: no UTF-8
  EXPECT_EQ(to_utf8(""), "");
}

TEST(Utf8, NamesBecomeOnePrintableLine) {
  EXPECT_EQ(printable("gyro_x \xc2\xb0/s \xe2\x88\x9ah \xf0\x9f\x9a\x80"), "gyro_x °/s √h \xf0\x9f\x9a\x80");
  EXPECT_EQ(printable("a\nb\tc\x1b[31m\x7f"), "a b c [31m ");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a b");
  EXPECT_EQ(printable("\xb0/s"), "?/s");             // Latin-1
  EXPECT_EQ(printable("\xc0\x80"), "??");            // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "???");       // surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "????");  // beyond U+10FFFF
  EXPECT_EQ(printable("\xe2\x88"), "??");            // cut short
  EXPECT_EQ(printable("\xe2\x88x"), "??x");
}

TEST(Utf8, LengthCountsCharacters) {
  EXPECT_EQ(length(""), 0U);
  EXPECT_EQ(length("deg/h"), 5U);
  EXPECT_EQ(length("°/√h"), 4U);
  EXPECT_EQ(length(kRocket), 1U);
  EXPECT_EQ(length("a\xb0z"), 3U);
}

TEST(Utf8, LongNamesLoseTheirMiddle) {
  EXPECT_EQ(shortened("gyro_x", 6), "gyro_x");
  EXPECT_EQ(shortened("°°°°°°", 6), "°°°°°°");
  EXPECT_EQ(shortened("abcdefghij", 6), "ab…hij");
  EXPECT_EQ(shortened("°√°√°√°√", 4), "°…°√");
  EXPECT_LE(length(shortened(std::string(100, 'x'), 40)), 40U);
}

// --- Numbers in words -----------------------------------------------------------------------------------------------

TEST(Text, DurationsAreInTheUnitThatSuitsThem) {
  EXPECT_EQ(duration_text(90), "90 s");
  EXPECT_EQ(duration_text(90.25), "90.25 s");
  EXPECT_EQ(duration_text(120), "2 min");
  EXPECT_EQ(duration_text(2700), "45 min");
  EXPECT_EQ(duration_text(5400), "90 min");
  EXPECT_EQ(duration_text(36'000), "10 h");
  EXPECT_EQ(duration_text(259'200), "3 days");
  EXPECT_EQ(duration_text(1'080'000), "12.5 days");
}

TEST(Text, DurationsOfAPlanAreInHours) {
  const auto text = [](double seconds) { return duration_text(seconds, DurationForm::planned); };
  EXPECT_EQ(text(119.9), "120 s");
  EXPECT_EQ(text(1800), "30 min");
  EXPECT_EQ(text(3600), "1 h");
  EXPECT_EQ(text(5400), "1.5 h");
  EXPECT_EQ(text(1'080'000), "300 h");
}

TEST(Text, RoughDurationsHaveNoMoreDigitsThanTheyDeserve) {
  const auto text = [](double seconds) { return duration_text(seconds, DurationForm::rough); };
  EXPECT_EQ(text(12.6), "13 s");
  EXPECT_EQ(text(2730), "46 min");
  EXPECT_EQ(text(36'000), "10.0 h");
  EXPECT_EQ(text(400'000), "111 h");
}

TEST(Text, ThousandsStandApart) {
  EXPECT_EQ(count_text(7), "7");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(count_text(-999), "-999");
  EXPECT_EQ(count_text(-1000), "-1 000");
  EXPECT_EQ(count_text(3'600'000), "3 600 000");
}

TEST(Text, ListsEndInAWord) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(listing(Words{}), "");
  EXPECT_EQ(listing(Words{"N"}), "N");
  EXPECT_EQ(listing(Words{"N", "B"}), "N and B");
  EXPECT_EQ(listing(Words{"N", "B", "K"}, "or"), "N, B or K");
}

TEST(Text, ShellWordsAreQuotedWhereAShellWouldReadSomethingIntoThem) {
  EXPECT_EQ(text::shell_word("a/b-1.csv"), "a/b-1.csv");
  EXPECT_EQ(text::shell_word("IMU[0]"), "'IMU[0]'");
  EXPECT_EQ(text::shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(text::shell_word(""), "''");
}

}  // namespace
}  // namespace gyrobudget::text
