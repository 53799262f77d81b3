// SPDX-License-Identifier: MIT
// Clocks of every kind: dates, times of day, counters, coarse and jittering stamps; two sensors in one log, and one
// recording in two.
#include "gyrobudget/app/log/calendar.h"
#include "gyrobudget/app/log/log.h"

#include <cmath>
#include <numbers>

#include "text_writer.h"

namespace gyrobudget::app_tests {
namespace {

using allan::Record;
using log::LogOptions;
using log::StampForm;
using text::InputError;

constexpr double kDegree = std::numbers::pi / 180;

using Clock = TextLog;

/// Every axis holds its readings at the grid points of their rows, and nothing where rows are lost.
void expect_rows(const Record& record, double unit, const std::function<bool(int)>& is_lost = {}) {
  for (std::size_t axis = 0; axis < record.axes.size(); ++axis) {
    for (std::size_t i = 0; i < record.axes[axis].rate.size(); ++i) {
      const int row = static_cast<int>(i);
      if (is_lost && is_lost(row))
        ASSERT_TRUE(std::isnan(record.axes[axis].rate[i])) << i;
      else
        ASSERT_DOUBLE_EQ(record.axes[axis].rate[i], reading(row, static_cast<int>(axis)) * unit) << axis << ' ' << i;
    }
  }
}

std::string printed(const char* format, auto... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// hh:mm:ss.mmm of a number of milliseconds since a midnight.
std::string time_of_day(long ms) {
  ms %= 86'400'000;
  return printed("%02ld:%02ld:%02ld.%03ld", ms / 3'600'000, ms / 60'000 % 60, ms / 1000 % 60, ms % 1000);
}

const std::string kAxes = "gx (deg/s),gy (deg/s),gz (deg/s)\n";
const auto kFewLost = [](int row) { return row == 17 || (row >= 30 && row < 33); };

// --- Cells ----------------------------------------------------------------------------------------------------------

std::int64_t stamp(std::string_view cell, StampForm form) {
  EXPECT_EQ(log::calendar_form(cell), form) << cell;
  std::int64_t ns = 0;
  EXPECT_EQ(log::parse_calendar(cell, form, ns), text::Cell::number) << cell;
  return ns;
}

TEST(Calendar, DatesAndTimesAreNanosecondsSince1970) {
  // date -u -d ... +%s of coreutils
  constexpr std::int64_t kSecond = 1'000'000'000, kMarch = 1709629801 * kSecond;
  for (const char* cell :
       {"2024-03-05T09:10:01Z", "2024-03-05 09:10:01", "2024/03/05 09:10:01", "2024-03-05T10:10:01+01:00",
        "2024-03-05T05:40:01-0330", "20240305T091001", "2024-03-05T09.10.01", "5.3.2024 09:10:01",
        "05-Mar-2024 09:10:01", "2024-03-05 9:10:01 AM", "\"2024-03-05 09:10:01 UTC\"", "2024-03-05T09:10:01.000"}) {
    EXPECT_EQ(stamp(cell, StampForm::date_time), kMarch) << cell;
  }
  EXPECT_EQ(stamp("2024-03-05T09:10:01.1234567891", StampForm::date_time), kMarch + 123'456'789);
  EXPECT_EQ(stamp("2024-03-05 09:10:01,5", StampForm::date_time), kMarch + kSecond / 2);
  EXPECT_EQ(stamp("1969-12-31T23:59:59.5", StampForm::date_time), -kSecond / 2);
  EXPECT_EQ(stamp("2024-02-29", StampForm::date), 1709164800 * kSecond);
  EXPECT_EQ(stamp("23:59:60.5", StampForm::time_of_day), log::kDay + kSecond / 2);
  EXPECT_EQ(stamp("100:00:01", StampForm::time_of_day), 360'001 * kSecond);
  EXPECT_EQ(stamp("00:01.2", StampForm::time_of_day), 12 * kSecond / 10);
  EXPECT_EQ(stamp("1:02:03.25 PM", StampForm::time_of_day), (13 * 3600 + 123) * kSecond + kSecond / 4);
}

TEST(Calendar, WhatIsNoneOrNotSureIsText) {
  for (const char* cell :
       {"05/03/2024 09:10:01", "2024-13-05", "2023-02-29", "2024-03-05 25:00:00", "09:60:00", "12:30", "1.5", "-3",
        "2024", "20240305", "noon", "", "2024-03-05T09:10:01 CET", "1:2:3:4", "10:20:99"})
    EXPECT_EQ(log::calendar_form(cell), std::nullopt) << cell;
  std::int64_t ns = 0;
  EXPECT_EQ(log::parse_calendar("", StampForm::date_time, ns), text::Cell::missing);
  EXPECT_EQ(log::parse_calendar("2024-03-05", StampForm::date_time, ns), text::Cell::text);
  EXPECT_EQ(log::parse_calendar("1600-01-01T00:00:00", StampForm::date_time, ns), text::Cell::beyond);
  EXPECT_EQ(log::parse_calendar("9999-01-01T00:00:00", StampForm::date_time, ns), text::Cell::beyond);
}

// --- Dates and times of day ----------------------------------------------------------------------------------------

TEST_F(Clock, DatesShowGaps) {
  const auto clock = [](int i) { return "2024-12-31T" + time_of_day(86'399'000 + 10 * i); };
  const auto over_new_year = [&](int i) { return i < 100 ? clock(i) : "2025-01-01T" + time_of_day(10 * (i - 100)); };
  const Record r = read("when," + kAxes + SensorRows{.rows = 200, .clock = over_new_year, .is_lost = kFewLost}.text());
  EXPECT_NEAR(r.rate_hz, 100, 1e-9);
  EXPECT_EQ(r.samples, 200);
  EXPECT_EQ(r.missing_samples, 4);
  expect_rows(r, kDegree, kFewLost);
}

TEST_F(Clock, TimesOfDayRunOnOverMidnight) {
  const auto clock = [](int i) { return time_of_day(86'399'000 + 20L * i); };
  const std::string rows = SensorRows{.rows = 200, .clock = clock, .is_lost = kFewLost}.text();
  for (const std::string name : {"time", "clock", "UTC"}) {
    const Record r = read(name + "," + kAxes + rows);
    EXPECT_NEAR(r.rate_hz, 50, 1e-9);
    EXPECT_EQ(r.samples, 200);
    expect_rows(r, kDegree, kFewLost);
    EXPECT_CONTAINS(notes_of(r), "starts again at midnight, 1 time: it is counted on");
  }
  // A recording that stood still around midnight.
  const auto night = [](int i) { return i > 60 && i < 5000; };
  const Record slept = read("time," + kAxes + SensorRows{.rows = 10'000, .clock = clock, .is_lost = night}.text());
  EXPECT_EQ(slept.samples, 10'000);
  expect_rows(slept, kDegree, night);
}

TEST_F(Clock, DateAndTimeOfDayInTwoColumns) {
  const auto text = [](const std::string& delimiter, bool digits) {
    return SensorRows{
        .rows = 200,
        .delimiter = delimiter,
        .clock =
            [=](int i) {
              const bool next = i >= 100;
              return std::string(digits ? (next ? "20240306" : "20240305") : (next ? "2024-03-06" : "2024-03-05")) +
                     delimiter + time_of_day(86'399'000 + 10L * i);
            }}
        .text();
  };
  for (const std::string& all : {"date,time," + kAxes + text(",", false), "Date,UTC," + kAxes + text(",", true)}) {
    const Record r = read(all);
    EXPECT_EQ(r.samples, 200);
    EXPECT_NEAR(r.rate_hz, 100, 1e-9);
    EXPECT_CONTAINS(notes_of(r), "on the day of column");
    expect_rows(r, kDegree);
  }
  const Record blanks = read(text(" ", false), {.unit = "deg/s"});
  ASSERT_EQ(blanks.axes.size(), 3U);
  expect_rows(blanks, kDegree);
}

TEST_F(Clock, HourMinuteAndSecondInThreeColumns) {
  const auto clock = [](int i) {
    const long ms = 86'399'000 + 10L * i;
    return printed("%ld,%ld,%ld,%ld", ms / 3'600'000 % 24, ms / 60'000 % 60, ms / 1000 % 60, ms % 1000 * 1'000'000);
  };
  const Record r = read("UTC_Hour,UTC_Minute,UTC_Second,UTC_Nano," + kAxes +
                        SensorRows{.rows = 200, .clock = clock, .is_lost = kFewLost}.text());
  EXPECT_EQ(r.samples, 200);
  EXPECT_NEAR(r.rate_hz, 100, 1e-9);
  expect_rows(r, kDegree, kFewLost);
}

TEST_F(Clock, WeekAndSecondsOfIt) {
  const auto in_two = [](int i) {
    const double sow = 604'799 + 0.01 * i;
    return sow < 604'800 ? printed("2290,%.2f", sow) : printed("2291,%.2f", sow - 604'800);
  };
  const std::string rows = SensorRows{.rows = 200, .clock = in_two, .is_lost = kFewLost}.text();
  const std::string swapped = SensorRows{.rows = 200,
                                         .clock =
                                             [&](int i) {
                                               const std::string both = in_two(i);
                                               return both.substr(5) + "," + both.substr(0, 4);
                                             },
                                         .is_lost = kFewLost}
                                  .text();
  const Record r = read("GPS week,sow (s)," + kAxes + rows);
  EXPECT_EQ(r.samples, 200);
  expect_rows(r, kDegree, kFewLost);
  EXPECT_CONTAINS(notes_of(r), "in the week of column 'GPS week', without leap seconds");
  const Record asked = read("a,week," + kAxes + swapped, {.time = log::TimeOf{"week+a", "gps"}});
  EXPECT_EQ(asked.samples, 200);
  expect_rows(asked, kDegree, kFewLost);
  // Without the week the seconds start again.
  const auto alone = [](int i) { return printed("%.2f", std::fmod(604'799 + 0.01 * i, 604'800)); };
  const Record wrapped = read("tow (s)," + kAxes + SensorRows{.rows = 200, .clock = alone}.text());
  EXPECT_EQ(wrapped.samples, 200);
  EXPECT_CONTAINS(notes_of(wrapped), "starts again at the end of the week");
}

// --- Counters -------------------------------------------------------------------------------------------------------

TEST_F(Clock, ACounterShowsLostSamplesAndStartsAgain) {
  for (const int bits : {7, 8, 16, 24, 32}) {
    const std::int64_t most = std::int64_t{1} << bits;
    const auto clock = [&](int i) { return std::to_string((most - 50 + i) % most); };
    const std::string rows = SensorRows{.rows = 120, .clock = clock, .is_lost = kFewLost}.text();
    const Record r = read("count," + kAxes + rows, {.rate_hz = 151.5});
    EXPECT_EQ(r.rate_hz, 151.5);
    EXPECT_EQ(r.samples, 120);
    EXPECT_EQ(r.missing_samples, 4);
    expect_rows(r, kDegree, kFewLost);
    EXPECT_CONTAINS(notes_of(r), "starts again at " + std::to_string(most));
    EXPECT_CONTAINS(notes_of(r), "column 'count' counts the samples, at --rate 151.5 Hz");
    const Record headerless = read(rows, {.rate_hz = 151.5, .unit = "deg/s"});
    ASSERT_EQ(headerless.axes.size(), 3U) << bits;
    expect_rows(headerless, kDegree, kFewLost);
  }
}

TEST_F(Clock, ACounterMayGoByMoreThanOne) {
  const Record r = read("SampleTimeFine," + kAxes +
                            SensorRows{.rows = 120,
                                       .clock = [](int i) { return std::to_string((65'500 + i) % 65'536 * 100); },
                                       .is_lost = kFewLost}
                                .text(),
                        {.rate_hz = 100});
  EXPECT_EQ(r.samples, 120);
  expect_rows(r, kDegree, kFewLost);
}

TEST_F(Clock, ACounterOfSomethingElseIsNotUsedUnlessAskedFor) {
  const std::string text =
      "count," + kAxes +
      SensorRows{.rows = 400, .clock = [](int i) { return std::to_string(i < 300 ? i : i - 300); }}.text();
  const Record r = read(text, {.rate_hz = 100});
  EXPECT_EQ(r.samples, 400);
  expect_rows(r, kDegree);
  EXPECT_CONTAINS(notes_of(r), "column 'count' goes back (line 302) and is not taken for a count of samples");
  EXPECT_CONTAINS(refusal(text, {.rate_hz = 100, .time = log::TimeOf{"count", "counter"}}),
                  ":302:1: column 'count' goes back, expected a count of samples; correct --time");
}

// --- Found, or asked for ---------------------------------------------------------------------------------------------

/// A loop whose turns last 6 or 9 ms, with a stretch of 4 s left out.
std::string loop_time(int i) {
  static const std::vector<long> kStamps = [] {
    std::vector<long> stamps{52'000};
    std::uint32_t state = 7;
    for (int k = 1; k < 6000; ++k) {
      state = state * 1664525 + 1013904223;
      stamps.push_back(stamps.back() + ((state >> 8) % 5 == 0 ? 9 : 6));
    }
    return stamps;
  }();
  return std::to_string(kStamps[static_cast<std::size_t>(i)]);
}

TEST_F(Clock, AJitteringClockIsFoundInAnyColumn) {
  const auto gap = [](int i) { return i >= 3000 && i < 3600; };
  const SensorRows first{.rows = 6000, .delimiter = " ", .clock = loop_time, .is_lost = gap};
  SensorRows last = first;
  last.clock_last = true;
  SensorRows middle = first;
  middle.clock = [](int i) { return number_text(reading(i, 5)) + " " + loop_time(i); };
  for (const SensorRows& rows : {first, last, middle}) {
    const Record r = read(rows.text(), {.rate_hz = 151.5, .unit = "deg/s"});
    EXPECT_EQ(r.axes.size(), rows.axes + (rows.clock(0).find(' ') == std::string::npos ? 0U : 1U));
    EXPECT_NEAR(r.missing_samples, 600, 12);  // the stretch lasts as long as its turns do, to 2 %
    EXPECT_NEAR(r.rate_hz, 151.5, 1.5);
    EXPECT_CONTAINS(notes_of(r), "agrees with --rate in ms: it is read as time");
  }
  // Beside columns that are asked for it is found too; without a rate it is asked for.
  EXPECT_NEAR(read(last.text(), {.rate_hz = 151.5, .unit = "deg/s", .columns = {"1", "2"}}).missing_samples, 600, 12);
  EXPECT_CONTAINS(refusal(last.text(), {.unit = "deg/s"}), "or give --rate HZ or --time 4=ms");
  EXPECT_NEAR(read(last.text(), {.unit = "deg/s", .time = log::TimeOf{"4", "ms"}}).missing_samples, 600, 12);
}

TEST_F(Clock, WhatLooksLikeAClockIsNoSensor) {
  const auto clock = [](int i) { return std::to_string(1000 + 7 * i); };
  const std::string rows = SensorRows{.clock = clock, .clock_last = true}.text();
  const LogOptions options{.rate_hz = 100, .unit = "deg/s"};
  LogOptions asked = options;
  asked.columns = {"4"};
  EXPECT_CONTAINS(refusal(rows, asked), "column 4: rises like a time or a counter; tell what the time is with --time");
  asked.time = log::TimeOf{"none"};
  EXPECT_EQ(read(rows, asked).axes.size(), 1U);
  // A second clock beside the first.
  const auto two = [](int i) { return printed("%.2f,%d", 0.01 * i, 900 + 7 * i); };
  const Record r = read("time (s),ticker,gx,gy,gz\n" + SensorRows{.clock = two}.text(), {.unit = "deg/s"});
  EXPECT_EQ(r.axes.size(), 3U);
  EXPECT_CONTAINS(notes_of(r), "left out 'ticker' (rises like a time or a counter)");
}

TEST_F(Clock, AskedForByNameAndUnit) {
  const auto ms = [](int i) { return std::to_string(1000 + 10 * i); };
  const std::string text = "a,gx,gy,gz\n" + SensorRows{.clock = ms}.text();
  for (const auto& [unit, rate] : {std::pair{"s", 0.1}, {"ms", 100.}, {"us", 1e5}, {"ns", 1e8}, {"gps", 0.1}})
    EXPECT_DOUBLE_EQ(read(text, {.unit = "deg/s", .time = log::TimeOf{"a", unit}}).rate_hz, rate) << unit;
  EXPECT_CONTAINS(refusal(text, {.unit = "deg/s", .time = log::TimeOf{"b", "ms"}}), "has no column 'b'");
  EXPECT_CONTAINS(refusal(text, {.unit = "deg/s", .time = log::TimeOf{"a", "iso"}}),
                  ":2:1: found '1000' in column 'a', expected dates or times of day");
  EXPECT_CONTAINS(refusal(text, {.unit = "deg/s", .columns = {"a"}, .time = log::TimeOf{"a", "ms"}}),
                  "is asked for as time and as data");
  // A named time that is none, left out.
  const Record none = read("time (s),gx (deg/s)\n" + SensorRows{.axes = 1, .clock = [](int) { return "5"; }}.text(),
                           {.rate_hz = 10, .time = log::TimeOf{"none"}});
  EXPECT_EQ(none.rate_hz, 10);
  EXPECT_EQ(none.samples, 40);
}

// --- Coarse stamps ---------------------------------------------------------------------------------------------------

TEST_F(Clock, StampsThatRepeatAreCountedThroughAtAGivenRate) {
  const auto seconds = [](int i) { return std::to_string(1'700'000'000 + (i + 3) / 5); };
  const auto gap = [](int i) { return i >= 502 && i < 602; };
  const std::string text = "time (s)," + kAxes + SensorRows{.rows = 2000, .clock = seconds, .is_lost = gap}.text();
  const Record r = read(text, {.rate_hz = 5});
  EXPECT_EQ(r.samples, 2000);
  EXPECT_EQ(r.missing_samples, 100);
  EXPECT_NEAR(r.rate_hz, 5, 0.01);
  EXPECT_CONTAINS(notes_of(r), "goes in steps of 1 s: the rows between are counted through at --rate");
  expect_rows(r, kDegree, gap);
  EXPECT_CONTAINS(refusal(text), "repeats the stamp of the row before it");
  // Whole milliseconds at 1.6 kHz, without a unit in the header.
  const auto ms = [](int i) { return std::to_string(i * 5 / 8); };
  const Record fast = read("time," + kAxes + SensorRows{.rows = 4000, .clock = ms}.text(), {.rate_hz = 1600});
  EXPECT_EQ(fast.samples, 4000);
  EXPECT_EQ(fast.missing_samples, 0);
}

// --- Wrapping --------------------------------------------------------------------------------------------------------

TEST_F(Clock, MicrosecondsOf32BitsRunOn) {
  const auto us = [](int i) { return std::to_string((4'294'967'296 - 500'000 + 10'000L * i) % 4'294'967'296); };
  const Record r = read("TimeUS," + kAxes + SensorRows{.rows = 200, .clock = us, .is_lost = kFewLost}.text());
  EXPECT_EQ(r.samples, 200);
  expect_rows(r, kDegree, kFewLost);
  EXPECT_CONTAINS(notes_of(r), "starts again at 4294967296, 1 time");
  // A clock that was set back is another thing.
  const auto back = [](int i) { return std::to_string(1'000'000 + 10'000L * (i < 100 ? i : i - 60)); };
  EXPECT_CONTAINS(refusal("TimeUS," + kAxes + SensorRows{.rows = 200, .clock = back}.text()), ":102:1: ");
}

TEST_F(Clock, StampsCenturiesApartAreRefusedByLine) {
  for (const std::string far : {"9000000000000000000", "-9000000000000000000"}) {
    std::string text = "time (ns)," + kAxes;
    for (int i = 0; i < 40; ++i) text += (i < 30 ? std::to_string(i - 4'500'000'000'000'000'000) : far) + ",1,2,3\n";
    EXPECT_CONTAINS(refusal(text), ":32:1: ");
    EXPECT_CONTAINS(refusal(text, {.resample_hz = 1}), "log.csv");
    EXPECT_THROW((void)log::read_segments({.path = file("log.csv", text)}, 1e12), InputError);
  }
}

// --- Several sensors -------------------------------------------------------------------------------------------------

TEST_F(Clock, SensorsThatWroteByTurnsAreRefusedAndTold) {
  std::string text = "TimeUS,I,name,gx (deg/s)\n", pairs = "TimeUS,I,gx (deg/s)\n";
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 2; ++k) {
      text += printed("%d,%d,%s,%g\n", 40'000 * i + 10 * k, k, k == 0 ? "left" : "right", reading(i, k));
      pairs += printed("%d,%d,%g\n", 40'000 * i, k, reading(i, k));
    }
  }
  for (const std::string& log : {text, pairs}) {
    for (const auto& rate : {std::optional<double>{}, std::optional<double>{50}}) {
      const std::string found = refusal(log, {.rate_hz = rate});
      EXPECT_CONTAINS(found, ":1:8: 2 sensors wrote by turns: column 'I' is 0 or 1");
      EXPECT_CONTAINS(found, "choose one, as in --rows I=0");
    }
  }
  const Record right = read(text, {.rows = log::RowsOf{"name", 0, "right"}});
  EXPECT_EQ(right.samples, 200);
  EXPECT_DOUBLE_EQ(right.axes[0].rate[5], reading(5, 1) * kDegree);
  EXPECT_CONTAINS(notes_of(right), "200 of 400 rows are read: those with 'right' in column 'name'");
  EXPECT_CONTAINS(refusal(text, {.rows = log::RowsOf{"name", 0, "up"}}), ":2:1: no row has 'up' in column 'name'");
  EXPECT_EQ(read(text, {.rate_hz = 50, .time = log::TimeOf{"none"}}).samples, 400);
}

TEST_F(Clock, EmptyColumnsAreLeftOutByName) {
  const auto clock = [](int i) { return std::to_string(i) + ","; };
  const Record r = read("PacketCounter,SampleTimeFine,Gyr_X,Gyr_Y,Gyr_Z\n" + SensorRows{.clock = clock}.text(),
                        {.rate_hz = 100, .unit = "rad/s"});
  EXPECT_EQ(r.axes.size(), 3U);
  EXPECT_CONTAINS(notes_of(r), "left out 'SampleTimeFine' (empty)");
  expect_rows(r, 1);
  const Record dead = read("gx (rad/s),gy (rad/s)\n1,\n2,\n1,\n", {.rate_hz = 1});
  EXPECT_EQ(dead.axes.size(), 1U);
  EXPECT_CONTAINS(notes_of(dead), "left out 'gy' (empty)");
}

// --- Two files -------------------------------------------------------------------------------------------------------

TEST_F(Clock, TwoLogsOfOneRecordingAreJoined) {
  const auto ms = [](int offset, int step) { return [=](int i) { return std::to_string(offset + step * i); }; };
  const std::string gyro =
      file("Gyroscope.csv", "time (ms),x (deg/s)\n" + SensorRows{.rows = 400, .axes = 1, .clock = ms(1000, 10)}.text());
  const std::string same = file(
      "Accelerometer.csv", "time (ms),x (m/s^2)\n" + SensorRows{.rows = 400, .axes = 1, .clock = ms(1003, 10)}.text());
  const std::string slow =
      file("Slow.csv", "time (ms),x (m/s^2)\n" + SensorRows{.rows = 200, .axes = 1, .clock = ms(1000, 20)}.text());
  const std::string later =
      file("Later.csv", "time (ms),x (m/s^2)\n" + SensorRows{.axes = 1, .clock = ms(9000, 10)}.text());
  const std::string bare =
      file("Bare.csv", "time (ms),x\n" + SensorRows{.rows = 400, .axes = 1, .clock = ms(1003, 10)}.text());

  const Record r = log::read_log({.path = gyro, .with = {{same}}});
  ASSERT_EQ(r.axes.size(), 2U);
  EXPECT_EQ(r.missing_samples, 0);
  EXPECT_EQ(r.axes[1].name, "x of Accelerometer");
  EXPECT_DOUBLE_EQ(r.axes[0].rate[7], reading(7, 0) * kDegree);
  EXPECT_DOUBLE_EQ(r.axes[1].rate[7], reading(7, 0));
  EXPECT_CONTAINS(notes_of(r), "is joined by time: its stamps are 3 ms behind those of " + gyro);

  for (const auto& [base, with] : {std::pair{gyro, slow}, std::pair{slow, gyro}}) {
    const Record sparse = log::read_log({.path = base, .with = {{with}}});
    EXPECT_EQ(sparse.samples, 400);
    EXPECT_EQ(sparse.missing_samples, 200);
    EXPECT_DOUBLE_EQ(sparse.axes[0].rate[9], reading(9, 0) * kDegree);
    EXPECT_DOUBLE_EQ(sparse.axes[1].rate[8], reading(4, 0));
    EXPECT_TRUE(std::isnan(sparse.axes[1].rate[9]));
  }
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log({.path = gyro, .with = {{later}}}); }),
                  "do not overlap, 4.01 s lie between them");
  EXPECT_CONTAINS(
      message_of<InputError>([&] { (void)log::read_log({.path = gyro, .unit = "deg/s", .with = {{bare}}}); }),
      "Bare.csv:1:11: column 'x' has no unit");
  EXPECT_EQ(log::read_log({.path = gyro, .with = {{bare, "m/s^2"}}}).axes[1].signal, noise::Signal::specific_force);
}

// --- Dialects --------------------------------------------------------------------------------------------------------

TEST_F(Clock, HeadersOfKnownProgramsTellUnitsAndClock) {
  const auto us = [](int i) { return std::to_string(112'345'678 + 4000 * i); };
  const Record px4 = read("timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],accelerometer_m_s2[0]\n" +
                          SensorRows{.axes = 4, .clock = us}.text());
  ASSERT_EQ(px4.axes.size(), 4U);
  EXPECT_DOUBLE_EQ(px4.rate_hz, 250);
  EXPECT_EQ(px4.axes[3].signal, noise::Signal::specific_force);
  EXPECT_CONTAINS(notes_of(px4), "by its header this is PX4 sensor_combined");
  expect_rows(px4, 1);

  const auto ticks = [](int i) { return std::to_string(2 * i); };
  const Record flow = read("GYROFLOW IMU LOG\nversion,1.3\ntscale,0.001\ngscale,0.5\nascale,0.25\nt,gx,gy,gz,ax\n" +
                           SensorRows{.axes = 4, .clock = ticks}.text());
  ASSERT_EQ(flow.axes.size(), 4U);
  EXPECT_DOUBLE_EQ(flow.rate_hz, 500);
  EXPECT_DOUBLE_EQ(flow.axes[2].rate[5], 0.5 * reading(5, 2));
  EXPECT_DOUBLE_EQ(flow.axes[3].rate[5], 0.25 * 9.80665 * reading(5, 3));
  EXPECT_DOUBLE_EQ(read("GYROFLOW IMU LOG\ntscale,0.001\ngscale,0.5\nt,gx,gy,gz\n" + SensorRows{.clock = ticks}.text(),
                        {.unit = "rad/s"})
                       .axes[2]
                       .rate[5],
                   0.5 * reading(5, 2))
      << "the file's own scale holds";
  EXPECT_CONTAINS(refusal("GYROFLOW IMU LOG\nversion,1.3\nt,gx,gy,gz\n" + SensorRows{.clock = ticks}.text()),
                  "has no unit")
      << "without scales nothing is known";

  const auto ns = [](int i) {
    return printed("%ld,%.7f", 1'709'629'801'123'456'789 + 10'000'000L * i, 0.0123456 + 0.01 * i);
  };
  const Record phone = read("time,seconds_elapsed,z,y,x\n" + SensorRows{.clock = ns}.text(), {.unit = "rad/s"});
  ASSERT_EQ(phone.axes.size(), 3U);
  EXPECT_NEAR(phone.rate_hz, 100, 1e-9);
  EXPECT_EQ(phone.axes[0].name, "z");

  std::string vn;
  for (int i = 0; i < 40; ++i)
    vn +=
        printed("$VNIMU,-00.2031,+00.1187,+00.4410,%+.3f,%+.3f,-09.797,%+.5f,-000.00342,+000.00087,+31.4,+098.712*60\n",
                reading(i, 0), reading(i, 1), reading(i, 2));
  const Record vector_nav = read(vn, {.rate_hz = 40});
  ASSERT_EQ(vector_nav.axes.size(), 6U);
  EXPECT_DOUBLE_EQ(vector_nav.axes[0].rate[3], reading(3, 0));
  EXPECT_DOUBLE_EQ(vector_nav.axes[3].rate[3], reading(3, 2));
  EXPECT_EQ(vector_nav.axes[3].name, "GyrX");
  EXPECT_DOUBLE_EQ(vector_nav.temperature.at(0), 31.4);
}

TEST_F(Clock, ForeignTextsAreNamedWithWhatToDo) {
  EXPECT_CONTAINS(
      refusal("%RAWIMUSA,2290,315604.015;2290,315604.014886,00010077,328911,-1204,30177,-455,1190,-7221*b3494bf9\n"),
      ":1:1: found NovAtel's RAWIMUS");
  EXPECT_CONTAINS(refusal("{\"ts\":1709629801123,\"gx\":0.11}\n{\"ts\":1709629801133,\"gx\":0.12}\n"),
                  ":1:1: found JSON");
}

}  // namespace
}  // namespace gyrobudget::app_tests
