// SPDX-License-Identifier: MIT
// A recording that is made of messages: topics become streams, and messages rows.
#pragma once

#include "gyrobudget/app/log/recording.h"

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "message_source.h"

namespace gyrobudget::inline v0::log {

/// Topics of one name and one type, in whatever file and under whatever number, are one stream.
class MessageRecording : public Recording {
 public:
  /// @param format  Recording::format() @param sources  the files of the recording in their order
  /// @param notes  of what the recording is, before those of its files
  MessageRecording(std::string format, std::vector<std::unique_ptr<MessageSource>> sources,
                   std::vector<std::string> notes = {});
  /// A recording that is one file.
  MessageRecording(std::string format, std::unique_ptr<MessageSource> source);

  [[nodiscard]] std::string format() const override { return format_; }
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  [[nodiscard]] const std::vector<std::string>& notes() const override { return notes_; }
  [[nodiscard]] Rows read(std::size_t stream, std::span<const std::size_t> fields) const override;

 private:
  void add_streams();
  void add_stream(const Topic& topic);
  void visit(std::size_t stream, MessageSink& sink, Findings& findings) const;

  std::string format_;
  std::vector<std::unique_ptr<MessageSource>> sources_;
  std::vector<std::string> notes_;
  std::vector<StreamInfo> streams_;
  std::vector<std::vector<std::size_t>> stream_of_;        ///< by source and topic
  std::unordered_map<std::string, std::size_t> by_topic_;  ///< streams by name, type and whether they are read
  std::unordered_map<std::string, std::int64_t> numbers_;  ///< of streams whose topics have one name
  Findings shared_names_;
};

}  // namespace gyrobudget::inline v0::log
