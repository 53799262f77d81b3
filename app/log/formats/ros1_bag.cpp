// SPDX-License-Identifier: MIT
#include "ros1_bag.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "byte_reader.h"
#include "chunked_source.h"
#include "message_recording.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";

enum class BagOp : std::uint8_t {
  none = 0,
  message = 2,
  bag_header = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7
};

/// The fields of a record's header that are read, as they stand there: the rest is empty.
struct BagHeader {
  std::string_view op, conn, time, topic, compression, size, ver, count, encryptor, index_pos, conn_count, chunk_count;
  std::string_view type, md5sum;  // of a connection's data, which is written in the same way
};

/// Calls `take` with the name and value of each field. @return false where the fields do not fill the header
template <class Take>
bool for_each_bag_field(std::string_view header, const Take& take) {
  ByteReader reader(header);
  while (reader.ok() && !reader.rest().empty()) {
    const std::string_view field = reader.prefixed();
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) return false;
    take(field.substr(0, equals), field.substr(equals + 1));
  }
  return reader.ok();
}

/// @return false where the fields do not fill the header
bool read_bag_header(std::string_view bytes, BagHeader& header) {
  using Place = std::pair<std::string_view, std::string_view BagHeader::*>;
  static constexpr std::array<Place, 14> kPlaces{{{"op", &BagHeader::op},
                                                  {"conn", &BagHeader::conn},
                                                  {"time", &BagHeader::time},
                                                  {"topic", &BagHeader::topic},
                                                  {"compression", &BagHeader::compression},
                                                  {"size", &BagHeader::size},
                                                  {"ver", &BagHeader::ver},
                                                  {"count", &BagHeader::count},
                                                  {"encryptor", &BagHeader::encryptor},
                                                  {"index_pos", &BagHeader::index_pos},
                                                  {"conn_count", &BagHeader::conn_count},
                                                  {"chunk_count", &BagHeader::chunk_count},
                                                  {"type", &BagHeader::type},
                                                  {"md5sum", &BagHeader::md5sum}}};
  return for_each_bag_field(bytes, [&](std::string_view name, std::string_view value) {
    const auto* const place = std::ranges::find(kPlaces, name, &Place::first);
    if (place != kPlaces.end()) header.*place->second = value;
  });
}

template <class Number>
std::optional<Number> bag_number(std::string_view field) {
  if (field.size() != sizeof(Number)) return std::nullopt;
  return load<Number>(field.data());
}

struct BagRecord {
  BagOp op = BagOp::none;
  BagHeader header;
  std::string_view data;      ///< what there is of it
  std::uint64_t missing = 0;  ///< bytes of the data that the file has not
  std::size_t size = 0;       ///< with the lengths
};

/// The record at the front.
/// @return empty where not even its header is there, or is none
std::optional<BagRecord> read_bag_record(std::string_view bytes) {
  ByteReader reader(bytes);
  BagRecord record;
  const std::string_view header = reader.prefixed();
  const auto length = reader.number<std::uint32_t>();
  if (!reader.ok() || !read_bag_header(header, record.header)) return std::nullopt;
  record.op = static_cast<BagOp>(bag_number<std::uint8_t>(record.header.op).value_or(0));
  record.data = reader.rest().substr(0, length);
  record.missing = length - record.data.size();
  record.size = bytes.size() - reader.rest().size() + record.data.size();
  return record;
}

/// The header of a message, of which there are many: nothing else is looked for in it.
struct MessageHeader {
  BagOp op = BagOp::none;
  std::uint32_t conn = 0;
  std::int64_t time_ns = 0;

  /// @return false where it is no header, or that of a message without one of these
  bool read(std::string_view header) {
    bool has_conn = false, has_time = false;
    const bool is_whole = for_each_bag_field(header, [&](std::string_view name, std::string_view value) {
      if (name == "op" && value.size() == 1) op = static_cast<BagOp>(value.front());
      if (name == "conn" && value.size() == sizeof conn) {
        conn = load<std::uint32_t>(value.data());
        has_conn = true;
      }
      if (name == "time" && value.size() == sizeof time_ns) {
        constexpr std::int64_t kNsPerS = 1'000'000'000;
        time_ns =
            load<std::uint32_t>(value.data()) * kNsPerS + load<std::uint32_t>(value.data() + sizeof(std::uint32_t));
        has_time = true;
      }
    });
    return is_whole && (op != BagOp::message || (has_conn && has_time));
  }
};

