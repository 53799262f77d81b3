// SPDX-License-Identifier: MIT
// Files of stamped rows whose columns are known by name, whatever wrote them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"
#include "named_columns.h"
#include "recorded.h"
#include "recording.h"
#include "table.h"

namespace gyrobudget::inline v0::log {

/// A text, or one stream of a recording, with its headings and units. The clock of a stream is its column "time", in
/// nanoseconds.
///
///     const log::NamedFile file("walk.bag", {}, use);
///     const log::NamedColumns columns = file.columns(map, "expected gyro_x ... and time");
///     log::Choice choice;
///     choice.data.push_back(columns.get(kGyroX));
///     log::add_stamps(choice, columns.get(log::kTimeColumn));
///     const log::Table table = file.read(choice, notes);
class NamedFile {
 public:
  /// @param path   of a text, or of a recording, known by its content; either may be packed
  /// @param topic  of a recording: the stream; unset: the only one that is meant
  /// @throws InputError where it cannot be read, and as choose_stream() does.
  NamedFile(const std::string& path, const std::optional<std::string>& topic, const StreamUse& use);
  NamedFile(const NamedFile&) = delete;  // its parts refer to one another
  NamedFile& operator=(const NamedFile&) = delete;

  /// The path, and the stream: "walk.bag, /imu".
  [[nodiscard]] const std::string& name() const { return name_; }
  /// The recording; null of a text.
  [[nodiscard]] const Recording* recording() const { return recording_.get(); }
  /// The stream; null of a text.
  [[nodiscard]] const StreamInfo* stream() const { return recording_ ? &recording_->streams()[stream_] : nullptr; }
  [[nodiscard]] bool has(std::string_view heading) const;
  /// What the header of a text, or the fields of a stream, mean. @param map  which must outlive it
  /// @param expected  for the message where one is missing
  [[nodiscard]] NamedColumns columns(const ColumnMap& map, std::string_view expected) const {
    return {name_, layout_, map, expected};
  }

  /// Numbers in SI and stamps. Those of a stream are in the order of its stamps, each once.
  /// @throws as TableReader::read and Recording::read do.
  [[nodiscard]] Table read(const Choice& choice, std::vector<std::string>& notes) const;
  /// @param is_decimated  becomes whether rows of a stream say that they cover less than the time between them
  [[nodiscard]] Table read(const Choice& choice, std::vector<std::string>& notes, bool& is_decimated) const;

  /// @throws InputError at the line of a row, or at its number in a stream.
  [[noreturn]] void fail_row(std::size_t row, const std::string& message) const;
  /// Every row needs a stamp, after that of the row before. @throws InputError at one that has not.
  void check_stamps(const Table& table) const;

 private:
  [[nodiscard]] Table read_stream(const Choice& choice, std::vector<std::string>& notes, bool& is_decimated) const;

  std::string path_, name_;
  std::unique_ptr<Recording> recording_;
  std::size_t stream_ = 0;
  std::optional<Bytes> source_;
  Layout layout_;
  std::optional<TableReader> reader_;
};

}  // namespace gyrobudget::inline v0::log
