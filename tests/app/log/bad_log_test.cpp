// SPDX-License-Identifier: MIT
// Bad input: every message names place, finding, expectation and mend; nothing crashes, hangs or fills the memory.
#include "gyrobudget/app/log/log.h"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <random>
#include <stdexcept>

#include "../packing.h"
#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using log::Input;
using log::LogOptions;
using text::InputError;

class BadLog : public TemporaryFolder {
 protected:
  [[nodiscard]] std::string message(std::string_view text, LogOptions options = {}) const {
    options.path = file("log.csv", text);
    const std::string found = message_of<InputError>([&] { (void)log::read_log(options); });
    EXPECT_EQ(found.rfind(options.path, 0), 0U) << found;  // each begins with the place
    return found.substr(std::min(found.size(), options.path.size()));
  }
};

// --- Files that are no logs ----------------------------------------------------------------------------------------

TEST_F(BadLog, NoFileAndFolder) {
  const auto of = [](const std::string& path) {
    return message_of<InputError>([&] { (void)log::read_log({.path = path, .rate_hz = 1}); });
  };
  EXPECT_EQ(of(path("none.csv")),
            path("none.csv") + ": cannot be read: No such file or directory; check the name and the folder");
  EXPECT_CONTAINS(of(path("")), "is a folder, expected a file; name a file in it");
}

TEST_F(BadLog, NothingInIt) {
  EXPECT_CONTAINS(message(""), ": is empty, expected a log");
  EXPECT_CONTAINS(message("\xef\xbb\xbf"), "holds no samples");
  EXPECT_CONTAINS(message("\n\n# comment\n"), "holds no samples, only blank and comment lines");
  EXPECT_CONTAINS(message("time (s),gyro_x (deg/s)\n"), "holds a header (line 1) but no samples under it");
  EXPECT_CONTAINS(message("#c\ntime,gyro_x\ns,deg/s\n"), "holds a header (line 2) but no samples under it");
}

TEST_F(BadLog, TooShort) {
  EXPECT_CONTAINS(message("w (1)\n5\n", {.rate_hz = 1}), "holds 1 sample, expected at least 2; record longer");
  EXPECT_CONTAINS(message("5\n6\n", {.rate_hz = 1, .unit = "rad", .input = Input::angle}),
                  "holds 2 samples, expected at least 3");
  EXPECT_CONTAINS(message("w (1),v (1)\n5,nan\n6,nan\n7,nan\n", {.rate_hz = 1, .columns = {"w", "v"}}),
                  "holds 0 numbers in column 'v', expected at least 2");
  EXPECT_CONTAINS(message("w (1),v (1)\nnan,nan\nnan,nan\nnan,nan\n", {.rate_hz = 1}), "holds 0 numbers in column 'w'");
}

TEST_F(BadLog, BinaryAndForeignFormats) {
  EXPECT_CONTAINS(message(std::string("1,2\n3,\0 4\n", 10)), "found the byte 0x00 at offset 6, expected a text file");
  EXPECT_CONTAINS(message("PK\x03\x04 and so on"), "is a zip archive or a spreadsheet; unpack it");
  EXPECT_CONTAINS(message("#ROSBAG V2.0\n"), "this ROS 1 bag holds no IMU");
  EXPECT_CONTAINS(message(std::string("\xff\xfe"
                                      "1\0,\0",
                                      6)),
                  "found text in UTF-16, expected a text file; save it as UTF-8");
  std::mt19937_64 random(1);
  for (const std::size_t size : {1UL, 3UL, 20UL, 100UL, 1000UL, 100000UL}) {
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    EXPECT_FALSE(message(bytes).empty());
  }
}

