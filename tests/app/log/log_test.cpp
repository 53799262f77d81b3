// SPDX-License-Identifier: MIT
// Logs as people have them: every form that is read, and what comes out of it.
#include "gyrobudget/app/log/log.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>

#include "../packing.h"
#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using allan::Record;
using log::Input;
using log::LogOptions;
using noise::Signal;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGravity = 9.80665;
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

class Log : public TemporaryFolder {
 protected:
  [[nodiscard]] Record read(std::string_view text, LogOptions options = {}) const {
    options.path = file("log.csv", text);
    return log::read_log(options);
  }
};

void expect_values(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (std::isnan(expected[i])) {
      EXPECT_TRUE(std::isnan(found[i])) << i << ": " << found[i];
    } else {
      EXPECT_DOUBLE_EQ(found[i], expected[i]) << i;
    }
  }
}

void expect_note(const Record& record, const std::string& part) {
  std::string all;
  for (const std::string& note : record.notes) all += note + '\n';
  EXPECT_CONTAINS(all, part);
}

// --- Text ----------------------------------------------------------------------------------------------------------

TEST_F(Log, OneColumnOfPlainNumbers) {
  const Record r = read("1\n-2.5\n3e-1\n", {.rate_hz = 10, .unit = "rad/s"});
  ASSERT_EQ(r.axes.size(), 1U);
  EXPECT_EQ(r.axes[0].name, "column 1");
  EXPECT_EQ(r.axes[0].signal, Signal::angular_rate);
  EXPECT_EQ(r.rate_hz, 10);
  EXPECT_EQ(r.samples, 3);
  EXPECT_EQ(r.missing_samples, 0);
  expect_values(r.axes[0].rate, {1, -2.5, 0.3});
}

TEST_F(Log, EveryDelimiterGivesTheSame) {
  for (const std::string d : {",", ";", "\t", " ", ", ", " ; ", "   ", " \t ", ",\t", "  ,  "}) {
    const std::string text =
        "0" + d + "1.5" + d + "-2\n" + "0.1" + d + "2.5" + d + "-3\n" + "0.2" + d + "+3.5" + d + "-4e0\n";
    const Record r = read(text, {.rate_hz = 10, .unit = "1"});
    ASSERT_EQ(r.axes.size(), 2U) << "delimiter '" << d << "'";
    expect_values(r.axes[0].rate, {1.5, 2.5, 3.5});
    expect_values(r.axes[1].rate, {-2, -3, -4});
  }
}

TEST_F(Log, BlanksAroundRowsAndCellsDoNotCount) {
  const Record r = read("  1   2 \n\t3 4\t\n 5\t 6\n", {.rate_hz = 1, .unit = "1", .columns = {"1", "2"}});
  expect_values(r.axes[0].rate, {1, 3, 5});
  expect_values(r.axes[1].rate, {2, 4, 6});
}

TEST_F(Log, HeaderWithUnitsInBrackets) {
  const Record r = read("time (s),gyro_x (deg/s),acc_y [g],temp (°C)\n0,1,2,20\n0.5,3,4,21\n1,5,6,22\n");
  EXPECT_EQ(r.rate_hz, 2);
  ASSERT_EQ(r.axes.size(), 2U);
  EXPECT_EQ(r.axes[0].name, "gyro_x");
  EXPECT_EQ(r.axes[0].signal, Signal::angular_rate);
  expect_values(r.axes[0].rate, {1 * kDegree, 3 * kDegree, 5 * kDegree});
  EXPECT_EQ(r.axes[1].name, "acc_y");
  EXPECT_EQ(r.axes[1].signal, Signal::specific_force);
  expect_values(r.axes[1].rate, {2 * kGravity, 4 * kGravity, 6 * kGravity});
  expect_note(r, "column 'temp' is read as the temperature");
  expect_values(r.temperature, {20, 21, 22});
}

