// SPDX-License-Identifier: MIT
// Chunks and messages as they were before they were packed.
#pragma once

#include "gyrobudget/app/log/bytes.h"
#include "gyrobudget/app/log/compression.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace gyrobudget::inline v0::log {

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
  /// @return bytes that are valid until the next call; `packed` itself for Compression::none
  /// @throws text::InputError where this build leaves the library out.
  Unpacked unpack(Compression compression, std::string_view packed, std::optional<std::uint64_t> size);

 private:
  /// Of the last piece, at the beginning of a frame.
  Decompressor& decompressor(Compression compression);

  std::string name_;
  Pages pages_;
  Compression compression_ = Compression::none;
  std::unique_ptr<Decompressor> decompressor_;
};

}  // namespace gyrobudget::inline v0::log