TEST_F(BadLog, DamagedGzip) {
  std::string text;
  for (long i = 0; i < 100000; ++i) text += std::to_string(i * i % 10007) + "\n";
  const std::string whole = gzip(text);
  const LogOptions options = {.rate_hz = 1, .unit = "1"};
  for (const std::size_t size :
       {std::size_t{2}, std::size_t{9}, std::size_t{200}, whole.size() / 2, whole.size() - 1}) {
    EXPECT_CONTAINS(message(whole.substr(0, size), options), "the gzip data stop in the middle");
  }
  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 0x10;
  EXPECT_CONTAINS(message(damaged, options), "the gzip data are damaged");
  damaged = whole;
  damaged[whole.size() - 6] ^= 1;  // check sum
  EXPECT_CONTAINS(message(damaged, options), "the gzip data are damaged");
  EXPECT_CONTAINS(message(whole + "something else", options), "the gzip data end, but the file goes on");
  EXPECT_CONTAINS(message(gzip(""), options), "is empty");
}

double seconds_and_memory(const std::function<void()>& work, long& kilobytes) {
  rusage before = {}, after = {};
  ::getrusage(RUSAGE_SELF, &before);
  const auto start = std::chrono::steady_clock::now();
  work();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ::getrusage(RUSAGE_SELF, &after);
  kilobytes = after.ru_maxrss - before.ru_maxrss;
  return seconds;
}

TEST_F(BadLog, AGigabyteInOneLineIsRefusedAtOnce) {
  // A sparse file: a gigabyte of zero bytes behind a row of text; and the same as digits in a gzip bomb.
  constexpr long kMostKilobytes = 64 * 1024;
  constexpr double kMostSeconds = 2;  // it takes milliseconds; a loaded machine may be slow
  const std::string sparse = file("sparse.csv", std::string(100000, '7'));
  ASSERT_EQ(::truncate(sparse.c_str(), 1 << 30), 0);
  std::string bomb;
  for (int i = 0; i < 60; ++i) bomb += gzip(std::string(1 << 20, '7'));
  const std::string packed = file("bomb.csv.gz", bomb);
  const std::string second = file("second.csv.gz", gzip("1\n2\n3\n") + bomb);
  for (const std::string& path : {sparse, packed, second}) {
    long kilobytes = 0;
    std::string found;
    const double seconds = seconds_and_memory(
        [&] {
          found = message_of<InputError>([&] { (void)log::read_log({.path = path, .rate_hz = 1, .unit = "1"}); });
        },
        kilobytes);
    EXPECT_CONTAINS(found, path == second ? ":4:1: found a line of more than 1048576 bytes that starts with '7777"
                                          : ":1:1: found a line of more than 1048576 bytes that starts with '7777");
    EXPECT_LT(seconds, kMostSeconds);
    EXPECT_LT(kilobytes, kMostKilobytes);
  }
}

TEST_F(BadLog, ALongLineAmongRows) {
  std::string text = "# c\n";
  for (int i = 0; i < 1000; ++i) text += "1,2\n";
  text += std::string((1 << 20) + 1, '8') + "\n1,2\n";
  for (const std::size_t chunk : {10UL, 1000UL, 1UL << 20}) {
    EXPECT_CONTAINS(message(text, {.rate_hz = 1, .unit = "1", .chunk_bytes = chunk}),
                    ":1002:1: found a line of more than");
  }
}

TEST_F(BadLog, ManyNumbersInOneLine) {
  std::string text;
  for (int i = 0; i < 100000; ++i) text += "1.5 ";
  EXPECT_CONTAINS(message(text + "\n", {.rate_hz = 1, .unit = "1"}),
                  "put each sample on a line of its own (tr -s ' ' '\\n')");
}

// --- Rows ----------------------------------------------------------------------------------------------------------

