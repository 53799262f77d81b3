// SPDX-License-Identifier: MIT
// Messages, bags and MCAP files, written byte by byte from their specifications.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#if GYROBUDGET_HAS_BZIP2
#include <bzlib.h>
#endif
#if GYROBUDGET_HAS_LZ4
#include <lz4frame.h>
#endif
#if GYROBUDGET_HAS_ZSTD
#include <zstd.h>
#endif

namespace gyrobudget::recording_writer {

/// Bytes to which numbers and strings are appended.
class Buffer {
 public:
  explicit Buffer(bool big_endian = false) : big_endian_(big_endian) {}

  template <class Number>
  Buffer& number(Number value) {
    std::string raw(sizeof value, '\0');
    std::memcpy(raw.data(), &value, sizeof value);
    if (big_endian_) std::reverse(raw.begin(), raw.end());
    bytes += raw;
    return *this;
  }
  Buffer& u8(unsigned value) { return number(static_cast<std::uint8_t>(value)); }
  Buffer& u16(unsigned value) { return number(static_cast<std::uint16_t>(value)); }
  Buffer& u32(std::uint64_t value) { return number(static_cast<std::uint32_t>(value)); }
  Buffer& u64(std::uint64_t value) { return number(value); }
  Buffer& text(std::string_view text) {
    u32(text.size());
    bytes += text;
    return *this;
  }
  Buffer& align(std::size_t to, std::size_t origin) {
    while ((bytes.size() - origin) % to != 0) bytes += '\0';
    return *this;
  }

  std::string bytes;

 private:
  bool big_endian_;
};

struct Stamp {
  std::uint32_t sec = 0, nanosec = 0;
};
inline std::int64_t ns(Stamp stamp) { return std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec; }

/// The numbers of a sensor_msgs/Imu: quaternion x y z w, covariance, angular velocity, covariance, acceleration,
/// covariance.
using ImuNumbers = std::array<double, 37>;

/// Sample i: angular velocity i + 0.1, 0.2, 0.3; acceleration -i + 0.4, 0.5, 9.6; no orientation.
inline ImuNumbers imu_numbers(int i) {
  ImuNumbers n{};
  n[3] = 1;
  n[4] = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    n[13 + k] = i + 0.1 * (1 + static_cast<double>(k));
    n[25 + k] = -i + 0.1 * (4 + static_cast<double>(k));
  }
  n[27] = 9.6;
  n[16] = n[20] = n[24] = 1e-4;
  return n;
}

// --- Messages -------------------------------------------------------------------------------------------------------

inline Buffer ros1_header(Stamp stamp, std::string_view frame) {
  Buffer b;
  return b.u32(7).u32(stamp.sec).u32(stamp.nanosec).text(frame);
}

inline std::string ros1_imu(Stamp stamp, const ImuNumbers& numbers, std::string_view frame = "imu") {
  Buffer b = ros1_header(stamp, frame);
  for (const double n : numbers) b.number(n);
  return b.bytes;
}

/// How CDR is written.
struct Cdr {
  bool big_endian = false;
  bool xcdr2 = false;
  int padding = 0;  ///< bytes behind the last number

  [[nodiscard]] Buffer begin(Stamp stamp, std::string_view frame) const {
    Buffer b(big_endian);
    b.u8(0).u8((xcdr2 ? 6U : 0U) + (big_endian ? 0U : 1U)).u8(0).u8(static_cast<unsigned>(padding));
    b.u32(stamp.sec).u32(stamp.nanosec).u32(frame.size() + 1);
    b.bytes += frame;
    b.bytes += '\0';
    return b;
  }
  [[nodiscard]] std::size_t alignment() const { return xcdr2 ? 4 : 8; }
  [[nodiscard]] std::string imu(Stamp stamp, const ImuNumbers& numbers, std::string_view frame = "imu_link") const {
    Buffer b = begin(stamp, frame);
    b.align(alignment(), 4);
    for (const double n : numbers) b.number(n);
    return b.bytes + std::string(static_cast<std::size_t>(padding), '\0');
  }
};

/// Latitude, longitude, altitude and covariance as in sensor_msgs/NavSatFix.
struct Fix {
  int status = 0;
  unsigned service = 1;
  std::array<double, 3> position{-2.3, -44.4, 12.5};
  std::array<double, 9> covariance{4, 0, 0, 0, 5, 0, 0, 0, 16};
  unsigned covariance_type = 2;
};

inline std::string ros1_fix(Stamp stamp, const Fix& fix) {
  Buffer b = ros1_header(stamp, "gps");
  b.number(static_cast<std::int8_t>(fix.status)).u16(fix.service);
  for (const double n : fix.position) b.number(n);
  for (const double n : fix.covariance) b.number(n);
  return b.u8(fix.covariance_type).bytes;
}

inline std::string cdr_fix(const Cdr& cdr, Stamp stamp, const Fix& fix, std::string_view frame = "gps") {
  Buffer b = cdr.begin(stamp, frame);
  b.number(static_cast<std::int8_t>(fix.status)).align(2, 4).u16(fix.service).align(cdr.alignment(), 4);
  for (const double n : fix.position) b.number(n);
  for (const double n : fix.covariance) b.number(n);
  return b.u8(fix.covariance_type).bytes;
}

