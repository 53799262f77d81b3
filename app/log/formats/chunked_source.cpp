// SPDX-License-Identifier: MIT
#include "chunked_source.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "crc32.h"

namespace gyrobudget::inline v0::log {
namespace {

/// What records are read from a mapped file at a time, before it may leave memory again.
constexpr std::size_t kStep = std::size_t{1} << 20;

/// Counts messages, and keeps what is declared.
class CountingSink : public RecordSink {
 public:
  void message(std::uint32_t id, std::int64_t /*record_ns*/, std::string_view /*data*/) override {
    if (!last_ || id != id_) {
      last_ = &counts[id];
      id_ = id;
    }
    ++*last_;
  }
  void declaration(std::string_view record) override { declarations.emplace_back(record); }

  Counts counts;
  std::vector<std::string> declarations;

 private:
  std::uint32_t id_ = 0;
  std::int64_t* last_ = nullptr;  // elements of the map stay where they are
};

/// Passes on the messages of some topics.
class FilterSink : public RecordSink {
 public:
  FilterSink(const std::unordered_map<std::uint32_t, std::size_t>& topic_of, const std::vector<bool>& wanted,
             MessageSink& sink)
      : topic_of_(topic_of), wanted_(wanted), sink_(sink) {}

  void message(std::uint32_t id, std::int64_t record_ns, std::string_view data) override {
    if (id != id_ || !is_known_) look_up(id);
    if (!is_wanted_) return;
    ++passed_;
    sink_.take({topic_, record_ns, data});
  }
  void declaration(std::string_view /*record*/) override {}
  [[nodiscard]] std::int64_t passed() const { return passed_; }

 private:
  void look_up(std::uint32_t id) {
    const auto at = topic_of_.find(id);
    id_ = id;
    is_known_ = true;
    is_wanted_ = at != topic_of_.end() && wanted_[at->second];
    if (is_wanted_) topic_ = at->second;
  }

  const std::unordered_map<std::uint32_t, std::size_t>& topic_of_;
  const std::vector<bool>& wanted_;
  MessageSink& sink_;
  std::uint32_t id_ = 0;
  std::size_t topic_ = 0;
  std::int64_t passed_ = 0;
  bool is_known_ = false, is_wanted_ = false;
};

}  // namespace

void ChunkedSource::passed(std::string_view rest) {
  const std::size_t at = file().size() - rest.size();
  if (at - passed_ < kStep && !rest.empty()) return;
  file_.release(file().substr(passed_, at - passed_));
  passed_ = at;
}

void ChunkedSource::declare(std::uint32_t id, Topic topic) {
  const auto [at, is_new] = topic_of_.try_emplace(id, topics_.size());
  if (is_new) {
    topics_.push_back(std::move(topic));
    return;
  }
  const Topic& first = topics_[at->second];
  if (first.name == topic.name && first.type == topic.type) return;
  findings_.add(fmt::format("number {} is declared as {} and again as {}: the first holds", id,
                            text::quoted(first.name), text::quoted(topic.name)));
}

void ChunkedSource::add_chunk(Part chunk) {
  require_library(chunk.packing, name());
  chunk.is_chunk = true;
  parts_.push_back(std::move(chunk));
}

void ChunkedSource::add_loose(std::string_view record) {
  if (!parts_.empty() && !parts_.back().is_chunk) {
    std::string_view& last = parts_.back().bytes;
    if (last.data() + last.size() == record.data()) {
      last = {last.data(), last.size() + record.size()};
      return;
    }
  }
  parts_.push_back({.bytes = record});
}

void ChunkedSource::count_loose_messages() {
  Unpacker unpacker(name());
  for (Part& part : parts_) {
    if (!part.is_chunk) count(part, unpacker);
  }
}

void ChunkedSource::count_chunks() {
  Unpacker unpacker(name());
  for (Part& part : parts_) {
    if (part.is_chunk) count(part, unpacker);
  }
}

Counts ChunkedSource::counts() const {
  Counts all;
  for (const Part& part : parts_) {
    for (const auto& [id, messages] : part.counts) all[id] += messages;
  }
  return all;
}

void ChunkedSource::finish() {
  for (const auto& [id, messages] : counts()) {
    const auto at = topic_of_.find(id);
    if (at != topic_of_.end()) {
      topics_[at->second].count += messages;
    } else {
      findings_.add(
          fmt::format("{} messages are left out: nothing declares their number {}", text::count_text(messages), id));
    }
  }
}

void ChunkedSource::count(Part& part, Unpacker& unpacker) {
  CountingSink sink;
  read(part, unpacker, sink, findings_);
  for (const std::string& record : sink.declarations) read_declaration(record);
  part.counts = std::move(sink.counts);
}

bool ChunkedSource::holds(const Part& part, const std::vector<bool>& wanted) const {
  return std::ranges::any_of(part.counts, [&](const auto& entry) {
    const auto at = topic_of_.find(entry.first);
    return at != topic_of_.end() && wanted[at->second];
  });
}

std::string_view ChunkedSource::unpack(const Part& part, Unpacker& unpacker, Findings& findings) const {
  Unpacked unpacked = unpacker.unpack(part.packing, part.bytes, part.size);
  if (part.is_cut) return unpacked.bytes;
  if (unpacked.fault.empty() && part.crc && crc32_of(unpacked.bytes) != *part.crc) {
    unpacked.fault = "the check sum does not fit";
  }
  if (!unpacked.fault.empty()) {
    findings.add(fmt::format("the chunk at byte {} is damaged ({}): what could be read of it is kept",
                             place(part.bytes), unpacked.fault));
  }
  return unpacked.bytes;
}

void ChunkedSource::read(const Part& part, Unpacker& unpacker, RecordSink& sink, Findings& findings) const {
  std::string_view rest = unpack(part, unpacker, findings);
  const bool is_mapped = part.packing == Compression::none;
  std::size_t step = is_mapped ? kStep : rest.size();
  while (!rest.empty()) {
    const std::string_view piece = rest.substr(0, step);
    const std::size_t taken = read_records(piece, sink);
    rest.remove_prefix(taken);
    if (is_mapped) file_.release(piece.substr(0, taken));
    if (taken > 0) continue;
    if (piece.size() == rest.size()) break;  // not one whole record is left
    step *= 2;
  }
  if (!is_mapped) file_.release(part.bytes);
  if (!rest.empty() && !part.is_cut) {
    findings.add(
        fmt::format("{} bytes in the part at byte {} are no whole record: left out", rest.size(), place(part.bytes)));
  }
}

std::int64_t ChunkedSource::visit(const std::vector<bool>& wanted, MessageSink& sink, Findings& findings) const {
  Unpacker unpacker(name());
  FilterSink filter(topic_of_, wanted, sink);
  for (const Part& part : parts_) {
    if (holds(part, wanted)) read(part, unpacker, filter, findings);
  }
  return filter.passed();
}

}  // namespace gyrobudget::inline v0::log