TEST_F(BadLog, TextInANumberColumn) {
  const LogOptions options = {.rate_hz = 1};
  EXPECT_EQ(message("a (1),b (1)\n1,2\n3, abc\n", options),
            ":3:4: found 'abc' in column 'b', expected a number; correct it, or write nan where a sample is missing");
  EXPECT_CONTAINS(message("a (1),b (1)\n1,2\n1,1.2.3\n", options), ":3:3: found '1.2.3' in column 'b'");
  EXPECT_CONTAINS(message("a (1),b (1)\n1,2\n0x1F,2\n", options), ":3:1: found '0x1F' in column 'a'");
  EXPECT_CONTAINS(message("a (1),b (1)\n1,2\n1 2,3\n", options), ":3:1: found '1 2'");
  EXPECT_CONTAINS(message("a (1),b (1)\n1,2\n1,\x01\x02\n1,\xb0\n", options), "found the byte 0x01");
  EXPECT_CONTAINS(message("1 2\n3 4\n5 six\n", {.rate_hz = 1, .unit = "1", .columns = {"2"}}),
                  ":3:3: found 'six' in column 2");
  EXPECT_CONTAINS(message("time (s),w (1)\n0,1\n1,1\nnoon,1\n"),
                  ":4:1: found 'noon' in column 'time', expected a number");
  EXPECT_CONTAINS(message("a (1),b (1)\n1,2\n" + std::string(5000, 'z') + ",1\n", options), "zzz...' in column 'a'");
}

TEST_F(BadLog, RaggedRows) {
  const LogOptions options = {.rate_hz = 1, .unit = "1"};
  EXPECT_EQ(message("7,2,9\n3,4,5\n5,6\n", options),
            ":3:4: found 2 cells, expected 3 as in the first row; complete the row or delete it");
  EXPECT_CONTAINS(message("7,2,9\n3,4,5\n5,6,7,8\n", options), ":3:7: found 4 cells, expected 3");
  EXPECT_CONTAINS(message("7 2 9\n3 4 5\n5 6\n", options), ":3:4: found 2 cells, expected 3");
  EXPECT_CONTAINS(message("7 2 9\n3 4 5\n5 6 7 8\n", options), ":3:7: found 4 cells, expected 3");
  EXPECT_CONTAINS(message("a,b,c\n1,2\n3,4\n", options), ":2:1: found 2 cells under a header of 3 names");
  EXPECT_CONTAINS(message("gyro x gyro y\n1 2\n3 4\n", options),
                  "under a header of 4 names; give each column one name, without blanks");
  // A row that is short only in columns nobody asked for is as broken.
  EXPECT_CONTAINS(message("a,b,c\n1,2,3\n4\n", {.rate_hz = 1, .unit = "1", .columns = {"a"}}),
                  ":3:2: found 1 cell, expected 3");
}

TEST_F(BadLog, NumbersBeyondDouble) {
  EXPECT_CONTAINS(message("w (1)\n1\n1e999\n", {.rate_hz = 1}),
                  ":3:1: found '1e999' in column 'w', expected a number within the range of double (1.8e308)");
  EXPECT_CONTAINS(message("w (1)\n1\n-" + std::string(400, '9') + "\n", {.rate_hz = 1}), ":3:1: found '-999");
  EXPECT_CONTAINS(message("w (rev/s)\n1\n1e308\n", {.rate_hz = 1}),
                  ":3:1: found '1e308' in column 'w'");  // in rad/s
  EXPECT_CONTAINS(message("time (s),w (1)\n0,1\n1e10,1\n"),
                  ":3:1: found '1e10' in column 'time', expected a time within 292 years");
}

TEST_F(BadLog, CommasThatMayBeDecimalMarks) {
  EXPECT_CONTAINS(message("0,125\n0,031\n-0,250\n", {.rate_hz = 1, .unit = "1"}),
                  ":2:1: found '0,031', where the commas may be decimal marks or part the columns");
  EXPECT_CONTAINS(message("t (s);w (1)\n0;1,5\n1;1.234,5\n2;1,5\n"), ":3:3: found '1.234,5' in column 'w'");
  EXPECT_CONTAINS(
      message("t (s);w (1)\n0;1,5\n1;1.234\n2;1,5\n"),
      ":3:3: found '1.234' in column 'w', expected a number with a decimal comma as in the first rows; write all numbers alike, without marks between thousands");
  EXPECT_CONTAINS(message("t (s);w (1)\n0;1.5\n1;2.5\n2;1,5\n"), "expected a number with a decimal point");
  EXPECT_CONTAINS(message("0,125\n0,031\n-0,250\n", {.rate_hz = 1, .unit = "1"}),
                  "part the columns by semicolons, or name the columns in a header line");
  EXPECT_CONTAINS(message("\"t (s)\",\"w (1)\"\n\"0,0\",\"1,5\"\n\"0,1\",\"2,5\"\n"),
                  ":2:1: found '\"0,0\",\"1,5\"', decimal commas in quotes between commas; write decimal points");
}

