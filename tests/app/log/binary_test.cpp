// SPDX-License-Identifier: MIT
// Binary logs: the .npy header as NumPy writes it, and every way in which the bytes can be wrong.
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/log/stream.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "../packing.h"
#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using log::Format;
using text::InputError;

using BinaryLog = TemporaryFolder;

constexpr double kDegree = std::numbers::pi / 180;

template <class Number>
std::string raw(const std::vector<double>& values) {
  std::string bytes;
  for (const double v : values) {
    const auto number = static_cast<Number>(v);
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(Number));
  }
  return bytes;
}

std::string prefix(int version, std::size_t size) {
  std::string bytes = "\x93NUMPY";
  bytes += {static_cast<char>(version), '\0', static_cast<char>(size & 0xffU), static_cast<char>(size >> 8U)};
  return version == 1 ? bytes : bytes + std::string(2, '\0');
}

/// A .npy with this dictionary and body; NumPy pads with blanks to a multiple of 64.
std::string npy(const std::string& dictionary, const std::string& body, int version = 1) {
  return prefix(version, dictionary.size() + 1) + dictionary + '\n' + body;
}

std::string dictionary(const std::string& descr, const std::string& shape, const std::string& order = "False") {
  return "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
}

const std::vector<double> kValues{1, 2, 3, 4, 5, 6};

log::LogOptions options(const std::string& path) { return {.path = path, .rate_hz = 10, .unit = "deg/s"}; }

TEST_F(BinaryLog, NumPyFilesOfBothWidthsAndShapes) {
  struct Case {
    std::string bytes;
    std::size_t columns;
  };
  const std::vector<Case> cases{
      {npy(dictionary("<f8", "(6,)"), raw<double>(kValues)), 1},
      {npy(dictionary("<f4", "(6,)"), raw<float>(kValues)), 1},
      {npy(dictionary("<f8", "(3, 2)"), raw<double>(kValues)), 2},
      {npy(dictionary("<f4", "(2, 3)"), raw<float>(kValues), 2), 3},
      {npy(dictionary("<f8", "(6, 1)", "True"), raw<double>(kValues), 3), 1},  // C and Fortran order alike
      {npy("{\"shape\": (6,), \"fortran_order\": False, \"descr\": \"<f8\"}", raw<double>(kValues)), 1},
  };
  for (const Case& c : cases) {
    const allan::Record record = log::read_log(options(file("log.npy", c.bytes)));
    ASSERT_EQ(record.axes.size(), c.columns);
    ASSERT_EQ(record.samples, static_cast<std::int64_t>(6 / c.columns));
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(record.axes[i % c.columns].rate[i / c.columns] / kDegree, kValues[i], 1e-12);
    }
    EXPECT_EQ(record.axes.back().name, "column " + std::to_string(c.columns));
  }
}

TEST_F(BinaryLog, WhatIsNotFiniteIsMissing) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const allan::Record record = log::read_log(options(file("log.f64", raw<double>({1, nan, 3, inf, -inf, 6}))));
  EXPECT_EQ(record.samples, 6);
  EXPECT_EQ(record.missing_samples, 3);
  EXPECT_TRUE(std::isnan(record.axes[0].rate[3]));
}

TEST_F(BinaryLog, IncrementsAnglesAndScalesAsInText) {
  auto increments = options(file("log.f64", raw<double>({1, 2, 4})));
  increments.unit = "rad";
  increments.input = log::Input::increment;
  increments.scale = 0.5;
  EXPECT_EQ(log::read_log(increments).axes[0].rate, (std::vector<double>{5, 10, 20}));
  increments.input = log::Input::angle;
  EXPECT_EQ(log::read_log(increments).axes[0].rate, (std::vector<double>{5, 10}));
}

