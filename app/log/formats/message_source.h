// SPDX-License-Identifier: MIT
// A file of messages, whatever holds them: a bag, an MCAP or a database.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "findings.h"
#include "message_decoder.h"

namespace gyrobudget::inline v0::log {

/// A topic as one connection, one channel or one row of a table declares it: several may have the same name.
struct Topic {
  std::string name;
  std::string type;
  Encoding encoding = Encoding::other;
  std::int64_t count = 0;  ///< of messages
};

struct Message {
  std::size_t topic = 0;       ///< its place in MessageSource::topics()
  std::int64_t record_ns = 0;  ///< when it was recorded
  std::string_view data;       ///< valid until the next message
};

class MessageSource;

class MessageSink {
 public:
  virtual ~MessageSink() = default;
  /// The messages that follow are of this file.
  virtual void begin_file(const MessageSource& source) = 0;
  virtual void take(const Message& message) = 0;
};

/// An opened file. Visiting is const and keeps nothing: two threads may visit.
class MessageSource {
 public:
  MessageSource() = default;
  MessageSource(const MessageSource&) = delete;
  MessageSource& operator=(const MessageSource&) = delete;
  virtual ~MessageSource() = default;

  [[nodiscard]] virtual const std::string& name() const = 0;  ///< of the file
  [[nodiscard]] virtual std::uint64_t bytes() const = 0;      ///< of the file
  /// In the order of the file.
  [[nodiscard]] virtual const std::vector<Topic>& topics() const = 0;
  [[nodiscard]] virtual const Findings& findings() const = 0;  ///< of the whole file
  /// Gives the messages of some topics in the order in which they were recorded.
  /// @param wanted  one for each topic: whether it is visited @param findings  gets what is damaged
  /// @return how many there were
  virtual std::int64_t visit(const std::vector<bool>& wanted, MessageSink& sink, Findings& findings) const = 0;
};

/// A number below 2^63, as a time or a count; what is beyond is damaged and becomes the largest.
[[nodiscard]] constexpr std::int64_t to_signed(std::uint64_t value) {
  constexpr std::uint64_t kMost = ~std::uint64_t{0} >> 1U;
  return static_cast<std::int64_t>(value < kMost ? value : kMost);
}

}  // namespace gyrobudget::inline v0::log