// --- Columns, units, rate ------------------------------------------------------------------------------------------

TEST_F(BadLog, MissingRate) {
  EXPECT_EQ(message("w (1)\n1\n2\n"), ":1:1: has no time column and no rate is given; give the sample rate: --rate HZ");
}

TEST_F(BadLog, MissingUnit) {
  const LogOptions options = {.rate_hz = 1};
  EXPECT_EQ(
      message("gyro_x_dps\n1\n2\n", options),
      ":1:1: column 'gyro_x_dps' has no unit, expected one in the header, as in \"gyro_x_dps (deg/s)\", or --unit deg/s; if its name stands for deg/s, give --unit deg/s");
  EXPECT_CONTAINS(message("1\n3\n", options),
                  ":1:1: column 1 has no unit, expected one in the header, as in \"gyro_x (deg/s)\"");
  EXPECT_CONTAINS(message("t (s),gx,gy (rad/s)\n0,1,2\n1,2,3\n", {.columns = {"gx"}}), ":1:7: column 'gx' has no unit");
  EXPECT_CONTAINS(message("gx (counts)\n1\n2\n", options), "counts need --scale (units per count) and --unit");
  EXPECT_CONTAINS(message("a_rad\n1\n2\n", options),
                  "give --unit rad; --input increment (per sample) or --input angle");
}

TEST_F(BadLog, UnitsOfTheWrongKind) {
  const LogOptions options = {.rate_hz = 1};
  EXPECT_CONTAINS(
      message("a (rad)\n1\n2\n", options),
      "found no data column among 'a' (the unit 'rad' is not that of a rate or an acceleration; --input increment (per sample) or --input angle (running) reads it)");
  EXPECT_CONTAINS(message("w (deg/s)\n1\n2\n", {.rate_hz = 1, .input = Input::angle}),
                  "the unit 'deg/s' is not that of an angle or a velocity; --input rate reads it");
  EXPECT_CONTAINS(message("temp (degC),rh (%)\n1,2\n2,3\n", options),
                  "found no data column among 'rh' (a plain number), expected one with a rate");
  EXPECT_CONTAINS(message("time (s),sec (s)\n1,2\n2,3\n", options), "found no data column among");
  EXPECT_CONTAINS(message("t (s),w (rad/s)\n0,1\n1,2\n", {.rate_hz = 1, .columns = {"2", "t"}}),
                  ":1:1: column 't': the unit 's' is not that of");
}

TEST_F(BadLog, UnknownColumn) {
  const LogOptions options = {.rate_hz = 1, .unit = "1", .columns = {"gyro_q"}};
  EXPECT_CONTAINS(message("gyro_x,gyro_y\n1,2\n2,3\n", options),
                  ": has no column 'gyro_q' (did you mean 'gyro_x'?); there are columns 1 to 2: gyro_x and gyro_y");
  EXPECT_CONTAINS(message("1,2\n2,3\n", {.rate_hz = 1, .unit = "1", .columns = {"3"}}),
                  "has no column '3'; there are columns 1 to 2");
  EXPECT_CONTAINS(message("1,2\n2,3\n", {.rate_hz = 1, .unit = "1", .columns = {"0"}}), "has no column '0'");
  EXPECT_CONTAINS(message("1,2\n2,3\n", {.rate_hz = 1, .unit = "1", .columns = {""}}), "has no column ''");
}

