// SPDX-License-Identifier: MIT
// Readers of logs: whole, in pieces, as they come.
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/stream.h"
#include "gyrobudget/app/text/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "entries.h"
#include "memory_file.h"

namespace gyrobudget::fuzz {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;  ///< of an input that is worth its time

log::LogOptions options_of(std::uint8_t choice) {
  constexpr log::Input kInputs[] = {log::Input::rate, log::Input::increment, log::Input::angle};
  log::LogOptions options;
  if (choice & 1) options.rate_hz = 100;
  if (choice & 2) options.unit = "deg/s";
  if (choice & 4) options.columns = {"2"};
  if (choice & 8) options.scale = 0.01;
  options.input = kInputs[(choice >> 4) % 3];
  if (options.input == log::Input::angle && options.unit) options.unit = "rad";
  return options;
}

struct Reading {
  std::optional<allan::Record> record;
  std::string message;  ///< where there is none
};

Reading read(log::LogOptions options, std::size_t chunk_bytes) {
  options.chunk_bytes = chunk_bytes;
  try {
    return {log::read_log(options), {}};
  } catch (const text::InputError& error) {
    return {std::nullopt, error.what()};
  }
}

void check(const allan::Record& record) {
  promise(std::isfinite(record.rate_hz) && record.rate_hz > 0, "the rate is no rate");
  promise(!record.axes.empty(), "there is no axis");
  promise(record.missing_samples >= 0 && record.missing_samples <= record.samples, "missing samples");
  for (const allan::Axis& axis : record.axes) {
    promise(static_cast<std::int64_t>(axis.rate.size()) == record.samples, "an axis has another length");
  }
}

bool same(const allan::Record& a, const allan::Record& b) {
  if (a.axes.size() != b.axes.size() || a.samples != b.samples || a.notes != b.notes) return false;
  for (std::size_t i = 0; i < a.axes.size(); ++i) {
    for (std::size_t k = 0; k < a.axes[i].rate.size(); ++k) {
      const double x = a.axes[i].rate[k], y = b.axes[i].rate[k];
      if (!(std::isnan(x) && std::isnan(y)) && std::bit_cast<std::uint64_t>(x) != std::bit_cast<std::uint64_t>(y)) {
        return false;
      }
    }
  }
  return true;
}

void read_log(std::string_view bytes) {
  if (bytes.empty()) return;
  log::LogOptions options = options_of(static_cast<std::uint8_t>(bytes.front()));
  const MemoryFile file(bytes.substr(1));
  options.path = file.path();
  constexpr std::size_t kUsual = std::size_t{1} << 20, kTiny = 37;
  const Reading whole = read(options, kUsual), cut = read(options, kTiny);
  promise(whole.message == cut.message, "the message depends on the chunks");
  promise(whole.record.has_value() || !whole.message.empty(), "an error without a message");
  if (!whole.record) return;
  check(*whole.record);
  promise(same(*whole.record, *cut.record), "the record depends on the chunks");
}

/// Clocks that are asked for, rows by a word, and a log that is joined to itself.
void read_clock(std::string_view bytes) {
  if (bytes.empty()) return;
  const auto choice = static_cast<std::uint8_t>(bytes.front());
  const MemoryFile file(bytes.substr(1));
  log::LogOptions options{.path = file.path(), .rate_hz = 100, .unit = "deg/s"};
  if (choice & 1) options.rate_hz.reset();
  if (choice & 2) options.unit.reset();
  if (choice & 4) options.with = {{file.path(), "m/s^2"}};
  if (choice & 8) options.rows = log::RowsOf{"2", 0, "a"};
  const std::size_t unit = choice >> 4;
  if (unit < log::kTimeUnitNames.size()) options.time = log::TimeOf{"1", std::string(log::kTimeUnitNames[unit])};
  if (unit == 8) options.time = log::TimeOf{"1+2"};
  if (unit == 9) options.time = log::TimeOf{"none"};
  if (options.time && options.time->unit == "counter") options.rate_hz = 100;
  const Reading reading = read(options, 1 << 20);
  promise(reading.record.has_value() || !reading.message.empty(), "an error without a message");
  if (reading.record) check(*reading.record);
}

/// The first byte chooses among .npy and raw numbers.
void read_binary(std::string_view bytes) {
  if (bytes.empty()) return;
  constexpr log::Format kFormats[] = {log::Format::npy, log::Format::f32, log::Format::f64};
  const auto choice = static_cast<std::uint8_t>(bytes.front());
  const MemoryFile file(bytes.substr(1));
  log::LogOptions options{.path = file.path(), .rate_hz = 100, .unit = "deg/s"};
  options.format = kFormats[(choice & 3) % 3];
  if (choice & 4) options.columns = {"2"};
  if (options.format != log::Format::npy) options.file_columns = 1 + (choice >> 4);
  const Reading reading = read(options, 1 << 20);
  promise(reading.record.has_value() || !reading.message.empty(), "an error without a message");
  if (reading.record) check(*reading.record);
}

/// A log in segments, or resampled.
void read_cut(std::string_view bytes) {
  if (bytes.empty()) return;
  log::LogOptions options = options_of(static_cast<std::uint8_t>(bytes.front()));
  const MemoryFile file(bytes.substr(1));
  options.path = file.path();
  if (bytes.front() & 64) options.resample_hz = 2;
  try {
    for (const allan::Record& segment : log::read_segments(options, 5)) check(segment);
  } catch (const text::InputError&) {
  }
}

/// A log that is resampled, at a rate that the first byte chooses.
void read_resampled(std::string_view bytes) {
  if (bytes.empty()) return;
  constexpr double kRates_hz[] = {1e-3, 1, 7.5, 1e4};
  const auto choice = static_cast<std::uint8_t>(bytes.front());
  const MemoryFile file(bytes.substr(1));
  log::LogOptions options{.path = file.path(), .unit = "deg/s", .resample_hz = kRates_hz[choice & 3]};
  if (choice & 4) options.unit.reset();
  if (choice & 8) options.input = log::Input::increment;
  if (choice & 16) options.time = log::TimeOf{"1", "ns"};
  const Reading reading = read(options, 1 << 20);
  promise(reading.record.has_value() || !reading.message.empty(), "an error without a message");
  if (!reading.record) return;
  check(*reading.record);
  promise(reading.record->rate_hz == options.resample_hz, "a rate that was not asked for");
}

/// Everything of a stream, and its message where it ends in one.
std::string follow(const log::LogOptions& options) {
  constexpr std::int64_t kAlwaysFilled = 1'000'000;  // samples that a stream puts into gaps whatever it holds
  try {
    log::LogStream log(options);
    promise(std::isfinite(log.rate_hz()) && log.rate_hz() > 0, "the rate is no rate");
    std::vector<std::vector<double>> rates;
    std::int64_t samples = 0, numbers = 0;
    for (auto progress = log::LogStream::Progress::none; progress != log::LogStream::Progress::end;) {
      progress = log.read(rates, std::chrono::milliseconds{0});
      promise(rates.size() == log.columns().size(), "a column is missing");
      for (const auto& column : rates) promise(column.size() == rates.front().size(), "a column has another length");
      samples += static_cast<std::int64_t>(rates.front().size());
    }
    for (const std::int64_t column : log.numbers()) numbers = std::max(numbers, column);
    promise(log.missing_samples() <= samples && numbers <= samples, "more than there are");
    promise(samples <= 2 * kAlwaysFilled + 2 * static_cast<std::int64_t>(kMostBytes), "more than the file can hold");
  } catch (const text::InputError& error) {
    promise(error.what()[0] != '\0', "an error without a message");
    return error.what();
  }
  return {};
}

/// The first byte chooses the options and whether it is text, .npy or raw numbers.
void read_stream(std::string_view bytes) {
  if (bytes.empty() || bytes.size() > kMostBytes) return;
  const auto choice = static_cast<std::uint8_t>(bytes.front());
  log::LogOptions options = options_of(choice & 15);
  constexpr log::Format kFormats[] = {log::Format::csv, log::Format::npy, log::Format::f32, log::Format::f64};
  options.format = kFormats[choice >> 6];
  if (choice & 16) options.input = log::Input::increment;
  if (options.format != log::Format::csv) options.rate_hz = 100, options.unit = choice & 16 ? "rad" : "deg/s";
  const MemoryFile file(bytes.substr(1));
  options.path = file.path();
  follow(options);
}

/// A pipe gives what the same bytes give as a file.
void read_pipe(std::string_view bytes) {
  constexpr std::size_t kHeld = 1 << 16;  // by a pipe that nobody reads yet
  if (bytes.empty() || bytes.size() > kHeld) return;
  log::LogOptions options = options_of(static_cast<std::uint8_t>(bytes.front()));
  const std::string_view content = bytes.substr(1);
  const MemoryFile file(content);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const bool written = ::write(ends[1], content.data(), content.size()) == ssize_t(content.size());
  ::close(ends[1]);
  options.path = "/proc/self/fd/" + std::to_string(ends[0]);
  const Reading piped = read(options, 1 << 20);
  ::close(ends[0]);
  options.path = file.path();
  const Reading whole = read(options, 1 << 20);
  promise(written, "a pipe that holds less than its size");
  promise(piped.record.has_value() == whole.record.has_value(), "a pipe is read otherwise than a file");
  promise(piped.record.has_value() || !piped.message.empty(), "an error without a message");
  if (piped.record) promise(same(*piped.record, *whole.record), "a pipe gives other numbers than a file");
}

/// A .npy of version 1 with this header and so many bytes behind it.
std::string npy(std::string header, std::size_t bytes) {
  header.resize((10 + header.size() + 64) / 64 * 64 - 10, ' ');
  header.back() = '\n';
  std::string text = "\x93NUMPY\x01";
  text += '\0';
  text += static_cast<char>(header.size() & 0xff);
  text += static_cast<char>(header.size() >> 8);
  return text + header + std::string(bytes, '@');
}

/// Two stretches at 10 Hz, the second one beginning so many seconds behind the first one's start.
std::string two_stretches(int rows, int start) {
  std::string text = "t (s),w (deg/s)\n";
  for (int i = 0; i < 2 * rows; ++i) text += std::to_string((i < rows ? 0 : start) + 0.1 * (i % rows)) + ",1\n";
  return text;
}

/// A clock that jumps by this [s] at its end, and by less before.
std::string gaps(double last) {
  std::string text = "t (s),w (deg/s)\n";
  for (int i = 0; i < 120; ++i) text += std::to_string(i * 0.01 + (i > 60 ? 7.0 : 0.0)) + ",1\n";
  return text + std::to_string(last) + ",2\n";
}

}  // namespace