// Whatever it is called and whatever is asked for, it is no gyro.
TEST_F(Log, ATemperatureIsNeverData) {
  const std::string numbers = "\n0,1,20\n0.5,3,21\n1,5,22\n";
  for (const std::string name : {"T", "temp", "temperature_imu", "temp (K)", "x (deg C)", "imu_temp (°C)"}) {
    const Record r = read("time (s),gx," + name + numbers, {.unit = "deg/s"});
    ASSERT_EQ(r.axes.size(), 1U) << name;
    const double zero = name.ends_with("(K)") ? -273.15 : 0;
    expect_values(r.temperature, {20 + zero, 21 + zero, 22 + zero});
  }
  const Record chosen = read("time (s),gx,temp" + numbers, {.unit = "deg/s", .columns = {"gx", "temp"}});
  EXPECT_EQ(chosen.axes.size(), 1U);
  EXPECT_EQ(chosen.temperature.size(), 3U);
  EXPECT_EQ(read("time (s),gyro_x_tempcomp (deg/s)\n0,1\n0.5,3\n1,5\n").axes.size(), 1U) << "this is a gyro";
  // Counts of a register are no degrees.
  const Record counts = read("time (s),gx,temp\n0,1,-3200\n0.5,3,-3201\n1,5,-3203\n", {.unit = "deg/s"});
  EXPECT_EQ(counts.axes.size(), 1U);
  EXPECT_TRUE(counts.temperature.empty());
  EXPECT_THROW((void)read("time (s),gx,temp" + numbers, {.unit = "deg/s", .columns = {"temp"}}), text::InputError);
}

TEST_F(Log, ASlowTemperatureHasGapsAndAnglesLoseOne) {
  const Record r = read("time (s),angle (deg),T (degC)\n0,1,20\n0.5,3,\n1,5,22\n", {.input = Input::angle});
  expect_values(r.temperature, {20, kMissing});
  EXPECT_EQ(r.missing_samples, 0);
}

TEST_F(Log, RowsOfOneSensorAreRead) {
  const std::string log = "time (s),id,gx (rad/s)\n0,0,1\n0.01,1,10\n1,0,2\n1.01,1,20\n2,0,3\n2.01,1,30\n";
  const Record first = read(log, {.rows = log::RowsOf{"id", 0}});
  EXPECT_EQ(first.rate_hz, 1);
  expect_values(first.axes[0].rate, {1, 2, 3});
  expect_note(first, "3 of 6 rows are read");
  expect_values(read(log, {.rows = log::RowsOf{"2", 1}}).axes[0].rate, {10, 20, 30});
  EXPECT_THROW((void)read(log, {.rows = log::RowsOf{"id", 7}}), text::InputError);
  EXPECT_THROW((void)read(log, {.rows = log::RowsOf{"unit", 0}}), text::InputError);
  EXPECT_THROW((void)read(log, {.rows = log::RowsOf{"time", 0}}), text::InputError);
}

TEST_F(Log, EurocHeaderIsACommentAndStampsKeepAllDigits) {
  const Record r = read(
      "#timestamp [ns],w_RS_S_x [rad s^-1],a_RS_S_x [m s^-2]\n1403636579758555392,-0.1,8.1\n"
      "1403636579763555584,-0.2,8.2\n1403636579768555392,-0.3,8.3\n");
  EXPECT_NEAR(r.rate_hz, 200, 1e-9);  // steps of 5000192 and 4999808 ns: double would lose 256 ns each
  ASSERT_EQ(r.axes.size(), 2U);
  EXPECT_EQ(r.axes[0].name, "w_RS_S_x");
  EXPECT_EQ(r.axes[1].signal, Signal::specific_force);
  expect_values(r.axes[0].rate, {-0.1, -0.2, -0.3});
}

TEST_F(Log, HeadersOfManyKinds) {
  const std::string rows = "0,1\n0.1,2\n0.2,3\n";
  for (const std::string header :
       {"t (s),gyro x (deg/s)", "Time [sec],gyro x_[deg/s]", "\"time (s)\",\"gyro x (°/s)\"", "# time (s),gyro x (dps)",
        "% t_s , gyro x (deg s-1)", "// Time (s) , gyro x (deg/sec)", "time,gyro x\n(s),(deg/s)", "t,gyro x\ns,deg/s",
        "time (s),gyro x (\xb0/s)", "time (s),gyro x (deg/s),"}) {
    const Record r = read(header + "\n" + rows);
    ASSERT_EQ(r.axes.size(), 1U) << header;
    EXPECT_EQ(r.axes[0].name, "gyro x") << header;
    EXPECT_EQ(r.rate_hz, 10) << header;
    expect_values(r.axes[0].rate, {1 * kDegree, 2 * kDegree, 3 * kDegree});
  }
}

TEST_F(Log, HeaderAmongBlanksKeepsUnitsWithTheirNames) {
  const Record r = read("  time (s)   gyro_x (rad s^-1) acc_x [m/s^2]\n0 1 2\n0.1 3 4\n0.2 5 6\n");
  ASSERT_EQ(r.axes.size(), 2U);
  EXPECT_EQ(r.axes[0].name, "gyro_x");
  expect_values(r.axes[1].rate, {2, 4, 6});
}

