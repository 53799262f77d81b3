// SPDX-License-Identifier: MIT
// Chunks and messages as they were before they were packed.
#pragma once

#include "gyrobudget/app/log/bytes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

enum class Packing { none, bzip2, lz4, zstd };

/// Whether bytes begin as a zstd frame does.
[[nodiscard]] bool is_zstd(std::string_view bytes);

/// What packed bytes may unpack to. No data of sensors come near it; beyond it a few bytes would fill the memory.
[[nodiscard]] std::uint64_t most_unpacked(std::size_t packed);

/// @param name  of the file that needs it, for the message
/// @throws text::InputError where this build leaves the library out; it names Debian's package.
void require_packing(std::string_view name, Packing packing);

struct Unpacked {
  std::string_view bytes;  ///< up to where it ended or was damaged
  std::string fault;       ///< "the packed bytes end early"; empty where it was whole
};

/// Unpacks one piece after the other into the same memory, which takes no more than the largest of them.
class Unpacker {
 public:
  /// @param name  of the file, for messages
  explicit Unpacker(std::string name) : name_(std::move(name)) {}

  /// @param size  that the unpacked bytes have, by the file; what it cannot be, to that many packed bytes, is a fault
  /// @return bytes that are valid until the next call; `packed` itself for Packing::none
  /// @throws text::InputError where this build leaves the library out.
  Unpacked unpack(Packing packing, std::string_view packed, std::optional<std::uint64_t> size);

 private:
  std::string name_;
  Pages pages_;
};

}  // namespace gyrobudget::inline v0::log
