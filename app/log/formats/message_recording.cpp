// SPDX-License-Identifier: MIT
#include "message_recording.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "unpacker.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::string_view kHeaderClock = "header.stamp", kRecordClock = "record time";

/// The places of the members that are offered, in the order in which they are.
std::vector<std::size_t> offered_members(const MessageType& type) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < type.members.size(); ++i) {
    if (!type.members[i].name.empty()) members.push_back(i);
  }
  return members;
}

/// A type that is read, of messages that are serialized in a way that is read.
const MessageType* read_type(const Topic& topic) {
  return topic.encoding == Encoding::other ? nullptr : message_type(topic.type);
}

StreamInfo stream_of(const Topic& topic, std::string name) {
  StreamInfo info{.name = std::move(name), .type = text::printable(topic.type), .clock = std::string(kRecordClock)};
  const MessageType* type = read_type(topic);
  if (!type) return info;
  info.kind = type->kind;
  info.clock = kHeaderClock;
  for (const std::size_t member : offered_members(*type)) {
    const auto& [member_name, unit, primitive, mark] = type->members[member];
    info.fields.push_back({member_name, unit, unit.empty() ? "" : fmt::format("{} has it so", type->name)});
  }
  return info;
}

/// Header stamps; or, where these are all zero or all the same and so tell nothing, the times of recording. Either is
/// kept in the same numbers.
class Stamps {
 public:
  void reserve(std::size_t count) { stamps_.reserve(count); }
  void add(std::int64_t header_ns, std::int64_t record_ns) {
    if (stamps_.empty()) first_ = header_ns;
    if (!are_headers_ && header_ns != first_) {
      std::ranges::fill(stamps_, first_);
      are_headers_ = true;
    }
    stamps_.push_back(are_headers_ ? header_ns : record_ns);
  }
  /// @return whether they are those of the headers
  bool take(std::vector<std::int64_t>& stamps) {
    if (stamps_.size() == 1 && first_ != 0) {
      stamps_.front() = first_;
      are_headers_ = true;
    }
    stamps = std::move(stamps_);
    return are_headers_ || stamps.empty();
  }
  [[nodiscard]] std::int64_t constant() const { return first_; }

 private:
  std::vector<std::int64_t> stamps_;
  std::int64_t first_ = 0;
  bool are_headers_ = false;
};

/// The first messages of a file that the last one of the file before already had: recorders that split their files may
/// write it into both.
class Seam {
 public:
  void begin_file() { is_open_ = !data_.empty(); }
  /// @return whether the message is that last one again; it is remembered otherwise
  bool repeats(const Message& message) {
    is_open_ = is_open_ && message.record_ns == record_ns_ && message.data == data_;
    if (is_open_) return true;
    record_ns_ = message.record_ns;
    data_ = message.data;
    return false;
  }

 private:
  std::int64_t record_ns_ = 0;
  std::string data_;
  bool is_open_ = false;
};

/// Turns the messages of a stream into rows of the fields that are asked for.
class RowSink : public MessageSink {
 public:
  /// @param members  of the type, of which the columns are made
  RowSink(const MessageType& type, std::span<const std::size_t> members, std::int64_t rows)
      : type_(type),
        members_(members.begin(), members.end()),
        ros1_(type, Encoding::ros1, members),
        cdr_(type, Encoding::cdr, members),
        values_(members.size()),
        columns_(members.size()),
        absent_(type.marks.size()) {
    stamps_.reserve(static_cast<std::size_t>(rows));
    for (auto& column : columns_) column.reserve(static_cast<std::size_t>(rows));
  }

  void begin_file(const MessageSource& source) override {
    source_ = &source;
    unpacker_.emplace(source.name());
  }

  void take(const Message& message) override {
    std::int64_t stamp_ns = 0;
    const Decoded decoded = decode(message, stamp_ns);
    if (decoded != Decoded::whole) {
      ++left_out_[static_cast<std::size_t>(decoded)];
      return;
    }
    stamps_.add(stamp_ns, message.record_ns);
    for (std::size_t i = 0; i < values_.size(); ++i) columns_[i].push_back(values_[i]);
  }

  /// @throws text::InputError where not one message was of the type.
  Rows rows(Findings& findings);

 private:
  Decoded decode(const Message& message, std::int64_t& stamp_ns) {
    if (source_->topics()[message.topic].encoding == Encoding::ros1) {
      return ros1_.decode(message.data, stamp_ns, values_, absent_);
    }
    if (compression_of(message.data) != Compression::zstd) return cdr_.decode(message.data, stamp_ns, values_, absent_);
    const Unpacked unpacked = unpacker_->unpack(Compression::zstd, message.data, std::nullopt);
    if (!unpacked.fault.empty()) return Decoded::other_length;
    return cdr_.decode(unpacked.bytes, stamp_ns, values_, absent_);
  }
  void tell_left_out(Findings& findings) const;
  void tell_absent(Findings& findings) const;
  void tell_zeros(Findings& findings) const;

