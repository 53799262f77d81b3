// SPDX-License-Identifier: MIT
// Files of records, some of them in chunks that are packed as one: ROS 1 bags and MCAP.
#pragma once

#include "gyrobudget/app/log/bytes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "message_source.h"
#include "unpacker.h"

namespace gyrobudget::inline v0::log {

/// What reads the records of a part of a file.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  /// @param id  of its connection or channel
  virtual void message(std::uint32_t id, std::int64_t record_ns, std::string_view data) = 0;
  /// A record that declares something.
  virtual void declaration(std::string_view record) = 0;
};

/// Messages by the connection or channel that they belong to.
using Counts = std::unordered_map<std::uint32_t, std::int64_t>;

/// A part of a file that holds messages.
struct Part {
  std::string_view bytes;  ///< as they stand in the file
  Compression packing = Compression::none;
  std::uint64_t size = 0;            ///< of the records, by the file
  std::optional<std::uint32_t> crc;  ///< of the records, where it was computed
  bool is_chunk = false;
  bool is_cut = false;  ///< the file ends in it
  Counts counts;        ///< by the file's index, until the part is counted
};

/// Keeps where the parts are. The index of a file tells what is in them; where it is missing or does not fit, they are
/// unpacked once to count, which always works.
class ChunkedSource : public MessageSource {
 public:
  [[nodiscard]] const std::string& name() const final { return name_; }
  [[nodiscard]] std::uint64_t bytes() const final { return file_.text().size(); }
  [[nodiscard]] const std::vector<Topic>& topics() const final { return topics_; }
  [[nodiscard]] const Findings& findings() const final { return findings_; }
  std::int64_t visit(const std::vector<bool>& wanted, MessageSink& sink, Findings& findings) const final;

 protected:
  /// @param path  of the file, which may go once it is open @param name  that messages call it
  ChunkedSource(const std::string& path, std::string name) : file_(path, Content::bytes), name_(std::move(name)) {}

  /// Reads whole records one after the other. @return the bytes that they take
  virtual std::size_t read_records(std::string_view bytes, RecordSink& sink) const = 0;
  /// Reads a declaration, and calls declare() for what is a connection or channel.
  virtual void read_declaration(std::string_view record) = 0;

  [[nodiscard]] std::string_view file() const { return file_.text(); }
  /// What is before this rest of the file has been looked at, and may leave memory.
  void passed(std::string_view rest);
  [[nodiscard]] std::size_t place(std::string_view part) const {
    return static_cast<std::size_t>(part.data() - file_.text().data());
  }
  Findings& found() { return findings_; }

  void declare(std::uint32_t id, Topic topic);
  [[nodiscard]] bool is_declared(std::uint32_t id) const { return topic_of_.contains(id); }
  /// @throws text::InputError where this build cannot unpack it.
  void add_chunk(Part chunk);
  /// A message outside chunks.
  void add_loose(std::string_view record);
  [[nodiscard]] std::vector<Part>& parts() { return parts_; }
  /// Counts what no index tells: the messages outside chunks.
  void count_loose_messages();
  /// What the parts hold by now.
  [[nodiscard]] Counts counts() const;
  /// Counts in all chunks, whatever the index says.
  void count_chunks();
  /// Gives the counts to the topics.
  void finish();

 private:
  void count(Part& part, Unpacker& unpacker);
  [[nodiscard]] std::string_view unpack(const Part& part, Unpacker& unpacker, Findings& findings) const;
  void read(const Part& part, Unpacker& unpacker, RecordSink& sink, Findings& findings) const;
  [[nodiscard]] bool holds(const Part& part, const std::vector<bool>& wanted) const;

  Bytes file_;
  std::string name_;
  std::vector<Topic> topics_;
  std::unordered_map<std::uint32_t, std::size_t> topic_of_;
  std::vector<Part> parts_;
  std::size_t passed_ = 0;
  Findings findings_;
};

}  // namespace gyrobudget::inline v0::log
