// SPDX-License-Identifier: MIT
// Recordings that are small enough to be read whole when they are opened.
#pragma once

#include "gyrobudget/app/log/recording.h"

#include <string>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::log {

/// A stream and all its rows: a column for each of its fields.
struct StreamTable {
  StreamInfo info;
  Rows rows;
};

class TableRecording : public Recording {
 public:
  /// @param format  Recording::format() @param streams  StreamInfo::count and Rows::clock are set here
  /// @param notes  of the whole file
  TableRecording(std::string format, std::vector<StreamTable> streams, std::vector<std::string> notes);

  [[nodiscard]] std::string format() const override { return format_; }
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  [[nodiscard]] const std::vector<std::string>& notes() const override { return notes_; }
  [[nodiscard]] Rows read(std::size_t stream, std::span<const std::size_t> fields) const override;

 private:
  std::string format_;
  std::vector<StreamInfo> streams_;
  std::vector<Rows> rows_;
  std::vector<std::string> notes_;
};

}  // namespace gyrobudget::inline v0::log