  const MessageType& type_;
  std::vector<std::size_t> members_;
  MessageDecoder ros1_, cdr_;
  std::vector<double> values_;
  std::vector<std::vector<double>> columns_;
  std::vector<std::int64_t> absent_;        ///< by mark
  std::array<std::int64_t, 3> left_out_{};  ///< by Decoded
  Stamps stamps_;
  const MessageSource* source_ = nullptr;
  std::optional<Unpacker> unpacker_;
};

void RowSink::tell_left_out(Findings& findings) const {
  const std::int64_t length = left_out_[static_cast<std::size_t>(Decoded::other_length)];
  const std::int64_t encoding = left_out_[static_cast<std::size_t>(Decoded::other_encoding)];
  if (length > 0) {
    findings.add(
        fmt::format("{} messages are left out: they have not the length of {}", text::count_text(length), type_.name));
  }
  if (encoding > 0) {
    findings.add(fmt::format(
        "{} messages are left out: they are no plain CDR, which begins with the bytes 00 and 00, 01, 06 or 07",
        text::count_text(encoding)));
  }
}

void RowSink::tell_absent(Findings& findings) const {
  for (std::size_t i = 0; i < absent_.size(); ++i) {
    if (absent_[i] == 0) continue;
    findings.add(fmt::format("{} rows say that they have no such value ({}): NaN", text::count_text(absent_[i]),
                             type_.marks[i].words));
  }
}

/// Drivers that know one half of a message fill the other with zeros.
void RowSink::tell_zeros(Findings& findings) const {
  std::map<std::string, bool> is_zero;  // by vector
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const std::string& name = type_.members[members_[i]].name;
    const std::size_t dot = name.rfind('.');
    if (type_.kind == StreamKind::gnss || dot == std::string::npos || columns_[i].empty()) continue;
    const bool zero = std::ranges::all_of(columns_[i], [](double value) { return value == 0; });
    const auto [at, is_new] = is_zero.try_emplace(name.substr(0, dot), zero);
    at->second = at->second && zero;
  }
  for (const auto& [name, zero] : is_zero) {
    if (zero) findings.add(fmt::format("{} is 0 in every row: the sensor was dead, or its driver has none", name));
  }
}

/// Seconds of 32 bits come to their end in 2038 or 2106, and begin again.
void tell_wraps(std::span<const std::int64_t> stamps_ns, Findings& findings) {
  constexpr std::int64_t kWrap = (std::int64_t{1} << 32U) * 1'000'000'000, kDay = 86'400'000'000'000;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) {
    // Stamps of a header are less than 2^33 s apart.
    const std::int64_t step = stamps_ns[i] - stamps_ns[i - 1];
    if (std::abs(std::abs(step) - kWrap) > kDay) continue;
    findings.add(
        fmt::format("the stamp of row {} is 2^32 s off the one before: its writer counted seconds in 32 bits", i));
  }
}

Rows RowSink::rows(Findings& findings) {
  Rows rows;
  const std::int64_t constant = stamps_.constant();
  const bool are_headers = stamps_.take(rows.stamps_ns);
  rows.clock = are_headers ? kHeaderClock : kRecordClock;
  if (!are_headers) {
    findings.add(fmt::format(
        "{} is {} in every message: the times of recording stand in for it, with the jitter of their transport",
        kHeaderClock, constant == 0 ? "0" : "the same"));
  }
  if (are_headers) tell_wraps(rows.stamps_ns, findings);
  tell_left_out(findings);
  tell_absent(findings);
  tell_zeros(findings);
  rows.columns = std::move(columns_);
  const std::int64_t left_out = std::accumulate(left_out_.begin(), left_out_.end(), std::int64_t{0});
  if (rows.stamps_ns.empty() && left_out > 0) {
    text::fail(source_->name(),
               fmt::format("not one of {} messages has the layout of {}; ask for another topic, or record it again",
                           text::count_text(left_out), type_.name));
  }
  return rows;
}

/// When the messages of a stream were recorded whose type is not read.
class TimeSink : public MessageSink {
 public:
  explicit TimeSink(std::int64_t rows) { stamps_ns.reserve(static_cast<std::size_t>(rows)); }
  void begin_file(const MessageSource& /*source*/) override {}
  void take(const Message& message) override { stamps_ns.push_back(message.record_ns); }

  std::vector<std::int64_t> stamps_ns;
};

