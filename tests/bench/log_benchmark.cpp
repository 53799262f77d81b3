// SPDX-License-Identifier: MIT
// How long read_log and the whole `gyrobudget calibrate` take beside only parsing the numbers of the same file, and how
// much memory they need beside the numbers as doubles. They alternate in one run: what disturbs the machine disturbs
// all.
//
//     log_benchmark [hours, 10] [repetitions, 7] [folder for the log, the system's temporary one]
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/noise/normal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace gyrobudget;

constexpr double kRate = 100;
constexpr std::size_t kColumns = 7;  // time and six axes

/// Six axes of white noise, rounded as loggers round: about 11 characters a number.
void write_six_axes(const std::string& path, double hours) {
  const auto samples = static_cast<std::size_t>(hours * 3600 * kRate);
  std::vector<log::LogColumn> columns;
  for (const char* name : {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"}) {
    const bool gyro = name[0] == 'g';
    std::vector<double> values(samples);
    noise::fill_normal({1, columns.size()}, 0, values);
    const double sigma = gyro ? 4e-4 : 4e-3;
    const double digits = gyro ? 1e9 : 1e8;
    for (double& v : values) v = std::round(v * sigma * digits) / digits;
    columns.push_back({name, gyro ? "rad/s" : "m/s^2", std::move(values)});
  }
  log::write_log(path, columns, kRate);
}

/// Runs `work` in a process of its own. @returns its peak memory in bytes
double peak_memory(const std::function<void()>& work) {
  std::fflush(nullptr);  // or the child would print again what is waiting
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    try {
      work();
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      std::_Exit(1);
    }
    std::_Exit(0);
  }
  int status = 0;
  rusage usage = {};
  ::wait4(child, &status, 0, &usage);
  if (status != 0) throw std::runtime_error("the measured process failed");
  return static_cast<double>(usage.ru_maxrss) * 1024;
}

/// The least that reading can be: the file mapped, every field through std::from_chars, on all cores.
double sum_of_fields(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(path));
  const char* data = static_cast<const char*>(::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0));
  ::close(descriptor);
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  const auto line_start = [&](std::size_t at) {
    while (at < size && at > 0 && data[at - 1] != '\n') ++at;
    return at;
  };
  using Range = tbb::blocked_range<std::size_t>;
  const auto parse = [&](const Range& chunks, double sum) {
    for (std::size_t i = chunks.begin(); i != chunks.end(); ++i) {
      const char* at = data + line_start(i * kChunk);
      const char* end = data + line_start(std::min((i + 1) * kChunk, size));
      while (at < end) {
        double value = 0;
        const auto [stop, error] = std::from_chars(at, end, value);
        sum += value;
        at = stop + 1;  // the delimiter
      }
    }
    return sum;
  };
  const double sum = tbb::parallel_reduce(Range(0, (size + kChunk - 1) / kChunk, 1), 0.0, parse, std::plus<>());
  ::munmap(const_cast<char*>(data), size);
  return sum;
}

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Ratios of measurements made one behind the other.
void print_ratio(const char* what, const std::vector<double>& times, const std::vector<double>& base) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < times.size(); ++i) ratios.push_back(times[i] / base[i]);
  const auto [least, most] = std::ranges::minmax(ratios);
  fmt::print("{}: {:.3f} s, {:.2f} x only parsing, from {:.2f} to {:.2f}\n", what, median(times), median(ratios), least,
             most);
}

void run(double hours, int repetitions, const std::filesystem::path& folder) {
  const std::string path = (folder / fmt::format("gyrobudget-log-benchmark-{}.csv", ::getpid())).string();
  peak_memory([&] { write_six_axes(path, hours); });
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  const double numbers = hours * 3600 * kRate * kColumns * sizeof(double);
  fmt::print("six axes, {:g} h at {:g} Hz: {:.0f} MB of text, {:.0f} MB of doubles\n", hours, kRate, bytes / 1e6,
             numbers / 1e6);

  const double memory = peak_memory([&] { (void)log::read_log({.path = path}); });
  fmt::print("peak memory of read_log: {:.0f} MB, {:.2f} x the numbers as doubles\n", memory / 1e6, memory / numbers);

  const auto calibrate = [&] {
    ::execl(GYROBUDGET_PROGRAM, GYROBUDGET_PROGRAM, "calibrate", path.c_str(), "--json", "--quiet", nullptr);
  };
  const auto silent = [&] {
    if (std::freopen("/dev/null", "w", stdout) != nullptr) calibrate();
    std::_Exit(1);
  };
  std::vector<double> parsing, reading, calibrating;
  double sum = 0, whole_memory = 0;
  for (int i = 0; i < repetitions; ++i) {
    parsing.push_back(seconds([&] { sum += sum_of_fields(path); }));
    reading.push_back(seconds([&] { sum += log::read_log({.path = path}).axes[0].rate[0]; }));
    calibrating.push_back(seconds([&] { whole_memory = peak_memory(silent); }));
  }
  std::filesystem::remove(path);
  fmt::print("peak memory of the whole calibrate: {:.0f} MB, {:.2f} x the numbers as doubles\n", whole_memory / 1e6,
             whole_memory / numbers);
  fmt::print("only parsing {:.3f} s (median of {})\n", median(parsing), repetitions);
  print_ratio("read_log", reading, parsing);
  print_ratio("the whole calibrate, six axes", calibrating, parsing);
  if (!std::isfinite(sum)) fmt::print("the sum of all fields is {}\n", sum);  // nothing was optimised away
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const double hours = count > 1 ? std::atof(arguments[1]) : 10;
    const int repetitions = count > 2 ? std::atoi(arguments[2]) : 7;
    if (!(hours > 0) || repetitions < 1)
      throw std::invalid_argument("usage: log_benchmark [hours] [repetitions] [folder]");
    run(hours, repetitions, count > 3 ? arguments[3] : std::filesystem::temp_directory_path());
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
