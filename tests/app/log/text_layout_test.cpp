// SPDX-License-Identifier: MIT
// What stands above the rows of a text: preambles, separators, cut rows, prose, and names with an index.
#include "gyrobudget/app/log/layout.h"
#include "gyrobudget/app/log/log.h"

#include <cmath>
#include <numbers>

#include "text_writer.h"

namespace gyrobudget::app_tests {
namespace {

using allan::Record;
using log::LogOptions;
using text::InputError;

constexpr double kDegree = std::numbers::pi / 180;

using TextLayout = TextLog;

/// All axes hold the readings of the writer, times `unit`, from row `first` on.
void expect_readings(const Record& record, double unit, int first = 0) {
  for (std::size_t axis = 0; axis < record.axes.size(); ++axis) {
    const auto& rates = record.axes[axis].rate;
    for (std::size_t i = 0; i < rates.size(); ++i)
      ASSERT_DOUBLE_EQ(rates[i], reading(first + static_cast<int>(i), static_cast<int>(axis)) * unit)
          << axis << ' ' << i;
  }
}

const auto kMilliseconds = [](int i) { return std::to_string(5000 + 10 * i); };

TEST_F(TextLayout, APreambleIsSkippedAndTheHeaderNamed) {
  const std::string rows = SensorRows{.clock = kMilliseconds}.text();
  const std::string header = "time (ms),gx (deg/s),gy (deg/s),gz (deg/s)\n";
  for (const std::string preamble :
       {"Sensor: LSM6DSO Gyroscope\nVendor: STM\n", "LOGGER 2000\nversion,1.3\nid,homemade\nstarted,2024-05-01\n",
        "one line of prose\n", "a,b\n\n# a comment\nnumber of rows,40\n", "40\n12\nrate;100\n"}) {
    const Record r = read(preamble + header + rows);
    ASSERT_EQ(r.axes.size(), 3U) << preamble;
    EXPECT_EQ(r.samples, 40);
    EXPECT_DOUBLE_EQ(r.rate_hz, 100);
    EXPECT_EQ(r.axes[0].name, "gx");
    expect_readings(r, kDegree);
    const auto line = 1 + std::ranges::count(preamble, '\n');
    EXPECT_CONTAINS(notes_of(r), "the header is line " + std::to_string(line));
    EXPECT_CONTAINS(notes_of(r), "from '" + preamble.substr(0, preamble.find('\n')).substr(0, 20));
  }
}

TEST_F(TextLayout, APreambleOverBlanksOfAsManyWords) {
  const Record r =
      read("Sensor: gyro one two\nt_ms gx gy gz\n" + SensorRows{.delimiter = " ", .clock = kMilliseconds}.text(),
           {.unit = "deg/s"});
  ASSERT_EQ(r.axes.size(), 3U);
  expect_readings(r, kDegree);
}

TEST_F(TextLayout, APreambleOverNamesAndUnits) {
  const Record r = read("export of 2024\nuser,me\ntime,gx,gy,gz\nms,deg/s,deg/s,deg/s\n" +
                        SensorRows{.clock = kMilliseconds}.text());
  ASSERT_EQ(r.axes.size(), 3U);
  EXPECT_CONTAINS(notes_of(r), "the header is line 3; 2 lines above it are left out, from 'export of 2024' on");
  expect_readings(r, kDegree);
}

TEST_F(TextLayout, APreambleWithoutAHeader) {
  const Record r = read("recorded by night\n" + SensorRows{}.text(), {.rate_hz = 100, .unit = "rad/s"});
  EXPECT_CONTAINS(notes_of(r), "there is no header, and the first row is line 2");
  expect_readings(r, 1);
}

TEST_F(TextLayout, RowsMayEndInADelimiterThatTheNamesLack) {
  std::string rows;
  for (int i = 0; i < 40; ++i) rows += kMilliseconds(i) + ";" + number_text(reading(i, 0)) + ";\n";
  const Record r = read("Vendor: x\nstamp [ms]; gx [deg/s]\n" + rows);
  ASSERT_EQ(r.axes.size(), 1U);
  expect_readings(r, kDegree);
}

TEST_F(TextLayout, TheLineOfASpreadsheetTellsTheDelimiter) {
  const std::string names = "time (s)|gx (deg/s)|gy (deg/s)|gz (deg/s)\n";
  for (const auto& [line, delimiter] : {std::pair<std::string, std::string>{"sep=;", ";"},
                                        {"\"sep=\t\"", "\t"},
                                        {"sep=,\r", ","},
                                        {"\xef\xbb\xbfsep=;", ";"}}) {
    std::string header = names;
    for (std::size_t at; (at = header.find('|')) != std::string::npos;) header.replace(at, 1, delimiter);
    const Record r =
        read(line + "\n" + header +
             SensorRows{.delimiter = delimiter, .clock = [](int i) { return number_text(i * 0.5); }}.text());
    ASSERT_EQ(r.axes.size(), 3U) << line;
    EXPECT_EQ(r.rate_hz, 2);
    EXPECT_CONTAINS(notes_of(r), "the header is line 2");
    expect_readings(r, kDegree);
  }
  // A told comma is a delimiter, which nobody could know otherwise.
  const Record told = read("sep=,\n0,125\n0,031\n0,250\n0,062\n", {.rate_hz = 1, .unit = "1"});
  EXPECT_EQ(told.axes.size(), 2U);
}

TEST_F(TextLayout, AFirstRowThatWasCutIsLeftOutAndSaid) {
  std::string text = SensorRows{}.text();
  text = text.substr(text.find(',') + 1);
  const Record r = read(text, {.rate_hz = 100, .unit = "rad/s"});
  ASSERT_EQ(r.axes.size(), 3U);
  EXPECT_EQ(r.samples, 39);
  EXPECT_CONTAINS(notes_of(r), "line 1 ('" + text.substr(0, text.find('\n')) + "') is the end of a row and left out");
  expect_readings(r, 1, 1);
}

TEST_F(TextLayout, ShortRowsElsewhereAndNamesOfAnotherNumberStayFaults) {
  const LogOptions options = {.rate_hz = 1, .unit = "1"};
  EXPECT_CONTAINS(refusal("1,2,3\n4,5\n" + SensorRows{}.text(), options), ":2:4: found 2 cells, expected 3");
  EXPECT_CONTAINS(refusal("1,2,3,4\n" + SensorRows{}.text(), options), ":2:");
  EXPECT_CONTAINS(refusal("a,b\n" + SensorRows{}.text(), options), ":2:1: found 3 cells under a header of 2 names");
  EXPECT_CONTAINS(refusal("a,b,c,d\n" + SensorRows{}.text(), options), ":2:1: found 3 cells under a header of 4 names");
}

TEST_F(TextLayout, ProseIsNoHeaderAndGivesNoUnit) {
  const std::string one = SensorRows{.axes = 1}.text(), two = SensorRows{.axes = 2}.text();
  const LogOptions options = {.rate_hz = 100, .unit = "rad/s"};
  for (const std::string comment : {"# recorded by me\n# bias removed (deg/s)\n", "# gyro bias removed (deg/s)\n",
                                    "% all in (deg/s)\n", "// range: 250 (deg/s)\n"}) {
    expect_readings(read(comment + one, options), 1);
    EXPECT_CONTAINS(refusal(comment + one, {.rate_hz = 100}), "has no unit") << comment;
  }
  expect_readings(read("# Time: 2025-02-11 (s), Device: A1B2 (deg/s)\n" + two, options), 1);
  expect_readings(read("# this is the first of all (deg/s), this the second (deg/s)\n" + two, options), 1);
  for (const std::string name : {"# gyro_x (deg/s)\n", "# gyro x (deg/s)\n", "#w (deg/s)\n"})
    expect_readings(read(name + one, {.rate_hz = 100}), kDegree);
}

TEST_F(TextLayout, AnIntegerInBracketsBelongsToTheName) {
  const auto names = [&](const std::string& header) {
    const Record r = read(header + "\n" + SensorRows{}.text(), {.rate_hz = 100, .unit = "rad/s"});
    std::string all;
    for (const allan::Axis& axis : r.axes) all += axis.name + "|";
    expect_readings(r, 1);
    return all;
  };
  EXPECT_EQ(names("gyro_rad[0],gyro_rad[1],gyro_rad[2]"), "gyro_rad[0]|gyro_rad[1]|gyro_rad[2]|");
  EXPECT_EQ(names("gyro(1),gyro(2),gyro(3)"), "gyro[1]|gyro[2]|gyro[3]|");
  EXPECT_EQ(names("w[1],w [2],w[10]"), "w[1]|w[2]|w[10]|");
  const Record chosen = read("gyro_rad[0],gyro_rad[1],gyro_rad[2]\n" + SensorRows{}.text(),
                             {.rate_hz = 100, .unit = "rad/s", .columns = {"gyro_rad[1]"}});
  ASSERT_EQ(chosen.axes.size(), 1U);
  EXPECT_DOUBLE_EQ(chosen.axes[0].rate[3], reading(3, 1));
  // The unit of a ratio stays one.
  const Record ratio = read("x (1),y [1],z (1)\n" + SensorRows{}.text(), {.rate_hz = 100});
  ASSERT_EQ(ratio.axes.size(), 3U);
  EXPECT_EQ(ratio.axes[0].name, "x");
}

TEST_F(TextLayout, CutAtEveryPerCentItIsReadOrRefused) {
  const std::string whole = "GYRO LOG\nid,me\nsep,x\ntime (ms),gx (deg/s),gy (deg/s),gz (deg/s)\n" +
                            SensorRows{.rows = 100, .clock = kMilliseconds}.text();
  int read_ones = 0;
  for (std::size_t percent = 1; percent <= 100; ++percent) {
    try {
      const Record r = read(whole.substr(0, whole.size() * percent / 100));
      ++read_ones;
      EXPECT_EQ(r.axes.size(), 3U);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find(path("log.csv")), 0U) << error.what();
    }
  }
  EXPECT_GT(read_ones, 20);
}

}  // namespace
}  // namespace gyrobudget::app_tests