std::vector<Entry> log_entries() {
  const std::string uneven = "t (s),w (deg/s)\n0,1\n0.4,2\n0.9,1\n1.7,3\n2.1,1\n2.2,2\n3.9,1\n4.4,2\n5,1\n";
  const std::string stamps =
      "1700000000000000000,1\n1700000000300000000,2\n1700000000900000000,3\n1700000002100000000,1\n";
  return {
      {"log",
       read_log,
       {with_options(
            0, "time (s),gyro_x (deg/s),acc_x (m/s^2)\n0.00,0.25,-9.81\n0.01,-1.5e-3,nan\n0.02,3,9.8\n0.03,4,1\n"),
        with_options(0,
                     "#timestamp [ns],w_RS_S_x [rad s^-1]\n1403636579758555392,-0.099134701513277898\n"
                     "1403636579763555584,0.1\n1403636579768555520,0.2\n1403636579773555456,0.3\n"),
        with_options(3, "# a comment\r\n1 2  3\r\n4\t5 6\r\n\r\n7 8 9\r\n"),
        with_options(3, "0,1;0,2\n-0,3;0,4\n0,5;0,1\n"),
        with_options(0, "\xef\xbb\xbft;w (rad/s)\n0;1,5\n0,1;-2,5e1\n0,2;3\n0,2;4\n0,5;4\n"),
        with_options(17, "\"x (deg)\",\"y (rad)\"\n\"1\",\"4\"\n\"2\",\"5\"\n\"3\",\"6\"\n"),
        with_options(35, "x\n0.1\n6.2\n0.3\n\n0.2\n12345678901234567890\n1e308\n"),
        with_options(0, "secs,nsecs,gyro_x (deg/s)\n1,0,1\n1,500000000,2\n2,0,3\n2,500000000,4\n"),
        with_options(2, "\x1f\x8b\x08")}},
      {"clock",
       read_clock,
       {with_options(240, "Sensor: LSM6\nVendor: x\nstamp [ms]; gx [deg/s]\n1; 0.5;\n11; 0.25;\n21; 1;\n31; 2;\n"),
        with_options(240, "GYROFLOW IMU LOG\ntscale,0.001\ngscale,0.5\nt,gx,gy,gz\n0,1,2,3\n2,2,1,2\n4,3,2,1\n"),
        with_options(241,
                     "sep=;\ndate;time;gx (deg/s)\n2024-03-05;23:59:59.9;1\n2024-03-06;00:00:00.0;2\n"
                     "2024-03-06;00:00:00.1;1\n"),
        with_options(64, "2024-03-05T09:14:22.005Z,1\n2024-03-05T09:14:22.015Z,2\n2024-03-05T09:14:22.025Z,1\n"),
        with_options(96, "count,gx\n253,1\n254,2\n255,1\n0,2\n1,1\n3,2\n4,1\n5,2\n6,1\n"),
        with_options(131, "2290,604799.99,gx (deg/s)\n2291,0,1\n2291,0.01,2\n"),
        with_options(244, "time (ms),x (deg/s)\n0,1\n10,2\n20,1\n30,2\n"),
        with_options(248, "1,a,3\n2,b,4\n3,a,5\n4,b,6\n"),
        with_options(240, "UTC_Hour,UTC_Minute,UTC_Second,gx (deg/s)\n23,59,58,1\n23,59,59,2\n0,0,0,1\n"),
        with_options(240,
                     "$VNIMU,-00.20,+00.11,+00.44,-00.031,+00.052,-09.797,+000.001,-000.003,+0.8,+31.4,+98.7*60\n"
                     "$VNIMU,-00.20,+00.11,+00.44,-00.029,+00.055,-09.801,+000.002,-000.003,+0.7,+31.4,+98.7*6D\n")}},
      {"binary",
       read_binary,
       {with_options(0, npy("{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }", 24)),
        with_options(4, npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", 24)),
        with_options(0, npy("{'shape': (99999999999999999999,), 'descr': '<f8', 'fortran_order': True}", 8)),
        with_options(17, std::string(16, 'x')), with_options(2, std::string(24, '\x7f'))}},
      {"segments",
       read_cut,
       {with_options(0, two_stretches(40, 100)), with_options(64, two_stretches(40, 100)),
        with_options(80, two_stretches(33, -5)), with_options(3, "1\nnan\n2\n")}},
      {"resample",
       read_resampled,
       {with_options(1, uneven), with_options(6, uneven), with_options(17, stamps), with_options(10, uneven)}},
      {"stream",
       read_stream,
       {with_options(0, two_stretches(60, 7)), with_options(0, gaps(3e8)), with_options(0, gaps(60)),
        with_options(3, "# x\n1 2\n3 4\n5 nan\n"), with_options(16, uneven),
        with_options(64, npy("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 1), }", 24)),
        with_options(128, std::string(16, 'x')), with_options(192, std::string(24, '\x7f'))}},
      {"pipe",
       read_pipe,
       {with_options(0, uneven), with_options(0, two_stretches(20, 3)), with_options(3, "0,1;0,2\n0,5;0,1\n"),
        with_options(2, "\x1f\x8b\x08"),
        with_options(0, "Sensor: LSM6\nVendor: x\nstamp [ms]; gx [deg/s]\n1; 0.5;\n11; 0.25;\n21; 1;\n31; 2;\n")},
       400}};
}

}  // namespace gyrobudget::fuzz