TEST_F(BadLog, OptionsWrongWithAnyLog) {
  const std::string log = file("log.csv", "1\n2\n");
  const auto of = [&](LogOptions options) {
    options.path = log;
    return message_of<std::invalid_argument>([&] { (void)log::read_log(options); });
  };
  EXPECT_CONTAINS(of({.rate_hz = 0}), "rate_hz is 0 Hz; it must be above 0");
  EXPECT_CONTAINS(of({.rate_hz = -1}), "rate_hz");
  EXPECT_CONTAINS(of({.rate_hz = std::numeric_limits<double>::quiet_NaN()}), "rate_hz");
  EXPECT_CONTAINS(of({.rate_hz = 1, .unit = "frob/s"}), "'frob' is no known unit");
  EXPECT_CONTAINS(of({.rate_hz = 1, .scale = 0}), "scale is 0; it must be finite and not 0");
}

// --- Time ----------------------------------------------------------------------------------------------------------

TEST_F(BadLog, TimeThatGoesBack) {
  EXPECT_EQ(
      message("time (s),w (1)\n0,1\n0.1,2\n0.2,3\n0.15,4\n0.3,5\n"),
      ":5:1: the time column 'time' goes back by 0.05 s, expected rising time; cut the log here (allan --segments GAP does), or put its rows in order");
}

TEST_F(BadLog, TimeThatRepeats) {
  EXPECT_CONTAINS(message("time (s),w (1)\n0,1\n0.1,2\n0.1,3\n0.2,4\n"),
                  ":4:1: the time column 'time' repeats the stamp");
  std::string text = "time (s),w (1)\n";
  for (int i = 0; i < 1000; ++i) text += std::to_string(1700000000 + i / 100) + ",1\n";  // whole seconds at 100 Hz
  EXPECT_CONTAINS(message(text),
                  ":3:1: the time column 'time' repeats the stamp of the row before it, as 990 of 1000 rows do");
  EXPECT_CONTAINS(message("time (s),w (1)\n5,1\n5,2\n5,3\n"),
                  "write the time with more digits, or remove the column and give --rate HZ");
}

TEST_F(BadLog, RateThatContradictsTheTime) {
  std::string text = "time (s),w (1)\n";
  for (int i = 0; i < 100; ++i) text += std::to_string(i * 0.01) + ",1\n";
  for (const double rate : {200.0, 50.0, 102.0, 98.0, 1e5}) {
    EXPECT_CONTAINS(message(text, {.rate_hz = rate}), "the time column 'time' says 100 Hz, but --rate says");
  }
}

TEST_F(BadLog, TimeWithoutUnit) {
  const std::string named = "time,w (1)\n5,1\n15,2\n25,3\n";
  EXPECT_EQ(
      message(named),
      ":1:1: the time column 'time' has no unit: its step of 10 is 0.1 Hz in s, 100 Hz in ms, 1e+05 Hz in us or 1e+08 Hz in ns; write the unit into the header, as in \"time (s)\", or give --rate HZ or --time 1=ms");
  EXPECT_CONTAINS(message(named, {.rate_hz = 7}),
                  "but --rate is 7 Hz; correct --rate, or choose the data columns with --column");
  EXPECT_CONTAINS(message("5 1\n15 2\n25 1\n", {.unit = "1"}), ":1:1: the time column 1 has no unit");
  EXPECT_CONTAINS(message("5 1\n15 2\n25 1\n", {.rate_hz = 7, .unit = "1"}), "column 1 rises like a time by 10 a row");
  EXPECT_CONTAINS(message("time,w (1)\n5,1\n5,2\n5,3\n", {.rate_hz = 7}), "does not rise in the first rows");
  EXPECT_CONTAINS(message("time,w (1)\nnoon,1\nlate,2\n"),
                  ":2:1: found 'noon' in the time column 'time', expected a number");
}