TEST_F(Log, ProseInCommentsIsNoHeader) {
  const Record r = read("# static test\n# three hours long, at night\n0 1 2 3 4\n0.1 1 2 3 4\n0.2 1 2 3 4\n",
                        {.rate_hz = 10, .unit = "rad/s"});
  ASSERT_EQ(r.axes.size(), 4U);
  EXPECT_EQ(r.axes[0].name, "column 2");
}

TEST_F(Log, CommentsAndBlankLinesAnywhere) {
  const Record r = read("\n# a\n\n1\n#b\n  % c\n// d\n2\n\n\t\n3\n\n\n", {.rate_hz = 1, .unit = "1"});
  expect_values(r.axes[0].rate, {1, 2, 3});
  expect_note(r, "2 blank lines among the rows are skipped");
}

TEST_F(Log, LineEndsMarksAndMissingNewline) {
  const std::vector<double> expected = {1, 2, 3};
  for (const std::string text : {"x (1),y (1)\r\n1,4\r\n2,5\r\n3,6\r\n", "\xef\xbb\xbfx (1),y (1)\n1,4\n2,5\n3,6",
                                 "x (1),y (1)\n1,4\n2,5\n3,6\r\n\r\n", "x (1),y (1),\n1,4,\n2,5,\n3,6,\n",
                                 "\"x (1)\",\"y (1)\"\n\"1\",\"4\"\n\"2\",\"5\"\n\"3\",\"6\"\n"}) {
    const Record r = read(text, {.rate_hz = 1});
    ASSERT_EQ(r.axes.size(), 2U) << text;
    expect_values(r.axes[0].rate, expected);
    expect_values(r.axes[1].rate, {4, 5, 6});
  }
}

TEST_F(Log, DecimalCommasWhereTheyAreNoDelimiters) {
  for (const std::string d : {";", "\t", "  "}) {
    const Record r = read("t (s)" + d + "w (rad/s)\n0" + d + "1,5\n0,1" + d + "-2,5e1\n0,2" + d + "3\n");
    EXPECT_EQ(r.rate_hz, 10);
    expect_values(r.axes[0].rate, {1.5, -25, 3});
    expect_note(r, "commas are read as decimal marks");
  }
}

TEST_F(Log, DecimalCommasWithoutAHeader) {
  const Record r = read("0,1;0,2\n-0,3;0,4\n0,5;1e-1\n", {.rate_hz = 100, .unit = "1"});
  ASSERT_EQ(r.axes.size(), 2U);
  expect_values(r.axes[0].rate, {0.1, -0.3, 0.5});
  expect_values(r.axes[1].rate, {0.2, 0.4, 0.1});
  expect_note(r, "commas are read as decimal marks");
}

TEST_F(Log, DecimalCommasUnderOneName) {
  const Record r = read("gyro_x (1)\n0,125\n-0,031\n0,25\n", {.rate_hz = 100});
  ASSERT_EQ(r.axes.size(), 1U);
  expect_values(r.axes[0].rate, {0.125, -0.031, 0.25});
  expect_note(r, "commas are read as decimal marks");
}

TEST_F(Log, MissingValuesOfEveryProgram) {
  const Record r = read(
      "w (rad/s),v (rad/s)\n1,1\nnan,1\nNaN,1\n-nan,1\n,1\n \t,1\ninf,1\n-Inf,1\nInfinity,1\nNA,1\nN/A,1\nnull,1\n"
      "None,1\n-,1\n\"\",1\n-nan(ind),1\n1.#QNAN,1\n-1.#IND,1\n2,1\n",
      {.rate_hz = 1});
  EXPECT_EQ(r.samples, 19);
  EXPECT_EQ(r.missing_samples, 17);
  EXPECT_EQ(r.axes[0].rate.front(), 1);
  EXPECT_EQ(r.axes[0].rate.back(), 2);
  for (std::size_t i = 1; i + 1 < 19; ++i) EXPECT_TRUE(std::isnan(r.axes[0].rate[i])) << i;
}

TEST_F(Log, AnyMissingAxisCountsThePointOnce) {
  const Record r = read("a (1),b (1)\n1,nan\nnan,nan\nnan,3\n4,4\n5,5\n", {.rate_hz = 1});
  EXPECT_EQ(r.missing_samples, 3);
}

TEST_F(Log, NumbersAreCorrectlyRounded) {
  const Record r = read("0.1\n1e308\n4.9e-324\n1e-400\n-1e-400\n9007199254740993\n123456789012345678901234567890\n",
                        {.rate_hz = 1, .unit = "1"});
  expect_values(r.axes[0].rate,
                {0.1, 1e308, 4.9e-324, 0.0, -0.0, 9007199254740992.0, 123456789012345678901234567890.0});
  EXPECT_TRUE(std::signbit(r.axes[0].rate[4]));
}