TEST_F(BinaryLog, EveryDefectIsAnErrorThatSaysWhatToDo) {
  const std::string body = raw<double>(kValues), good = npy(dictionary("<f8", "(6,)"), body);
  struct Case {
    std::string bytes, part;
  };
  const std::vector<Case> cases{
      {good.substr(0, 4), "inside the header"},
      {good.substr(0, 9), "inside the header"},
      {good.substr(0, 40), "ends after 40 bytes, inside a header of"},
      {"time,gyro\n1,2\n", "expected the mark of a .npy"},
      {npy(dictionary("<f8", "(6,)"), body, 4), "version 4, expected 1 to 3"},
      {npy(dictionary(">f8", "(6,)"), body), "big-endian numbers (dtype '>f8')"},
      {npy(dictionary("<i8", "(6,)"), body), "dtype '<i8'), expected little-endian numbers of dtype <f4 or <f8"},
      {npy(dictionary("|O", "(6,)"), body), "dtype '|O'"},
      {npy("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (6,), }", body), "records of several fields"},
      {npy(dictionary("<f8", "(3, 2)", "True"), body), "numpy.ascontiguousarray"},
      {npy(dictionary("<f8", "()"), body), "0 dimensions"},
      {npy(dictionary("<f8", "(1, 2, 3)"), body), "3 dimensions"},
      {npy(dictionary("<f8", "(6, 0)"), body), "0 columns"},
      {npy(dictionary("<f8", "(-6,)"), body), "expected a length"},
      {npy(dictionary("<f8", "(6,)", "Maybe"), body), "expected True or False"},
      {npy("{'descr': '<f8', 'shape': (6,), }", body), "expected the keys descr, fortran_order and shape"},
      {npy("{'descr': '<f8', 'fortran_order': False, 'shape': (6,), 'x': 1}", body), "expected one of the keys"},
      {npy("{'descr': '<f8", body), "expected text in quotes"},
      {npy(dictionary("<f8", "(6,)") + "; import os", body), "expected nothing behind the dictionary"},
      {npy(dictionary("<f8", "(7,)"), body), "48 bytes behind its header, expected 56"},
      {npy(dictionary("<f8", "(7,)"), body), "truncated"},
      {npy(dictionary("<f8", "(5,)"), body), "not one array, or damaged"},
      {npy(dictionary("<f8", "(999999999999999999,)"), body), "cannot hold"},
      {npy(dictionary("<f8", "(1,)"), raw<double>({1})), "holds 1 sample, expected at least 2"},
  };
  for (const Case& c : cases) {
    auto strict = options(file("log.npy", c.bytes));
    strict.format = log::Format::npy;  // else the reader of other arrays takes some of them
    const std::string message = message_of<InputError>([&] { (void)log::read_log(strict); });
    EXPECT_CONTAINS(message, c.part);
    EXPECT_CONTAINS(message, "log.npy");
  }
}

TEST_F(BinaryLog, RawSizesMustBeWholeSamples) {
  std::string bytes = raw<double>(kValues);
  bytes.pop_back();
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(options(file("log.f64", bytes))); }),
                  "holds 47 bytes, expected a multiple of 8 (one number of 8 bytes a sample)");
  auto wide = options(file("log.f32", raw<float>(kValues)));
  wide.file_columns = 4;
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(wide); }),
                  "holds 24 bytes, expected a multiple of 16 (4 numbers of 4 bytes a sample)");
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(options(file("log.f64", ""))); }), "is empty");
}

TEST_F(BinaryLog, RateAndUnitMustBeGiven) {
  auto without = options(file("log.f64", raw<double>(kValues)));
  without.rate_hz.reset();
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(without); }), "--rate HZ");
  without = options(without.path);
  without.unit.reset();
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(without); }), "--unit deg/s");
  without = options(without.path);
  without.file_columns = 0;
  EXPECT_CONTAINS(message_of<std::invalid_argument>([&] { (void)log::read_log(without); }), "file_columns");
}

TEST_F(BinaryLog, NumPyIsKnownByItsContentUnlessAnotherFormatIsAskedFor) {
  const std::string bytes = npy(dictionary("<f8", "(6,)"), raw<double>(kValues));
  EXPECT_EQ(log::read_log(options(file("log.csv", bytes))).samples, 6);
  EXPECT_EQ(log::read_log(options(file("log.dat.gz", gzip(bytes)))).samples, 6);
  auto said = options(file("log.csv", bytes));
  said.format = Format::csv;
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(said); }), "--format npy");
}

// --- Writing --------------------------------------------------------------------------------------------------------