TEST_F(BadLog, TimeThatIsTooUnevenOrFullOfGaps) {
  std::string bursts = "time (ms),w (1)\n", gaps = "time (s),w (1)\n",
              far = "time (s),w (1)\n0,1\n1,1\n2,1\n3,1\n9e9,1\n";
  for (int i = 0; i < 400; ++i) {
    bursts += std::to_string(i / 4 * 40 + i % 4 * 9 + (i % 3) * 4) + ",1\n";
    gaps += std::to_string(i + (i > 200 ? 10000 : 0)) + ",1\n";
  }
  EXPECT_CONTAINS(message(bursts),
                  "% (rms) of the sample interval, expected at most 25 %; if the samples themselves are even");
  EXPECT_CONTAINS(message(gaps),
                  ":203:1: 10000 of 10400 samples are missing, the most (10000) before the stamp of this row");
  EXPECT_CONTAINS(message(far), ":6:1: ");
  EXPECT_CONTAINS(message("time (ns),w (1)\n9000000000000000000,1\n-9000000000000000000,1\n"), "goes back by");
  EXPECT_CONTAINS(message("time (ns),w (1)\n0,1\n1,1\n2,1\n3000000000000000000,1\n"), "are missing");
  EXPECT_CONTAINS(message("time (ns),w (1)\n-9000000000000000000,1\n9000000000000000000,1\n9000000000000000001,1\n"),
                  "is more than a century after its start");
  EXPECT_CONTAINS(message("time (s),w (1)\nnan,1\n,2\n1,3\n"), "holds fewer than two stamps");
}

// --- Mutations -----------------------------------------------------------------------------------------------------

/// Damages a text in ways that happen: bytes changed, cut out, doubled, swapped, ends cut off.
std::string mutated(std::string text, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  static constexpr std::string_view kPieces[] = {",",    ";",   "\n", "\r", "\t", " ",   "-",     "e",
                                                 ".",    "nan", "\"", "#",  "(",  "]",   "1e999", "9223372036854775807",
                                                 "\xff", "--",  "//", "0",  ",,", "\n\n"};
  for (std::size_t n = 1 + below(4); n > 0 && !text.empty(); --n) {
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(below(20), text.size() - at);
    switch (below(6)) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      case 3:
        text.insert(at, kPieces[below(std::size(kPieces))]);
        break;
      case 4:
        text.resize(at);
        break;
      default:
        std::swap(text[at], text[below(text.size())]);
    }
  }
  return text;
}

TEST_F(BadLog, MutationsOfGoodLogsGiveARecordOrAnInputError) {
  const std::string header = "time (s),gyro_x (deg/s),acc_x (m/s^2),note\n";
  std::string rows, blanks = "t (ms)  gyro_x (rad/s)\n", commas = "t (s);w (rad/s)\n";
  for (int i = 0; i < 60; ++i) {
    rows += std::to_string(i * 0.01) + "," + std::to_string(i % 7) + ",9.8,ok\n";
    blanks += std::to_string(i * 10) + "   " + std::to_string(i % 5) + ".5\n";
    commas += std::to_string(i) + ";0," + std::to_string(i % 9) + "\n";
  }
  const std::array<std::string, 4> seeds = {header + rows, blanks, commas, gzip(header + rows)};
  std::mt19937_64 random(20261122);
  int records = 0, errors = 0;
  constexpr int kMutants = 6000;
  for (int i = 0; i < kMutants; ++i) {
    LogOptions options = {.path = file("mutant", mutated(seeds[static_cast<std::size_t>(i) % seeds.size()], random)),
                          .chunk_bytes = i % 3 == 0 ? 1UL + random() % 100 : 1UL << 20};
    if (i % 5 == 0) options.rate_hz = 100;
    if (i % 7 == 0) options.unit = "rad/s";
    if (i % 11 == 0) options.input = Input::angle;
    try {
      const allan::Record record = log::read_log(options);
      ++records;
      ASSERT_GE(record.samples, 2);
      ASSERT_GT(record.rate_hz, 0);
      ASSERT_FALSE(record.axes.empty());
      for (const allan::Axis& axis : record.axes) ASSERT_EQ(axis.rate.size(), static_cast<std::size_t>(record.samples));
    } catch (const InputError& error) {
      ++errors;
      ASSERT_EQ(std::string(error.what()).rfind(options.path + ":", 0), 0U) << error.what();
    }
  }
  EXPECT_GT(records, kMutants / 20);  // both outcomes are exercised
  EXPECT_GT(errors, kMutants / 20);
}

}  // namespace
}  // namespace gyrobudget::app_tests