// --- Packing --------------------------------------------------------------------------------------------------------

#if GYROBUDGET_HAS_BZIP2
inline std::string pack_bz2(std::string bytes) {
  std::string out(bytes.size() + bytes.size() / 50 + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, bytes.data(), static_cast<unsigned>(bytes.size()), 9, 0, 0);
  out.resize(size);
  return out;
}
#endif
#if GYROBUDGET_HAS_LZ4
/// Independent blocks of 64 KiB with a check sum of the content, as rosbag writes.
inline std::string pack_lz4(const std::string& bytes) {
  LZ4F_preferences_t how{};
  how.frameInfo.blockMode = LZ4F_blockIndependent;
  how.frameInfo.blockSizeID = LZ4F_max64KB;
  how.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  std::string out(LZ4F_compressFrameBound(bytes.size(), &how), '\0');
  out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), &how));
  return out;
}
#endif
#if GYROBUDGET_HAS_ZSTD
inline std::string pack_zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
  return out;
}
#endif

/// Packs as "none", "bz2", "lz4" or "zstd" say.
inline std::string pack([[maybe_unused]] const std::string& how, const std::string& bytes) {
#if GYROBUDGET_HAS_BZIP2
  if (how == "bz2") return pack_bz2(bytes);
#endif
#if GYROBUDGET_HAS_LZ4
  if (how == "lz4") return pack_lz4(bytes);
#endif
#if GYROBUDGET_HAS_ZSTD
  if (how == "zstd") return pack_zstd(bytes);
#endif
  return bytes;
}

// --- ROS 1 bags -----------------------------------------------------------------------------------------------------

using BagFields = std::vector<std::pair<std::string, std::string>>;

template <class Number>
std::string raw(Number value) {
  Buffer b;
  return b.number(value).bytes;
}

inline std::string bag_fields(const BagFields& fields) {
  Buffer b;
  for (const auto& [name, value] : fields) b.text(name + "=" + value);
  return b.bytes;
}

inline std::string bag_record(const BagFields& header, const std::string& data) {
  Buffer b;
  return b.text(bag_fields(header)).text(data).bytes;
}

inline std::string bag_op(int op) { return raw(static_cast<std::uint8_t>(op)); }
inline std::string bag_time(Stamp stamp) { return raw(stamp.sec) + raw(stamp.nanosec); }

/// Writes a bag chunk by chunk.
class BagWriter {
 public:
  /// What goes into the chunk that is begun. The record of a connection stands before its first message.
  void connection(std::uint32_t conn, const std::string& topic, const std::string& type, const std::string& md5 = "*",
                  const std::string& topic_inside = {}) {
    const std::string inside = topic_inside.empty() ? topic : topic_inside;
    const std::string record = bag_record(
        {{"op", bag_op(7)}, {"conn", raw(conn)}, {"topic", topic}},
        bag_fields({{"topic", inside}, {"type", type}, {"md5sum", md5}, {"message_definition", "float64 a=1\n"}}));
    chunk_ += record;
    connections_ += record;
    ++conn_count_;
  }
  void message(std::uint32_t conn, Stamp time, const std::string& data) {
    index_[conn] += bag_time(time) + raw(static_cast<std::uint32_t>(chunk_.size()));
    chunk_ += bag_record({{"time", bag_time(time)}, {"conn", raw(conn)}, {"op", bag_op(2)}}, data);
  }
  /// Ends the chunk. @param says  its compression, where that is not what is done
  void end_chunk(const std::string& how = "none", const std::string& says = {}, std::int64_t size_error = 0) {
    const std::string packed = pack(how, chunk_);
    const auto size = static_cast<std::uint32_t>(static_cast<std::int64_t>(chunk_.size()) + size_error);
    begin_of_last_chunk = kFirst + body_.size();
    std::string infos;
    for (const auto& [conn, entries] : index_) infos += raw(conn) + raw(count_of(entries));
    chunk_infos_ += bag_record({{"ver", raw(std::uint32_t{1})},
                                {"op", bag_op(6)},
                                {"chunk_pos", raw(static_cast<std::uint64_t>(begin_of_last_chunk))},
                                {"start_time", bag_time({})},
                                {"end_time", bag_time({})},
                                {"count", raw(static_cast<std::uint32_t>(index_.size()))}},
                               infos);
    body_ += bag_record({{"compression", says.empty() ? how : says}, {"op", bag_op(5)}, {"size", raw(size)}}, packed);
    for (const auto& [conn, entries] : index_) {
      body_ += bag_record({{"op", bag_op(4)},
                           {"ver", raw(std::uint32_t{1})},
                           {"conn", raw(conn)},
                           {"count", raw(count_of(entries) + index_lie)}},
                          entries);
    }
    ++chunk_count_;
    chunk_.clear();
    index_.clear();
  }
  /// A record outside chunks.
  void loose(const std::string& record) { body_ += record; }

