// SPDX-License-Identifier: MIT
// Recordings that tests write, open and look at.
#pragma once

#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/text/error.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "../temporary.h"
#include "recording_writer.h"

namespace gyrobudget::app_tests {

/// The place of a field; a failure where there is none.
inline std::size_t field(const log::StreamInfo& info, const std::string& name) {
  for (std::size_t i = 0; i < info.fields.size(); ++i) {
    if (info.fields[i].name == name) return i;
  }
  ADD_FAILURE() << info.name << " has no field " << name;
  return 0;
}

inline std::size_t stream(const log::Recording& recording, const std::string& name) {
  for (std::size_t i = 0; i < recording.streams().size(); ++i) {
    if (recording.streams()[i].name == name) return i;
  }
  ADD_FAILURE() << "no stream " << name;
  return 0;
}

inline log::Rows read(const log::Recording& recording, std::size_t stream, const std::vector<std::string>& names) {
  std::vector<std::size_t> fields;
  for (const std::string& name : names) fields.push_back(field(recording.streams().at(stream), name));
  return recording.read(stream, fields);
}

inline std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + '\n';
  return all;
}

inline std::string notes(const log::Recording& recording) { return joined(recording.notes()); }

inline const std::vector<std::string> kGyroX{"angular_velocity.x"};
inline const std::vector<std::string> kSixAxes{"angular_velocity.x",    "angular_velocity.y",
                                               "angular_velocity.z",    "linear_acceleration.x",
                                               "linear_acceleration.y", "linear_acceleration.z"};

/// One sample each 10 ms from 1000 s on.
inline recording_writer::Stamp stamp_at(int i, std::uint32_t later_ns = 0) {
  return {static_cast<std::uint32_t>(1000 + i / 100), static_cast<std::uint32_t>(i % 100) * 10'000'000U + later_ns};
}

inline std::vector<std::int64_t> stamps(int first, int last) {
  std::vector<std::int64_t> all;
  for (int i = first; i < last; ++i) all.push_back(recording_writer::ns(stamp_at(i)));
  return all;
}

/// Those of these packings, or "sqlite", that this build has.
inline std::vector<std::string> packings(const std::vector<std::string>& wanted) {
  std::vector<std::string> there;
  for (const std::string& how : wanted) {
    if (how.empty() || how == "none" || (how == "bz2" && GYROBUDGET_HAS_BZIP2) ||
        (how == "lz4" && GYROBUDGET_HAS_LZ4) || (how == "zstd" && GYROBUDGET_HAS_ZSTD) ||
        (how == "sqlite" && GYROBUDGET_HAS_SQLITE)) {
      there.push_back(how);
    }
  }
  return there;
}

/// The stream holds imu_numbers() of these samples, at their stamps.
/// @param note  that reading gives, and no other
inline void expect_samples(const log::Recording& recording, std::size_t stream, int first, int last,
                           const std::string& note = {}) {
  const log::Rows rows = read(recording, stream, kSixAxes);
  EXPECT_EQ(rows.clock, "header.stamp");
  ASSERT_EQ(rows.stamps_ns, stamps(first, last));
  for (int i = first; i < last; ++i) {
    const recording_writer::ImuNumbers numbers = recording_writer::imu_numbers(i);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(rows.columns[k][static_cast<std::size_t>(i - first)], numbers[13 + k]);
      EXPECT_EQ(rows.columns[3 + k][static_cast<std::size_t>(i - first)], numbers[25 + k]);
    }
  }
  EXPECT_EQ(joined(rows.notes), note.empty() ? "" : note + '\n');
}

class RecordingTest : public TemporaryFolder {
 protected:
  /// Opens these bytes as a file, under a name that tells nothing.
  [[nodiscard]] std::unique_ptr<log::Recording> opened(const std::string& bytes) const {
    auto recording = log::open_recording(file("recording", bytes));
    if (!recording) throw std::runtime_error("not recognised");
    return recording;
  }
  /// The message with which these bytes are refused.
  [[nodiscard]] std::string refusal(const std::string& bytes) const {
    return message_of<text::InputError>([&] { static_cast<void>(opened(bytes)); });
  }
};

}  // namespace gyrobudget::app_tests
