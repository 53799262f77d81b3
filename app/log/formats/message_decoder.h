// SPDX-License-Identifier: MIT
// Messages as ROS 1 and CDR, of ROS 2, serialize them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "message_types.h"

namespace gyrobudget::inline v0::log {

enum class Encoding { ros1, cdr, other };

/// What a message says.
enum class Decoded {
  whole,
  other_length,    ///< its length is not that of the type
  other_encoding,  ///< CDR with parameter lists or delimiters, or no CDR
};

/// Takes the stamp and some numbers out of the messages of one type. ROS 1 packs them; CDR, of either byte order,
/// aligns each to its own size (XCDR2: to 4 bytes at most), counted from behind its first four bytes.
class MessageDecoder {
 public:
  /// @param type  which must outlive it @param members  places in MessageType::members
  MessageDecoder(const MessageType& type, Encoding encoding, std::span<const std::size_t> members);

  /// @param stamp_ns  gets the header's stamp [ns] @param values  one for each member: NaN where the message says that
  /// it has none, or what it has is not finite
  /// @param absent  counts, for each mark of the type, the messages in which it held
  Decoded decode(std::string_view message, std::int64_t& stamp_ns, std::span<double> values,
                 std::span<std::int64_t> absent) const;

 private:
  /// Where numbers stand behind the header: what alignment makes of a header of some length.
  struct Layout {
    std::vector<std::uint32_t> members;  ///< as asked for
    std::vector<std::uint32_t> marks;
    std::size_t size = 0;
  };
  static constexpr std::size_t kPhases = 8;  // of the header's end

  [[nodiscard]] Layout layout(std::size_t most_alignment, std::size_t phase) const;
  [[nodiscard]] Decoded decode_ros1(std::string_view message, std::int64_t& stamp_ns, std::span<double> values,
                                    std::span<std::int64_t> absent) const;
  template <bool kSwapped>
  [[nodiscard]] Decoded decode_cdr(std::string_view payload, bool is_xcdr2, std::int64_t& stamp_ns,
                                   std::span<double> values, std::span<std::int64_t> absent) const;
  template <bool kSwapped>
  void take(std::string_view body, const Layout& layout, std::span<double> values,
            std::span<std::int64_t> absent) const;

  const MessageType& type_;
  Encoding encoding_;
  std::vector<std::size_t> members_;
  std::vector<std::size_t> marks_;  ///< that one of the members has
  Layout packed_;
  std::vector<Layout> aligned_;  ///< CDR's by phase, then those of XCDR2
};

}  // namespace gyrobudget::inline v0::log