  [[nodiscard]] std::string closed(const BagFields& more = {}) const {
    return begin(kFirst + body_.size(), conn_count_, chunk_count_, more) + body_ + connections_ + chunk_infos_;
  }
  /// What a killed recorder leaves.
  [[nodiscard]] std::string killed() const { return begin(0, 0, 0, {}) + body_; }

  static constexpr std::size_t kFirst = 13 + 4104;  ///< where the first chunk begins
  std::size_t begin_of_last_chunk = 0;
  std::uint32_t index_lie = 0;  ///< by which the counts of the index are too many

 private:
  static std::uint32_t count_of(const std::string& entries) { return static_cast<std::uint32_t>(entries.size() / 12); }
  static std::string begin(std::size_t index, std::uint32_t connections, std::uint32_t chunks, const BagFields& more) {
    BagFields fields{{"op", bag_op(3)},
                     {"index_pos", raw(static_cast<std::uint64_t>(index))},
                     {"conn_count", raw(connections)},
                     {"chunk_count", raw(chunks)}};
    fields.insert(fields.end(), more.begin(), more.end());
    const std::string header = bag_fields(fields);
    return "#ROSBAG V2.0\n" + bag_record(fields, std::string(4096 - header.size(), ' '));
  }

  std::string body_, chunk_, connections_, chunk_infos_;
  std::map<std::uint32_t, std::string> index_;
  std::uint32_t conn_count_ = 0, chunk_count_ = 0;
};

// --- MCAP -----------------------------------------------------------------------------------------------------------

inline std::string mcap_record(unsigned op, const std::string& content) {
  Buffer b;
  return b.u8(op).u64(content.size()).bytes + content;
}

inline std::string mcap_schema(unsigned id, const std::string& name, const std::string& encoding = "ros2msg") {
  Buffer b;
  return mcap_record(3, b.u16(id).text(name).text(encoding).text("float64 a").bytes);
}

inline std::string mcap_channel(unsigned id, unsigned schema, const std::string& topic, const std::string& encoding) {
  Buffer b;
  return mcap_record(4, b.u16(id).u16(schema).text(topic).text(encoding).text("").bytes);
}

inline std::string mcap_message(unsigned channel, std::uint64_t log_ns, const std::string& data) {
  Buffer b;
  return mcap_record(5, b.u16(channel).u32(0).u64(log_ns).u64(log_ns).bytes + data);
}

/// Writes an MCAP, of which the summary is left to choice.
class McapWriter {
 public:
  static inline const std::string kMagic = "\x89MCAP0\r\n";

  void loose(const std::string& record) { data_ += record; }
  void declare(const std::string& record) {
    chunk_ += record;
    declarations_ += record;
  }
  void message(unsigned channel, std::uint64_t log_ns, const std::string& data) {
    Buffer b;
    index_[channel] += b.u64(log_ns).u64(chunk_.size()).bytes;
    ++counts_[channel];
    chunk_ += mcap_message(channel, log_ns, data);
  }
  void loose_message(unsigned channel, std::uint64_t log_ns, const std::string& data) {
    ++counts_[channel];
    data_ += mcap_message(channel, log_ns, data);
  }
  /// @param crc  of the records; 0 is "not computed"
  void end_chunk(const std::string& how = "", std::uint32_t crc = 0, const std::string& padding = {},
                 std::int64_t size_error = 0) {
    const std::string packed = pack(how, chunk_) + padding;
    Buffer b;
    b.u64(0).u64(0).u64(static_cast<std::uint64_t>(static_cast<std::int64_t>(chunk_.size()) + size_error));
    data_ += mcap_record(6, b.u32(crc).text(how).u64(packed.size()).bytes + packed);
    for (const auto& [channel, entries] : index_) {
      Buffer index;
      if (has_index) data_ += mcap_record(7, index.u16(channel).text(entries).bytes);
    }
    chunk_.clear();
    index_.clear();
  }
  [[nodiscard]] const std::string& chunk() const { return chunk_; }

  [[nodiscard]] std::string closed() const {
    Buffer statistics, counts, footer;
    std::uint64_t messages = 0;
    for (const auto& [channel, count] : counts_) {
      messages += count;
      counts.u16(channel).u64(count);
    }
    statistics.u64(messages).u16(0).u32(counts_.size()).u32(0).u32(0).u32(0).u64(0).u64(0).text(counts.bytes);
    Buffer end;
    return cut() + mcap_record(0xf, end.u32(0).bytes) + declarations_ +
           (has_statistics ? mcap_record(0xb, statistics.bytes) : std::string()) +
           mcap_record(2, footer.u64(0).u64(0).u32(0).bytes) + kMagic;
  }
  /// Without anything behind the data.
  [[nodiscard]] std::string cut() const {
    Buffer header;
    return kMagic + mcap_record(1, header.text("ros2").text("by hand").bytes) + data_;
  }

  bool has_statistics = true, has_index = true;

 private:
  std::string data_, chunk_, declarations_;
  std::map<unsigned, std::string> index_;
  std::map<unsigned, std::uint64_t> counts_;
};

}  // namespace gyrobudget::recording_writer
