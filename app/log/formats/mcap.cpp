// SPDX-License-Identifier: MIT
#include "mcap.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "byte_reader.h"
#include "chunked_source.h"
#include "message_recording.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::string_view kMcapMagic = "\x89MCAP0\r\n";

constexpr std::size_t kMcapVersion = 5;  // its place there

enum class McapOp : std::uint8_t {
  none = 0,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  statistics = 0xb,
};

struct McapRecord {
  McapOp op = McapOp::none;
  std::string_view content;   ///< what there is of it
  std::uint64_t missing = 0;  ///< bytes of the content that the file has not
  std::size_t size = 0;       ///< with operation and length
};

/// The record at the front; empty where not even its length is there.
std::optional<McapRecord> read_mcap_record(std::string_view bytes) {
  ByteReader reader(bytes);
  McapRecord record;
  record.op = static_cast<McapOp>(reader.number<std::uint8_t>());
  const auto length = reader.number<std::uint64_t>();
  if (!reader.ok()) return std::nullopt;
  record.content =
      reader.rest().substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(length, reader.rest().size())));
  record.missing = length - record.content.size();
  record.size = bytes.size() - reader.rest().size() + record.content.size();
  return record;
}

Encoding encoding_named(std::string_view name) {
  return name == "cdr" ? Encoding::cdr : name == "ros1" ? Encoding::ros1 : Encoding::other;
}

class McapSource : public ChunkedSource {
 public:
  McapSource(const std::string& path, const std::string& name) : ChunkedSource(path, name) {
    if (!file().starts_with(kMcapMagic)) {
      text::fail(name, fmt::format("is an MCAP of version {}, expected 0; convert it with mcap convert",
                                   text::quoted(file().substr(kMcapVersion, 1))));
    }
    walk();
    count_loose_messages();
    if (!is_index_whole()) count_chunks();
    finish();
  }

 protected:
  std::size_t read_records(std::string_view bytes, RecordSink& sink) const override {
    std::string_view rest = bytes;
    while (!rest.empty()) {
      const auto record = read_mcap_record(rest);
      if (!record || record->missing > 0) break;
      if (record->op == McapOp::message) {
        ByteReader reader(record->content);
        const auto channel = reader.number<std::uint16_t>();
        reader.number<std::uint32_t>();  // the sequence number, often 0
        const std::int64_t log_ns = to_signed(reader.number<std::uint64_t>());
        reader.number<std::uint64_t>();  // when it was published
        if (!reader.ok()) break;
        sink.message(channel, log_ns, reader.rest());
      } else if (record->op == McapOp::schema || record->op == McapOp::channel) {
        sink.declaration(rest.substr(0, record->size));
      }
      rest.remove_prefix(record->size);
    }
    return bytes.size() - rest.size();
  }

  /// Schemas and channels are repeated in later chunks and in the summary.
  void read_declaration(std::string_view bytes) override {
    const auto record = read_mcap_record(bytes);
    ByteReader reader(record->content);
    const auto id = reader.number<std::uint16_t>();
    if (record->op == McapOp::schema) {
      const std::string_view name = reader.prefixed();
      if (reader.ok()) schemas_.try_emplace(id, name);
      return;
    }
    const auto schema = schemas_.find(reader.number<std::uint16_t>());
    const std::string_view topic = reader.prefixed(), encoding = reader.prefixed();
    if (!reader.ok()) return;
    declare(id,
            {std::string(topic), schema == schemas_.end() ? std::string() : schema->second, encoding_named(encoding)});
  }

 private:
  void walk();
  void take(const McapRecord& record, std::string_view bytes);
  void take_chunk(const McapRecord& record);
  void take_message_index(std::string_view content);
  void take_statistics(std::string_view content);
  [[nodiscard]] bool is_index_whole() const;

  std::unordered_map<std::uint16_t, std::string> schemas_;
  std::optional<Counts> statistics_;
  bool is_closed_ = false, is_left_out_ = false;  ///< one of the chunks
};