/// Between the files of a recording and a sink: what ends one file and begins the next is taken once.
class SeamSink : public MessageSink {
 public:
  explicit SeamSink(MessageSink& sink) : sink_(sink) {}
  void begin_file(const MessageSource& source) override {
    seam_.begin_file();
    sink_.begin_file(source);
  }
  void take(const Message& message) override {
    if (seam_.repeats(message)) {
      ++repeated_;
    } else {
      sink_.take(message);
    }
  }
  void tell(Findings& findings) const {
    if (repeated_ == 0) return;
    findings.add(fmt::format("{} messages are left out: they end one file and begin the next", repeated_));
  }

 private:
  MessageSink& sink_;
  Seam seam_;
  std::int64_t repeated_ = 0;
};

}  // namespace

MessageRecording::MessageRecording(std::string format, std::vector<std::unique_ptr<MessageSource>> sources,
                                   std::vector<std::string> notes)
    : format_(std::move(format)), sources_(std::move(sources)), notes_(std::move(notes)) {
  for (const auto& source : sources_) {
    for (std::string& text : source->findings().texts()) {
      notes_.push_back(sources_.size() == 1 ? std::move(text) : fmt::format("{}: {}", source->name(), text));
    }
  }
  add_streams();
}

MessageRecording::MessageRecording(std::string format, std::unique_ptr<MessageSource> source)
    : format_(std::move(format)), notes_(source->findings().texts()) {
  sources_.push_back(std::move(source));
  add_streams();
}

void MessageRecording::add_streams() {
  for (const auto& source : sources_) {
    auto& streams = stream_of_.emplace_back();
    for (const Topic& topic : source->topics()) {
      const MessageType* type = read_type(topic);
      const std::string key = type ? fmt::format("{}\n{}", topic.name, type->name)
                                   : fmt::format("{}\n{}\nnot read", topic.name, topic.type);
      const auto [at, is_new] = by_topic_.try_emplace(key, streams_.size());
      if (is_new) add_stream(topic);
      streams_[at->second].count += topic.count;
      streams.push_back(at->second);
    }
  }
  for (std::string& text : shared_names_.texts()) notes_.push_back(std::move(text));
}

void MessageRecording::add_stream(const Topic& topic) {
  std::string name = text::printable(topic.name);
  const auto [at, is_alone] = numbers_.try_emplace(name, 1);
  if (!is_alone) {
    std::int64_t& number = at->second;  // it stays where it is when others are added
    const std::string shared = std::move(name);
    do {
      name = fmt::format("{} #{}", shared, ++number);
    } while (!numbers_.try_emplace(name, 1).second);
    shared_names_.add(fmt::format("{} is the name of several streams: that of type {} is called {}",
                                  text::quoted(topic.name), text::quoted(topic.type), text::quoted(name)));
  }
  streams_.push_back(stream_of(topic, std::move(name)));
}

void MessageRecording::visit(std::size_t stream, MessageSink& sink, Findings& findings) const {
  std::int64_t messages = 0;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    std::vector<bool> wanted;
    for (const std::size_t of : stream_of_[i]) wanted.push_back(of == stream);
    if (std::ranges::find(wanted, true) == wanted.end()) continue;
    sink.begin_file(*sources_[i]);
    messages += sources_[i]->visit(wanted, sink, findings);
  }
  const std::int64_t count = streams_[stream].count;
  if (messages == count) return;
  findings.add(
      fmt::format("the index counts {} messages, there are {}", text::count_text(count), text::count_text(messages)));
}

Rows MessageRecording::read(std::size_t stream, std::span<const std::size_t> fields) const {
  const StreamInfo& info = streams_.at(stream);
  for (const std::size_t field : fields) static_cast<void>(info.fields.at(field));
  // A count may come from an index that lies: no file has more messages than bytes.
  std::uint64_t most = 0;
  for (const auto& source : sources_) most += source->bytes();
  const std::int64_t rows = std::min(info.count, to_signed(most));

  Findings findings;
  const auto visit_files = [&](MessageSink& sink) {
    if (sources_.size() == 1) return visit(stream, sink, findings);
    SeamSink seams(sink);
    visit(stream, seams, findings);
    seams.tell(findings);
  };
  Rows result;
  if (info.fields.empty()) {
    TimeSink sink(rows);
    visit_files(sink);
    result.stamps_ns = std::move(sink.stamps_ns);
    result.clock = kRecordClock;
  } else {
    const MessageType& type = *message_type(info.type);
    const std::vector<std::size_t> offered = offered_members(type);
    std::vector<std::size_t> members;
    for (const std::size_t field : fields) members.push_back(offered[field]);
    RowSink sink(type, members, rows);
    visit_files(sink);
    result = sink.rows(findings);
  }
  result.notes = findings.texts();
  return result;
}

}  // namespace gyrobudget::inline v0::log