TEST_F(BinaryLog, WrittenFilesAreReadBackBitForBit) {
  std::vector<double> x, y;
  for (int i = 0; i < 40000; ++i) {  // more than one task
    x.push_back(std::sin(i) * 1e-3);
    y.push_back(std::nextafter(x.back(), 1));
  }
  const std::vector<log::LogColumn> columns{{"gyro_x", "rad/s", x}, {"gyro_y", "rad/s", y}};
  for (const Format format : {Format::npy, Format::f64}) {
    const std::string target = path("log." + std::string(log::name(format)));
    log::write_log(target, columns, 10, {}, format);
    auto read = options(target);
    read.unit = "rad/s";
    read.file_columns = format == Format::npy ? 1 : 2;
    const allan::Record record = log::read_log(read);
    EXPECT_EQ(record.axes[0].rate, x);
    EXPECT_EQ(record.axes[1].rate, y);
  }
}

TEST_F(BinaryLog, TheHeaderIsTheOneThatNumPyWrites) {
  const std::string target = path("log.npy");
  log::write_log(target, std::vector<log::LogColumn>{{"x", "rad/s", {1, 2}}}, 10, {}, Format::npy);
  // numpy.save of numpy.array([1., 2.]), NumPy 1.24
  const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
  std::string expected = prefix(1, 118) + header + std::string(117 - header.size(), ' ') + '\n' + raw<double>({1, 2});
  EXPECT_EQ(content(target), expected);
}

// --- Streams --------------------------------------------------------------------------------------------------------

std::vector<std::vector<double>> streamed(log::LogStream& log) {
  std::vector<std::vector<double>> all(log.columns().size()), piece;
  for (bool more = true; more;) {
    more = log.read(piece, std::chrono::milliseconds{1000}) != log::LogStream::Progress::end;
    for (std::size_t i = 0; i < all.size(); ++i) all[i].insert(all[i].end(), piece[i].begin(), piece[i].end());
  }
  return all;
}

TEST_F(BinaryLog, StreamsGiveWhatTheWholeLogGives) {
  std::string text = "# made by hand\ntime (s),gyro_x (deg/s),gyro_y (deg/s)\n";
  std::vector<double> values;
  for (int i = 0; i < 100000; ++i) {  // several megabytes: several pieces
    if (i % 1000 == 7) continue;      // a gap
    const std::string x = std::to_string(std::sin(i)), y = i % 501 == 0 ? "nan" : std::to_string(std::cos(i));
    text += std::to_string(i / 100) + "." + std::to_string(100 + i % 100).substr(1) + "," + x + "," + y + "\n";
    values.push_back(std::stod(x));
    values.push_back(std::stod(y));
  }
  auto binary = options(file("log.f64", raw<double>(values)));
  binary.file_columns = 2;
  for (const auto& read : {log::LogOptions{.path = file("log.csv", text)}, binary,
                           options(file("log.npy", npy(dictionary("<f8", "(99900, 2)"), raw<double>(values))))}) {
    const allan::Record whole = log::read_log(read);
    log::LogStream log(read);
    const auto all = streamed(log);
    EXPECT_NEAR(log.rate_hz() / whole.rate_hz, 1, 1e-9);
    EXPECT_EQ(log.missing_samples(), whole.missing_samples);
    ASSERT_EQ(all.size(), whole.axes.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      ASSERT_EQ(all[i].size(), whole.axes[i].rate.size());
      for (std::size_t k = 0; k < all[i].size(); ++k) {
        const double a = all[i][k], b = whole.axes[i].rate[k];
        ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << read.path << ' ' << k;
      }
    }
  }
}

/// So many seconds of 1 Hz, and behind them stamps that are each so much [s] later than the one before.
std::string with_gaps(int seconds, std::initializer_list<double> steps) {
  std::string text = "time (s),g (deg/s)\n";
  for (int i = 0; i < seconds; ++i) text += std::to_string(i) + ",1\n";
  double t = seconds - 1;
  for (const double step : steps) text += std::to_string(t += step) + ",1\n";
  return text;
}