class BagSource : public ChunkedSource {
 public:
  BagSource(const std::string& path, const std::string& name) : ChunkedSource(path, name) {
    walk();
    count_loose_messages();
    if (!is_index_whole()) {
      if (is_closed_ && is_read_to_the_end_)
        found().add("the index does not fit the chunks: these were looked through");
      count_chunks();
    }
    finish();
  }

 protected:
  std::size_t read_records(std::string_view bytes, RecordSink& sink) const override {
    ByteReader reader(bytes);
    std::string_view rest = bytes;
    while (!rest.empty()) {
      const std::string_view header = reader.prefixed(), data = reader.prefixed();
      MessageHeader message;
      if (!reader.ok() || !message.read(header)) break;
      const std::string_view record = rest.substr(0, rest.size() - reader.rest().size());
      if (message.op == BagOp::connection) sink.declaration(record);
      if (message.op == BagOp::message) sink.message(message.conn, message.time_ns, data);
      rest = reader.rest();
    }
    return bytes.size() - rest.size();
  }

  void read_declaration(std::string_view bytes) override {
    const auto record = read_bag_record(bytes);
    BagHeader data;
    const auto id = bag_number<std::uint32_t>(record->header.conn);
    if (!id || !read_bag_header(record->data, data)) return;
    const MessageType* type = message_type(data.type);
    constexpr std::size_t kHexDigits = 32;
    if (type && !type->md5sum.empty() && data.md5sum.size() == kHexDigits && data.md5sum != type->md5sum &&
        !is_declared(*id)) {
      found().add(fmt::format("{} has a {} of another definition (md5sum {}): messages of another length are left out",
                              text::quoted(record->header.topic), type->name, text::quoted(data.md5sum)));
    }
    declare(*id, {std::string(record->header.topic), std::string(data.type), Encoding::ros1});
  }

 private:
  void walk();
  void take(const BagRecord& record, std::string_view bytes);
  void take_bag_header(const BagHeader& header);
  void take_chunk(const BagRecord& record);
  void take_index(const BagHeader& header);
  void tell_end(std::string_view rest, const std::optional<BagRecord>& record);
  [[nodiscard]] bool is_index_whole();

  bool is_first_ = true, is_closed_ = false, is_read_to_the_end_ = true, is_index_odd_ = false;
  std::uint32_t conn_count_ = 0, chunk_count_ = 0;  ///< by the bag header
};

/// Goes from record to record without looking into chunks.
void BagSource::walk() {
  std::string_view rest = file().substr(kBagMagic.size());
  while (!rest.empty()) {
    const auto record = read_bag_record(rest);
    if (!record || record->missing > 0 || record->op == BagOp::none) {
      is_read_to_the_end_ = false;
      if (record && record->op == BagOp::chunk) take_chunk(*record);
      tell_end(rest, record);
      return;
    }
    take(*record, rest.substr(0, record->size));
    rest.remove_prefix(record->size);
    passed(rest);
  }
  if (!is_closed_) {
    found().add("the bag was not closed, its recorder was killed: what it wrote until then is read");
  }
}

void BagSource::take(const BagRecord& record, std::string_view bytes) {
  switch (record.op) {
    case BagOp::bag_header:
      if (is_first_) take_bag_header(record.header);
      is_first_ = false;
      break;
    case BagOp::chunk:
      take_chunk(record);
      break;
    case BagOp::index:
      take_index(record.header);
      break;
    case BagOp::connection:
      read_declaration(bytes);
      break;
    case BagOp::message:
      add_loose(bytes);
      break;
    default:  // chunk_info says again what the index records behind each chunk do
      break;
  }
}

