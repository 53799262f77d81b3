// SPDX-License-Identifier: MIT
// How long reading six axes of a recording of sensor_msgs/Imu takes beside only reading the bytes of its file, and how
// much memory it needs beside the numbers kept. They alternate in one run: what disturbs the machine disturbs all.
//
//     recording_benchmark [messages, 300000] [repetitions, 7] [folder for the files, the system's temporary one]
#include "gyrobudget/app/log/bytes.h"
#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/noise/normal.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "../app/log/recording_writer.h"

namespace {

using namespace gyrobudget;
using namespace recording_writer;

constexpr std::size_t kChunk = std::size_t{768} << 10;  // of records, as rosbag has it
constexpr std::size_t kAxes = 6;

Stamp stamp_at(std::size_t i) {
  constexpr std::size_t kRate = 100;
  return {static_cast<std::uint32_t>(1'700'000'000 + i / kRate),
          static_cast<std::uint32_t>(i % kRate) * std::uint32_t{10'000'000}};
}

/// White noise, rounded to microunits as drivers that count give it.
ImuNumbers noisy(std::size_t i) {
  ImuNumbers numbers = imu_numbers(0);
  std::array<double, kAxes> noise;
  noise::fill_normal({1, 1}, kAxes * i, noise);
  for (std::size_t k = 0; k < 3; ++k) {
    numbers[13 + k] = std::round(noise[k] * 1e6) / 1e6;
    numbers[25 + k] = std::round(noise[3 + k] * 1e6) / 1e6;
  }
  return numbers;
}

std::string bag(const std::string& how, std::size_t messages) {
  BagWriter writer;
  writer.connection(0, "/imu", "sensor_msgs/Imu");
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < messages; ++i) {
    const std::string message = ros1_imu(stamp_at(i), noisy(i));
    writer.message(0, stamp_at(i), message);
    bytes += message.size();
    if (bytes < kChunk && i + 1 < messages) continue;
    writer.end_chunk(how);
    bytes = 0;
  }
  return writer.closed();
}

std::string mcap(const std::string& how, std::size_t messages) {
  McapWriter writer;
  writer.declare(mcap_schema(1, "sensor_msgs/msg/Imu"));
  writer.declare(mcap_channel(1, 1, "/imu", "cdr"));
  for (std::size_t i = 0; i < messages; ++i) {
    writer.message(1, static_cast<std::uint64_t>(ns(stamp_at(i))), Cdr{}.imu(stamp_at(i), noisy(i)));
    if (writer.chunk().size() < kChunk && i + 1 < messages) continue;
    const auto crc = ::crc32_z(0, reinterpret_cast<const Bytef*>(writer.chunk().data()), writer.chunk().size());
    writer.end_chunk(how, static_cast<std::uint32_t>(crc));
  }
  return writer.closed();
}

/// Adds up the bytes, eight at a time, piece by piece.
std::uint64_t read_bytes(const std::string& path) {
  constexpr std::size_t kPiece = std::size_t{4} << 20;
  const log::Bytes bytes(path, log::Content::bytes);
  std::uint64_t sum = 0;
  for (std::size_t at = 0; at < bytes.text().size(); at += kPiece) {
    const std::string_view piece = bytes.text().substr(at, kPiece);
    for (std::size_t i = 0; i + sizeof sum <= piece.size(); i += sizeof sum) {
      std::uint64_t word = 0;
      std::memcpy(&word, piece.data() + i, sizeof word);
      sum += word;
    }
    bytes.release(piece);
  }
  return sum;
}

log::Rows read_axes(const std::string& path) {
  const auto recording = log::open_recording(path);
  std::vector<std::size_t> fields;
  for (const char* vector : {"angular_velocity.", "linear_acceleration."}) {
    for (std::size_t i = 0; i < recording->streams().at(0).fields.size(); ++i) {
      if (recording->streams()[0].fields[i].name.starts_with(vector)) fields.push_back(i);
    }
  }
  return recording->read(0, fields);
}

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// Runs `work` in a process of its own, whose memory goes with it. @returns its peak memory in bytes
double in_a_process(const std::function<void()>& work) {
  std::fflush(nullptr);  // or the child would print again what is waiting
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    work();
    std::fflush(nullptr);
    ::_exit(0);
  }
  rusage usage = {};
  int status = 0;
  if (::wait4(child, &status, 0, &usage) != child || status != 0) throw std::runtime_error("the process failed");
  return static_cast<double>(usage.ru_maxrss) * 1024;
}

void compare(const std::string& name, const std::string& path, std::size_t messages, int repetitions) {
  const double before = in_a_process([] {});
  const double peak = in_a_process([&] { static_cast<void>(read_axes(path)); });
  std::vector<double> bytes_s, read_s, ratios;
  std::uint64_t sum = 0;
  for (int i = 0; i < repetitions; ++i) {
    bytes_s.push_back(seconds([&] { sum += read_bytes(path); }));
    read_s.push_back(seconds([&] {
      if (read_axes(path).stamps_ns.size() != messages) throw std::runtime_error("messages are missing");
    }));
    ratios.push_back(read_s.back() / bytes_s.back());
  }
  const double kept = static_cast<double>(messages * (kAxes + 1) * sizeof(double));
  fmt::print(
      "{:<10} {:7.1f} MB  bytes {:6.1f} ms  read {:6.1f} ms, {:4.0f} ns a message, {:.2f} times  memory {:.2f} of the numbers kept{}\n",
      name, static_cast<double>(std::filesystem::file_size(path)) / 1e6, 1e3 * median(bytes_s), 1e3 * median(read_s),
      1e9 * median(read_s) / static_cast<double>(messages), median(ratios), (peak - before) / kept,
      sum == 0 ? " " : "");
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t messages = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 300'000;
  const int repetitions = argc > 2 ? std::atoi(argv[2]) : 7;
  const std::filesystem::path folder = argc > 3 ? argv[3] : std::filesystem::temp_directory_path();
  const std::string path = folder / "gyrobudget_recording_benchmark";
  const auto measure = [&](const std::string& name, const std::function<std::string()>& write) {
    in_a_process([&] { std::ofstream(path, std::ios::binary) << write(); });
    in_a_process([&] { compare(name, path, messages, repetitions); });
    std::filesystem::remove(path);
  };
  for (const char* how : {"none", "lz4", "bz2"}) {
    measure(fmt::format("bag {}", how), [&] { return bag(how, messages); });
  }
  for (const char* how : {"", "lz4", "zstd"}) {
    measure(fmt::format("mcap {}", *how ? how : "none"), [&] { return mcap(how, messages); });
  }
}