// A gap that may be filled is handed out in pieces, one that may not is refused, however the gaps are cut.
TEST_F(BinaryLog, AStreamHoldsNoGapInMemory) {
  constexpr int kSeconds = 200'000;  // more than the block of text that is looked at first
  constexpr std::size_t kBlock = (std::size_t{1} << 20) / sizeof(double);
  constexpr std::int64_t kGap = 900'000;
  log::LogStream log({.path = file("a.csv", with_gaps(kSeconds, {kGap + 1}))});
  std::vector<std::vector<double>> rates;
  std::int64_t samples = 0;
  for (auto progress = log::LogStream::Progress::none; progress != log::LogStream::Progress::end;) {
    progress = log.read(rates, std::chrono::milliseconds{0});
    ASSERT_LE(rates.front().size(), kBlock);
    samples += static_cast<std::int64_t>(rates.front().size());
  }
  EXPECT_EQ(samples, kSeconds + kGap + 1);
  EXPECT_EQ(log.missing_samples(), kGap);
  EXPECT_EQ(log.numbers(), (std::vector<std::int64_t>{kSeconds + 1}));
  const double years = 3e9;
  for (const auto& steps : {std::initializer_list<double>{years}, {kGap, kGap}, {kGap, 1, 1, kGap}}) {
    log::LogStream refused({.path = file("b.csv", with_gaps(kSeconds, steps))});
    EXPECT_CONTAINS(message_of<InputError>([&] { (void)streamed(refused); }), "samples are missing by now");
  }
}

TEST_F(BinaryLog, AHeaderThatIsLongerThanAnyIsRefused) {
  const std::string dictionary = "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }";
  for (const std::uint32_t length : {1U << 17, 2U << 20, 0xfffffff0U}) {
    std::string bytes = std::string("\x93NUMPY\x02\x00", 8) +
                        std::string({static_cast<char>(length), static_cast<char>(length >> 8),
                                     static_cast<char>(length >> 16), static_cast<char>(length >> 24)}) +
                        dictionary;
    bytes.resize(bytes.size() + (3U << 20), ' ');
    const auto read = options(file("long.npy", bytes));
    EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log(read); }), "expected at most 65536");
    EXPECT_CONTAINS(message_of<InputError>([&] { log::LogStream log(read); }), "expected at most 65536");
  }
}

TEST_F(BinaryLog, StreamsRefuseWhatTheyCannotRead) {
  const auto refused = [&](const log::LogOptions& read) {
    return message_of<InputError>([&] {
      log::LogStream log(read);
      (void)streamed(log);
    });
  };
  EXPECT_CONTAINS(refused(options(file("a.f64", raw<double>(kValues) + "x"))), "a multiple of 8");
  EXPECT_CONTAINS(refused(options(file("b.npy", npy(dictionary("<f8", "(7,)"), raw<double>(kValues))))), "truncated");
  EXPECT_CONTAINS(refused(options(file("c.npy", "\x93NUM"))), "inside the header");
  EXPECT_CONTAINS(refused({.path = file("d.csv", "\x1f\x8b\x08 and so on")}), "zcat");
  EXPECT_CONTAINS(refused({.path = file("e.csv", "")}), "is empty");
  EXPECT_CONTAINS(refused({.path = path("absent.csv")}), "No such file");
  EXPECT_CONTAINS(refused({.path = file("f.csv", "time (s),g (deg/s)\n0,1\n1,1\n2,1\n1.5,1\n")}), "f.csv:5:1");
  std::string back = "time (s),g (deg/s)\n";
  for (int i = 0; i < 300000; ++i) back += std::to_string(i) + ",1\n";
  EXPECT_CONTAINS(refused({.path = file("g.csv", back + "7,1\n")}), "g.csv:300002:1: the time column 'time' goes back");
  EXPECT_CONTAINS(refused({.path = file("h.csv", back + "9e8,1\n")}), "jumps by");
  EXPECT_CONTAINS(refused({.path = file("i.csv", back + "300000,one\n")}), "i.csv:300002:8");
  EXPECT_CONTAINS(refused({.path = file("k.csv", "time (s),g (deg/s)\n0,1\n")}), "holds 1 row with a time");
  auto angle = options(file("j.f64", raw<double>(kValues)));
  angle.input = log::Input::angle;
  EXPECT_CONTAINS(message_of<std::invalid_argument>([&] { log::LogStream log(angle); }), "rates or increments");
}

}  // namespace
}  // namespace gyrobudget::app_tests
