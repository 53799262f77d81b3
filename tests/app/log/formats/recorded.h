// SPDX-License-Identifier: MIT
// What tests of recordings do alike.
#pragma once

#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/text/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "../../temporary.h"

namespace gyrobudget::app_tests {

/// Little-endian bytes of numbers, one behind the other.
template <class... Numbers>
std::string packed(Numbers... numbers) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return bytes;
}

/// Text that takes so many bytes.
inline std::string padded(std::string text, std::size_t size) {
  text.resize(size, '\0');
  return text;
}

inline std::size_t stream_named(const log::Recording& recording, const std::string& name) {
  for (std::size_t i = 0; i < recording.streams().size(); ++i)
    if (recording.streams()[i].name == name) return i;
  std::string all;
  for (const log::StreamInfo& stream : recording.streams()) all += stream.name + ", ";
  throw std::runtime_error("no stream " + name + " among " + all);
}

inline std::size_t field_named(const log::StreamInfo& stream, const std::string& name) {
  for (std::size_t i = 0; i < stream.fields.size(); ++i)
    if (stream.fields[i].name == name) return i;
  throw std::runtime_error("no field " + name + " in " + stream.name);
}

inline log::Rows read(const log::Recording& recording, const std::string& stream,
                      const std::vector<std::string>& fields) {
  const std::size_t place = stream_named(recording, stream);
  std::vector<std::size_t> places;
  for (const std::string& field : fields) places.push_back(field_named(recording.streams()[place], field));
  return recording.read(place, places);
}

inline const log::Field& field(const log::Recording& recording, const std::string& stream, const std::string& name) {
  const log::StreamInfo& info = recording.streams()[stream_named(recording, stream)];
  return info.fields[field_named(info, name)];
}

inline const log::StreamInfo& info(const log::Recording& recording, const std::string& stream) {
  return recording.streams()[stream_named(recording, stream)];
}

inline double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

inline double deviation(const std::vector<double>& values) {
  const double m = mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - m) * (v - m);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

/// As many columns as there are numbers, to the digits that are printed: nine of means and six of deviations.
inline void expect_statistics(const log::Rows& rows, const std::vector<double>& means,
                              const std::vector<double>& deviations) {
  ASSERT_EQ(rows.columns.size(), means.size());
  constexpr double kMeanDigits = 6e-9, kDeviationDigits = 6e-6;
  for (std::size_t i = 0; i < means.size(); ++i) {
    EXPECT_NEAR(mean(rows.columns[i]), means[i], kMeanDigits * std::abs(means[i])) << i;
    if (!deviations.empty()) {
      EXPECT_NEAR(deviation(rows.columns[i]), deviations[i], kDeviationDigits * deviations[i]) << i;
    }
  }
}

inline void expect_note(const std::vector<std::string>& notes, const std::string& part) {
  EXPECT_THAT(notes, testing::Contains(testing::HasSubstr(part)));
}

/// Reads all of a recording, and looks at what a reader promises. @returns rows in all
inline std::int64_t read_all(const log::Recording& recording) {
  std::int64_t rows = 0;
  for (std::size_t i = 0; i < recording.streams().size(); ++i) {
    const log::StreamInfo& stream = recording.streams()[i];
    std::vector<std::size_t> fields(stream.fields.size());
    std::iota(fields.begin(), fields.end(), std::size_t{0});
    const log::Rows read = recording.read(i, fields);
    const std::size_t count = stream.clock.empty() ? static_cast<std::size_t>(stream.count) : read.stamps_ns.size();
    EXPECT_LE(count, static_cast<std::size_t>(stream.count));
    for (const auto& column : read.columns) {
      EXPECT_EQ(column.size(), count) << stream.name;
      for (const double v : column) EXPECT_FALSE(std::isinf(v));
    }
    rows += static_cast<std::int64_t>(count);
  }
  return rows;
}

/// Bytes of memory at the peak of some work, beyond those before; below 0 where the system does not tell.
template <class Work>
double peak_bytes(const Work& work) {
  const auto peak = [] {
    std::ifstream status("/proc/self/status");
    constexpr double kKilobyte = 1024;
    for (std::string line; std::getline(status, line);)
      if (line.rfind("VmHWM:", 0) == 0) return kKilobyte * std::stod(line.substr(6));
    return 0.;
  };
  {
    std::ofstream reset("/proc/self/clear_refs");
    reset << "5" << std::flush;
    if (!reset) return -1;
  }
  const double before = peak();
  work();
  return peak() - before;
}

/// Reads all fields of a stream in no more than so many times the memory of its numbers, and what blocks take.
inline void expect_little_memory(const std::string& path, const std::string& stream, double most = 1.1) {
  double kept = 0;
  const double peak = peak_bytes([&] {
    const auto recording = log::open_recording(path);
    const std::size_t place = stream_named(*recording, stream);
    std::vector<std::size_t> fields(recording->streams()[place].fields.size());
    std::iota(fields.begin(), fields.end(), std::size_t{0});
    const log::Rows rows = recording->read(place, fields);
    kept = 8. * static_cast<double>(rows.stamps_ns.size() + rows.columns.size() * rows.columns.front().size());
  });
  constexpr double kBlocks = 8 << 20;
  EXPECT_GT(kept, kBlocks);
  EXPECT_LT(peak, most * kept + kBlocks) << kept;
}

/// A test with files of its own, and the real ones.
class RecordingTest : public TemporaryFolder {
 protected:
  [[nodiscard]] std::unique_ptr<log::Recording> open(const std::string& bytes, const std::string& name = "log") const {
    auto recording = log::open_recording(file(name, bytes));
    if (!recording) throw std::runtime_error("no recording");
    return recording;
  }
  [[nodiscard]] std::string refusal(const std::string& bytes, const std::string& name = "log") const {
    return message_of<text::InputError>([&] { read_all(*open(bytes, name)); });
  }
  /// A file of the real ones; empty where they are not there.
  static std::string real(const std::string& name) {
    const std::string path = std::string(GYROBUDGET_DATA) + "/logs/" + name;
    return std::filesystem::exists(path) ? path : "";
  }
  /// Cut at every hundredth of its length, a recording ends in a message, or in what is there.
  void cut_everywhere(const std::string& bytes) const {
    std::int64_t most = 0;
    for (std::size_t percent = 1; percent <= 100; ++percent) {
      const std::string path = file("cut", bytes.substr(0, bytes.size() * percent / 100));
      std::int64_t rows = 0;
      try {
        const auto recording = log::open_recording(path);
        if (recording) rows = read_all(*recording);
      } catch (const text::InputError& error) {
        EXPECT_EQ(std::string(error.what()).rfind(path, 0), 0U) << error.what();
      }
      most = std::max(most, rows);
      if (percent == 100) {
        EXPECT_EQ(rows, most);  // the whole has more than any part
        EXPECT_GT(rows, 0);
      }
    }
  }
};

#define SKIP_WITHOUT(path) \
  if ((path).empty()) GTEST_SKIP() << "no real recordings in " << GYROBUDGET_DATA << "/logs; set GYROBUDGET_DATA"

}  // namespace gyrobudget::app_tests