/// Goes from record to record without looking into chunks, up to the footer.
void McapSource::walk() {
  std::string_view rest = file().substr(kMcapMagic.size());
  while (!rest.empty()) {
    const auto record = read_mcap_record(rest);
    const bool is_whole = record && record->missing == 0 && record->op != McapOp::none;
    if (!is_whole && record && record->op == McapOp::chunk) {
      take_chunk(*record);
      found().add(
          fmt::format("the file ends at byte {}, inside the chunk that begins at byte {}: its whole messages are kept",
                      file().size(), place(rest)));
      return;
    }
    if (!is_whole) {
      found().add(fmt::format("the file ends at byte {}, or is damaged there: {} bytes behind it are no whole record",
                              place(rest), rest.size()));
      return;
    }
    take(*record, rest.substr(0, record->size));
    rest.remove_prefix(record->size);
    passed(rest);
    if (record->op == McapOp::footer) {
      is_closed_ = rest == kMcapMagic;
      if (!is_closed_)
        found().add(fmt::format("behind the footer, at byte {}, stands not the end of an MCAP", place(rest)));
      return;
    }
  }
  found().add("the file was not closed, its recorder was killed: what it wrote until then is read");
}

void McapSource::take(const McapRecord& record, std::string_view bytes) {
  switch (record.op) {
    case McapOp::schema:
    case McapOp::channel:
      read_declaration(bytes);
      break;
    case McapOp::message:
      add_loose(bytes);
      break;
    case McapOp::chunk:
      take_chunk(record);
      break;
    case McapOp::message_index:
      take_message_index(record.content);
      break;
    case McapOp::statistics:
      take_statistics(record.content);
      break;
    default:  // attachments, metadata, indexes of these, and what others add
      break;
  }
}

void McapSource::take_chunk(const McapRecord& record) {
  ByteReader reader(record.content);
  reader.number<std::uint64_t>();  // times of the first and last message
  reader.number<std::uint64_t>();
  Part chunk{.size = reader.number<std::uint64_t>()};
  const auto crc = reader.number<std::uint32_t>();
  if (crc != 0) chunk.crc = crc;
  const std::string_view how = reader.prefixed();
  const auto size = reader.number<std::uint64_t>();
  if (!reader.ok()) return;
  chunk.bytes = reader.rest().substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(size, reader.rest().size())));
  chunk.is_cut = record.missing > 0;
  if (how == "lz4") {
    chunk.packing = Compression::lz4;
  } else if (how == "zstd") {
    chunk.packing = Compression::zstd;
  } else if (!how.empty()) {
    found().add(fmt::format("the chunk at byte {} is left out: it is packed by {}, expected none, lz4 or zstd",
                            place(chunk.bytes), text::quoted(how)));
    is_left_out_ = true;
    return;
  }
  add_chunk(std::move(chunk));
}

/// These follow their chunk.
void McapSource::take_message_index(std::string_view content) {
  constexpr std::size_t kEntry = 16;
  ByteReader reader(content);
  const auto channel = reader.number<std::uint16_t>();
  const std::string_view entries = reader.prefixed();
  if (reader.ok() && !parts().empty() && parts().back().is_chunk && !entries.empty()) {
    parts().back().counts[channel] += static_cast<std::int64_t>(entries.size() / kEntry);
  }
}

void McapSource::take_statistics(std::string_view content) {
  ByteReader reader(content);
  constexpr std::size_t kBeforeCounts = 8 + 2 + 4 * 4 + 2 * 8;
  reader.bytes(kBeforeCounts);
  ByteReader entries(reader.prefixed());
  Counts counts;
  while (entries.ok() && !entries.rest().empty()) {
    const auto channel = entries.number<std::uint16_t>();
    const std::int64_t messages = to_signed(entries.number<std::uint64_t>());
    if (messages > 0) counts[channel] = messages;
  }
  if (reader.ok() && entries.ok()) statistics_ = std::move(counts);
}

/// Whether what the message indexes tell, and what is outside chunks, is what the statistics say: writers may leave
/// indexes out.
bool McapSource::is_index_whole() const {
  if (!is_closed_ || is_left_out_ || !statistics_) return false;
  const auto declared = [&](const auto& entry) { return is_declared(entry.first); };
  return counts() == *statistics_ && std::ranges::all_of(*statistics_, declared);
}

}  // namespace

bool is_mcap(std::string_view head) {
  return head.size() >= kMcapMagic.size() && head.substr(0, kMcapVersion) == kMcapMagic.substr(0, kMcapVersion) &&
         head.substr(kMcapVersion + 1).starts_with(kMcapMagic.substr(kMcapVersion + 1));
}

std::unique_ptr<MessageSource> open_mcap_source(const std::string& path, const std::string& name) {
  return std::make_unique<McapSource>(path, name);
}

std::unique_ptr<Recording> open_mcap(const std::string& path) {
  return std::make_unique<MessageRecording>("MCAP", open_mcap_source(path, path));
}

}  // namespace gyrobudget::inline v0::log