void BagSource::take_bag_header(const BagHeader& header) {
  if (!header.encryptor.empty() && header.encryptor != "rosbag/NoEncryptor") {
    text::fail(name(),
               fmt::format("is encrypted by {}; decrypt it with rosbag decrypt", text::quoted(header.encryptor)));
  }
  is_closed_ = bag_number<std::uint64_t>(header.index_pos).value_or(0) != 0;
  conn_count_ = bag_number<std::uint32_t>(header.conn_count).value_or(0);
  chunk_count_ = bag_number<std::uint32_t>(header.chunk_count).value_or(0);
}

void BagSource::take_chunk(const BagRecord& record) {
  const std::string_view how = record.header.compression;
  Part chunk{.bytes = record.data, .size = bag_number<std::uint32_t>(record.header.size).value_or(0)};
  chunk.is_cut = record.missing > 0;
  if (how == "bz2") {
    chunk.packing = Compression::bzip2;
  } else if (how == "lz4") {
    chunk.packing = Compression::lz4;
  } else if (how != "none") {
    found().add(fmt::format("the chunk at byte {} is left out: it is packed by {}, expected none, bz2 or lz4",
                            place(record.data), text::quoted(how)));
    return;
  }
  add_chunk(std::move(chunk));
}

void BagSource::take_index(const BagHeader& header) {
  const auto conn = bag_number<std::uint32_t>(header.conn), count = bag_number<std::uint32_t>(header.count);
  is_index_odd_ |= !conn || !count || bag_number<std::uint32_t>(header.ver) != 1U || parts().empty();
  if (!is_index_odd_) parts().back().counts[*conn] += *count;
}

void BagSource::tell_end(std::string_view rest, const std::optional<BagRecord>& record) {
  const std::size_t at = place(rest);
  if (record && record->op == BagOp::chunk) {
    found().add(
        fmt::format("the bag ends at byte {}, inside the chunk that begins at byte {}: its whole messages are kept",
                    file().size(), at));
  } else {
    found().add(fmt::format("the bag ends at byte {}, or is damaged there: {} bytes behind it are no whole record", at,
                            rest.size()));
  }
}

/// Whether the index tells of each chunk what is in it. A recorder that was killed has not written all of it.
bool BagSource::is_index_whole() {
  if (!is_closed_ || !is_read_to_the_end_ || is_index_odd_) return false;
  const auto chunks = static_cast<std::size_t>(std::ranges::count_if(parts(), &Part::is_chunk));
  constexpr std::int64_t kLeast = 30;  // bytes of a message with its header, for counts that cannot be
  const auto fits = [](const Part& part) {
    std::int64_t messages = 0;
    for (const auto& [id, count] : part.counts) messages += count;
    return !part.is_chunk || (!part.counts.empty() && messages <= to_signed(part.size) / kLeast);
  };
  const Counts all = counts();
  const auto declared = [&](const auto& entry) { return is_declared(entry.first); };
  return chunks == chunk_count_ && topics().size() == conn_count_ && std::ranges::all_of(parts(), fits) &&
         std::ranges::all_of(all, declared);
}

}  // namespace

bool is_ros1_bag(std::string_view head) { return head.starts_with(kBagMagic); }

bool is_old_ros1_bag(std::string_view head) {
  return !is_ros1_bag(head) &&
         (head.starts_with("#ROSBAG V") || head.starts_with("#ROSRECORD V") || head.starts_with("#ROSLOG V"));
}

std::unique_ptr<MessageSource> open_ros1_bag_source(const std::string& path, const std::string& name) {
  return std::make_unique<BagSource>(path, name);
}

std::unique_ptr<Recording> open_ros1_bag(const std::string& path) {
  return std::make_unique<MessageRecording>("ROS 1 bag", open_ros1_bag_source(path, path));
}

std::unique_ptr<Recording> open_old_ros1_bag(const std::string& path) {
  text::fail(path, "is a bag of an older version, expected version 2.0; convert it with rosbag fix OLD.bag NEW.bag");
}

}  // namespace gyrobudget::inline v0::log