TEST_F(Log, Gzip) {
  const std::string text = "time (s),w (rad/s)\n0,1\n0.1,2\n0.2,3\n";
  const std::string half = text.substr(0, 20), rest = text.substr(20);
  for (const std::string& bytes : {gzip(text), gzip(half) + gzip(rest), gzip(text) + std::string(512, '\0')}) {
    const Record r = read(bytes);
    expect_values(r.axes[0].rate, {1, 2, 3});
    expect_note(r, "gzip was unpacked");
  }
}

TEST_F(Log, GzipLongerThanItsBlocks) {
  std::string text;  // compresses by far more than the size of a block of input
  for (int i = 0; i < 700'000; ++i) text += "1.25\n";
  const Record r = read(gzip(text), {.rate_hz = 1, .unit = "1"});
  EXPECT_EQ(r.samples, 700'000);
  EXPECT_EQ(r.missing_samples, 0);
}

TEST_F(Log, AFifoIsReadToItsEnd) {
  const std::string text = "1\n2\n3\n";
  const std::string pipe = path("pipe");
  ASSERT_EQ(std::system(("mkfifo " + pipe + " && (printf '1\\n2\\n3\\n' > " + pipe + " &)").c_str()), 0);
  const Record r = log::read_log({.path = pipe, .rate_hz = 1, .unit = "1"});
  expect_values(r.axes[0].rate, {1, 2, 3});
}

TEST_F(Log, StandardInput) {
  const std::string from = file("in.csv", "1\n2\n3\n");
  ASSERT_NE(std::freopen(from.c_str(), "r", stdin), nullptr);
  const Record r = log::read_log({.path = "-", .rate_hz = 1, .unit = "1"});
  EXPECT_EQ(r.source, "standard input");
  expect_values(r.axes[0].rate, {1, 2, 3});
}

// --- Columns and units ---------------------------------------------------------------------------------------------

TEST_F(Log, ColumnsByNameNumberAndList) {
  const std::string text = "t (s),x (rad/s),y (rad/s),Z (rad/s)\n0,1,2,3\n0.1,4,5,6\n0.2,7,8,9\n";
  const auto names = [&](std::vector<std::string> columns) {
    std::string result;
    for (const allan::Axis& axis : read(text, {.columns = std::move(columns)}).axes) result += axis.name;
    return result;
  };
  EXPECT_EQ(names({}), "xyZ");
  EXPECT_EQ(names({"y"}), "y");
  EXPECT_EQ(names({"3", "2"}), "yx");
  EXPECT_EQ(names({"z", "x (rad/s)"}), "Zx");
  EXPECT_EQ(names({"y,Z"}), "yZ");
  EXPECT_EQ(names({"x", "2", "x"}), "x");
}

TEST_F(Log, ColumnsOfOneNameDiffer) {
  const Record r = read("w (rad/s),w (rad/s)\n1,2\n3,4\n", {.rate_hz = 1});
  EXPECT_EQ(r.axes[0].name, "w");
  EXPECT_EQ(r.axes[1].name, "w (column 2)");
}

TEST_F(Log, TextInColumnsThatAreNotChosen) {
  const Record r = read("frame,seq,gyro_x (rad/s)\nimu,1,0.5\nimu link,2,0.25\nimu,3,0.125\n", {.rate_hz = 1});
  ASSERT_EQ(r.axes.size(), 1U);
  expect_values(r.axes[0].rate, {0.5, 0.25, 0.125});
  expect_note(r, "left out 'frame' and 'seq' (no unit)");
}

TEST_F(Log, GivenUnitIsForColumnsWithout) {
  const Record r = read("gyro_x,gyro_y (rad/s),ax,index\n1,2,3,0\n4,5,6,1\n7,8,9,2\n", {.rate_hz = 1, .unit = "deg/s"});
  ASSERT_EQ(r.axes.size(), 2U);
  expect_values(r.axes[0].rate, {1 * kDegree, 4 * kDegree, 7 * kDegree});
  expect_values(r.axes[1].rate, {2, 5, 8});
  expect_note(r, "left out 'ax' (named like an accelerometer, while --unit is that of a gyro)");
  expect_note(r, "left out 'index'");
}

TEST_F(Log, RawCountsWithScale) {
  const std::string text = "gx (counts),gy [LSB],gz\n1,2,3\n4,5,6\n";
  const Record r = read(text, {.rate_hz = 1, .unit = "deg/s", .scale = 0.25});
  ASSERT_EQ(r.axes.size(), 3U);
  EXPECT_NEAR(r.axes[0].rate[1], 4 * 0.25 * kDegree, 1e-17);
  EXPECT_NEAR(r.axes[2].rate[1], 6 * 0.25 * kDegree, 1e-17);
}

TEST_F(Log, AUnitNobodyKnowsGivesWayWhereTheColumnIsChosen) {
  const std::string text = "gx (frobs),gy (rad/s)\n1,2\n4,5\n";
  EXPECT_EQ(read(text, {.rate_hz = 1, .unit = "rad/s"}).axes.size(), 1U);
  const Record r = read(text, {.rate_hz = 1, .unit = "rad/s", .columns = {"gx"}});
  expect_values(r.axes[0].rate, {1, 4});
  expect_note(r, "the unit 'frobs' is not understood, --unit rad/s is used");
}

TEST_F(Log, Dimensionless) {
  const Record r = read("y (1)\n1e-12\n2e-12\n", {.rate_hz = 1});
  EXPECT_EQ(r.axes[0].signal, Signal::dimensionless);
  EXPECT_DOUBLE_EQ(read("5\n6\n", {.rate_hz = 1, .unit = "ppm"}).axes[0].rate[0], 5e-6);
}

TEST_F(Log, Increments) {
  const Record r =
      read("t (ms),dtheta (arcsec),dv (m/s)\n0,36,1\n10,72,2\n20,nan,3\n30,36,4\n", {.input = Input::increment});
  EXPECT_EQ(r.rate_hz, 100);
  ASSERT_EQ(r.axes.size(), 2U);
  EXPECT_EQ(r.axes[1].signal, Signal::specific_force);
  expect_values(r.axes[0].rate, {1 * kDegree, 2 * kDegree, kMissing, 1 * kDegree});
  expect_values(r.axes[1].rate, {100, 200, 300, 400});
}

TEST_F(Log, AnglesGiveOneRateFewer) {
  const Record r = read("10\n11\n13\nnan\n20\n21\n", {.rate_hz = 4, .unit = "rad", .input = Input::angle});
  EXPECT_EQ(r.samples, 5);
  EXPECT_EQ(r.missing_samples, 2);
  expect_values(r.axes[0].rate, {4, 8, kMissing, kMissing, 4});
}

TEST_F(Log, AnglesWithinOneTurnAreUnwrapped) {
  const Record r = read("350\n355\n0\n5\n355\n", {.rate_hz = 1, .unit = "deg", .input = Input::angle});
  ASSERT_EQ(r.samples, 4);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(r.axes[0].rate[i], 5 * kDegree, 1e-14);
  EXPECT_NEAR(r.axes[0].rate[3], -10 * kDegree, 1e-14);
  expect_note(r, "unwrapped 2 times");
  // A running angle of many turns is left as it is, however far it steps.
  const Record running = read("0\n300\n600\n", {.rate_hz = 1, .unit = "deg", .input = Input::angle});
  EXPECT_NEAR(running.axes[0].rate[0], 300 * kDegree, 1e-14);
}

TEST_F(Log, PhaseOfAClock) {
  const Record r = read("0\n1e-9\n3e-9\n", {.rate_hz = 1, .unit = "s", .input = Input::angle});
  EXPECT_EQ(r.axes[0].signal, Signal::dimensionless);
  expect_values(r.axes[0].rate, {1e-9, 3e-9 - 1e-9});
}

// --- Time ----------------------------------------------------------------------------------------------------------

TEST_F(Log, TimeInEveryUnit) {
  for (const auto& [header, step] : {std::pair<std::string, std::int64_t>{"time (s)", 10},
                                     {"time [ms]", 10'000},
                                     {"stamp (us)", 10'000'000},
                                     {"timestamp [ns]", 10'000'000'000},
                                     {"t_ms", 10'000},
                                     {"TimeUS", 10'000'000},
                                     {"timestamp_ns", 10'000'000'000},
                                     {"x (µs)", 10'000'000},
                                     {"nanoseconds", 10'000'000'000},
                                     {"imu/header.stamp.nsec", 10'000'000'000}}) {
    std::string text = header + ",w (rad/s)\n";
    for (std::int64_t i = 0; i < 5; ++i) text += std::to_string(700 * step + i * step) + ",1\n";
    const Record r = read(text);
    EXPECT_DOUBLE_EQ(r.rate_hz, 0.1) << header;
    EXPECT_EQ(r.axes.size(), 1U) << header;
  }
}

TEST_F(Log, SecondsAndNanosecondsInTwoColumns) {
  const Record r = read(
      "header.stamp.secs,header.stamp.nsecs,w (rad/s)\n1403636579,800000000,1\n1403636579,900000000,2\n1403636580,0,3\n"
      "1403636580,100000000,4\n");
  EXPECT_EQ(r.rate_hz, 10);
  EXPECT_EQ(r.samples, 4);
  ASSERT_EQ(r.axes.size(), 1U);
}

TEST_F(Log, TimeWithExponentsKeepsItsDigits) {
  const Record r =
      read("time (ns),w (1)\n1.403636579758555392e+18,1\n1.403636579758555492e18,1\n1.403636579758555592E+18,1\n");
  EXPECT_EQ(r.rate_hz, 1e7);
}

TEST_F(Log, UnlabelledTimeNeedsTheRate) {
  const std::string named = "time,w (rad/s)\n5,1\n15,2\n25,3\n";
  const std::string bare = "5 1\n15 2\n25 3\n";
  for (const auto& [rate, expected] : {std::pair{0.1, 0.1}, {100.0, 100.0}, {1e5, 1e5}, {1e8, 1e8}}) {
    EXPECT_DOUBLE_EQ(read(named, {.rate_hz = rate}).rate_hz, expected);
    const Record r = read(bare, {.rate_hz = rate, .unit = "1"});
    EXPECT_DOUBLE_EQ(r.rate_hz, expected);
    ASSERT_EQ(r.axes.size(), 1U);
    expect_values(r.axes[0].rate, {1, 2, 3});
    expect_note(r, "it is read as time");
  }
}

TEST_F(Log, TimeMayStandLast) {
  const Record r = read("0.5 1 0\n0.2 2 0.1\n0.9 3 0.2\n0.1 4 0.3\n", {.rate_hz = 10, .unit = "1"});
  EXPECT_EQ(r.axes.size(), 2U);
}

TEST_F(Log, ATimeColumnMayBeChosenAsData) {
  const Record r =
      read("time (s),w (rad/s)\n0,1\n1,2\n2,3\n", {.rate_hz = 1, .input = Input::angle, .columns = {"time"}});
  EXPECT_EQ(r.axes[0].name, "time");
  expect_values(r.axes[0].rate, {1, 1});
}

TEST_F(Log, TextualTimeIsLeftOutWhereTheRateIsGiven) {
  const std::string text = "time,w (rad/s)\nat ten,1\na bit later,2\n";
  const Record r = read(text, {.rate_hz = 1});
  EXPECT_EQ(r.axes.size(), 1U);
  expect_note(r, "holds text ('at ten') and is not used");
}

TEST_F(Log, AGivenRateIsTakenWhereTheTimeAgrees) {
  const std::string text = "time (s),w (1)\n0,1\n0.333333333,2\n0.666666667,3\n1,4\n";
  EXPECT_EQ(read(text, {.rate_hz = 3}).rate_hz, 3);
  EXPECT_NEAR(read(text).rate_hz, 3, 1e-8);
  // Within a per cent the clock of the file is right, and it is said.
  const Record r = read(text, {.rate_hz = 2.98});
  EXPECT_NEAR(r.rate_hz, 3, 1e-8);
  expect_note(r, "not 2.98 Hz");
}

std::string with_stamps(const std::vector<double>& stamps) {
  std::string text = "time (s),w (1)\n";
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    char row[64];
    std::snprintf(row, sizeof row, "%.9f,%zu\n", stamps[i], i);
    text += row;
  }
  return text;
}

TEST_F(Log, GapsBecomeMissingSamples) {
  std::vector<double> stamps;
  for (int i = 0; i < 200; ++i) {
    if (i != 50 && (i < 100 || i >= 107)) stamps.push_back(5 + 0.01 * i);
  }
  const Record r = read(with_stamps(stamps));
  EXPECT_NEAR(r.rate_hz, 100, 1e-9);
  EXPECT_EQ(r.samples, 200);
  EXPECT_EQ(r.missing_samples, 8);
  EXPECT_EQ(r.axes[0].rate[49], 49);
  EXPECT_TRUE(std::isnan(r.axes[0].rate[50]));
  EXPECT_EQ(r.axes[0].rate[51], 50);
  EXPECT_EQ(r.axes[0].rate[107], 99);
  expect_note(r, "2 gaps in time: 8 samples missing, at most 7 in a row (before line 101)");
}

TEST_F(Log, AnIsolatedRepeatedStampMasksItsPoint) {
  std::vector<double> stale, doubled;
  for (int i = 0; i < 200; ++i) {
    stale.push_back(0.01 * (i == 80 ? 79 : i));  // a sample that came with the stamp of the one before
    doubled.push_back(0.01 * i);
    if (i == 79) doubled.push_back(0.01 * i);  // a row that was written twice
  }
  const Record r = read(with_stamps(stale));
  EXPECT_EQ(r.samples, 200);
  EXPECT_EQ(r.missing_samples, 2);  // point 79 has two rows, point 80 has none
  EXPECT_EQ(r.axes[0].rate[81], 81);
  expect_note(r, "1 repeated time stamp (the first in line 82)");
  const Record d = read(with_stamps(doubled));
  EXPECT_EQ(d.samples, 200);
  EXPECT_EQ(d.missing_samples, 1);
  EXPECT_TRUE(std::isnan(d.axes[0].rate[79]));
  EXPECT_EQ(d.axes[0].rate[80], 81);
}

TEST_F(Log, RowsWithoutAStampAreLeftOut) {
  const Record r = read("time (s),w (1)\n0,1\n1,2\nnan,3\n3,4\n4,5\n,6\n6,7\n7,8\n8,9\n");
  EXPECT_EQ(r.samples, 9);
  EXPECT_EQ(r.missing_samples, 2);
  expect_values(r.axes[0].rate, {1, 2, kMissing, 4, 5, kMissing, 7, 8, 9});
  expect_note(r, "2 rows without a time stamp left out");
}

TEST_F(Log, JitterAndDriftLoseNoSamples) {
  std::vector<double> stamps;
  std::uint32_t state = 1;
  double time = 1000;
  for (int i = 0; i < 5000; ++i) {
    state = state * 1664525 + 1013904223;
    const double jitter = 0.003 * (state / 4294967296.0 - 0.5);  // +-15 % of the interval
    stamps.push_back(time + jitter + (i == 2500 ? 0.0085 : 0));  // one sample is 0.85 intervals late
    time += 0.01 * (1 + 0.004 * std::sin(i / 800.0));            // a clock that drifts by several samples
  }
  const Record r = read(with_stamps(stamps));
  EXPECT_EQ(r.samples, 5000);
  EXPECT_EQ(r.missing_samples, 0);
  EXPECT_NEAR(r.rate_hz, 100, 0.5);
  expect_note(r, "the stamps jitter by");
}

TEST_F(Log, CoarseStampsGiveTheTrueRate) {
  std::string text = "time (ms),w (1)\n";
  for (int i = 0; i < 3000; ++i) text += std::to_string(i * 10 / 3) + ",1\n";  // 300 Hz in whole milliseconds
  const Record r = read(text);
  EXPECT_EQ(r.samples, 3000);
  EXPECT_NEAR(r.rate_hz, 300, 1e-3);
}

TEST_F(Log, BurstsAreReadWithTheirRate) {
  std::string text = "time (ms),w (1)\n";
  for (int i = 0; i < 1000; ++i) text += std::to_string(i / 4 * 40 + i % 4) + ",1\n";  // four samples each 40 ms
  const Record r = read(text, {.rate_hz = 100});
  EXPECT_EQ(r.samples, 1000);
  EXPECT_EQ(r.missing_samples, 0);
  EXPECT_NEAR(r.rate_hz, 100, 0.5);
}

// --- Parallel parsing ----------------------------------------------------------------------------------------------

TEST_F(Log, ChunksOfAnySizeGiveTheSame) {
  std::string text = "# head\ntime (s);w (rad/s);note;v (m/s^2)\r\n";
  for (int i = 0; i < 300; ++i) {
    if (i % 17 == 3) text += "# comment " + std::to_string(i) + "\n";
    if (i % 23 == 5) text += i % 2 ? "\n" : "  \r\n";
    text += std::to_string(i * 0.01) + "; " + std::to_string(std::sin(i)) + ";" +
            std::string(static_cast<std::size_t>(i % 7), 'x') + ";" + (i % 31 == 0 ? "nan" : std::to_string(i)) +
            (i % 3 ? "\n" : " \r\n");
  }
  const Record whole = read(text);
  EXPECT_EQ(whole.samples, 300);
  EXPECT_EQ(whole.missing_samples, 10);
  for (std::size_t chunk = 1; chunk < 200; chunk += chunk < 40 ? 1 : 13) {
    const Record r = read(text, {.chunk_bytes = chunk});
    ASSERT_EQ(r.samples, whole.samples) << chunk;
    EXPECT_EQ(r.rate_hz, whole.rate_hz);
    EXPECT_EQ(r.notes, whole.notes) << chunk;
    for (std::size_t a = 0; a < 2; ++a) {
      EXPECT_EQ(std::memcmp(r.axes[a].rate.data(), whole.axes[a].rate.data(), 300 * sizeof(double)), 0) << chunk;
    }
  }
}

TEST_F(Log, TheFirstFaultInTheFileIsReportedAtAnyChunkSize) {
  std::string text = "a (1),b (1)\n";
  for (int i = 0; i < 400; ++i) {
    if (i % 50 == 20) text += "# comment\n\n";
    text += i == 251 ? "1,oops\n" : i > 260 && i % 10 == 0 ? "1,2,3\n" : i > 300 ? "x,y\n" : "1,2\n";
  }
  // Row 251 is the 252nd, behind a header and five pairs of comment and blank line.
  const std::string expected = ":263:3: found 'oops' in column 'b', expected a number";
  for (const std::size_t chunk : {1UL, 2UL, 3UL, 7UL, 64UL, 1000UL, 1000000UL}) {
    EXPECT_CONTAINS(message_of<text::InputError>([&] { (void)read(text, {.rate_hz = 1, .chunk_bytes = chunk}); }),
                    expected);
  }
}

TEST_F(Log, ALineOfARowIsRightAtAnyChunkSize) {
  std::string text = "time (s),b (1)\n";
  for (int i = 0; i < 200; ++i) text += (i % 9 == 1 ? "#\n" : "") + std::to_string(i == 120 ? 5 : i) + ",1\n";
  for (const std::size_t chunk : {1UL, 3UL, 50UL, 1000UL, 1000000UL}) {
    EXPECT_CONTAINS(message_of<text::InputError>([&] { (void)read(text, {.chunk_bytes = chunk}); }),
                    ":136:1: the time column 'time' goes back by 114 s");
  }
}

// --- Real logs -----------------------------------------------------------------------------------------------------

class RealLog : public testing::Test {
 protected:
  static std::string data(const std::string& name) { return std::string(GYROBUDGET_DATA) + "/" + name; }
  void SetUp() override {
    if (!std::filesystem::exists(data("static"))) GTEST_SKIP() << "no public logs in " << GYROBUDGET_DATA;
  }
};

TEST_F(RealLog, MemsGyro) {
  const Record r = log::read_log({.path = data("static/mems_gyro_x.csv.gz"), .rate_hz = 1, .unit = "deg/s"});
  EXPECT_EQ(r.samples, 238'256);
  EXPECT_EQ(r.missing_samples, 0);
  EXPECT_DOUBLE_EQ(r.axes.at(0).rate[0], 1.2425 * kDegree);
}

TEST_F(RealLog, RingLaserCountsAsIncrements) {
  const Record r = log::read_log({.path = data("static/rlg_vehicle_counts.csv.gz"),
                                  .rate_hz = 100,
                                  .unit = "arcsec",
                                  .input = Input::increment,
                                  .scale = 0.1});
  EXPECT_EQ(r.samples, 184'718);
  ASSERT_EQ(r.axes.size(), 3U);  // the accelerometers have another unit
  // Means of the data set's own description, in deg/h; printed with four decimals.
  const double expected[] = {-12.2715, 0.4377, 8.3569};
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 0;
    for (const double v : r.axes[i].rate) sum += v;
    EXPECT_NEAR(sum / 184'718 / kDegree * 3600, expected[i], 5e-5);
  }
}

TEST_F(RealLog, VehicleLogWithTimeInTheLastColumn) {
  const Record r = log::read_log({.path = data("nav/mems_imu_100hz.csv.gz"), .unit = "m/s", .input = Input::increment});
  EXPECT_EQ(r.samples, 10'001);
  EXPECT_DOUBLE_EQ(r.rate_hz, 100);
  ASSERT_EQ(r.axes.size(), 3U);
  EXPECT_EQ(r.axes[0].signal, Signal::specific_force);
}

TEST_F(RealLog, OscillatorFrequencyAndPhase) {
  const Record frequency =
      log::read_log({.path = data("oscillator/ocxo_frequency_hz.csv.gz"), .rate_hz = 1, .unit = "1", .scale = 1e-7});
  EXPECT_EQ(frequency.samples, 19'982);
  const Record phase =
      log::read_log({.path = data("oscillator/phase_dat.csv.gz"), .rate_hz = 1, .unit = "s", .input = Input::angle});
  EXPECT_EQ(phase.samples, 1000);  // 1001 phases
}

}  // namespace
}  // namespace gyrobudget::app_tests
