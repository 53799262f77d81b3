// SPDX-License-Identifier: MIT
#include "unpacker.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>

#include "packing_library.h"

namespace gyrobudget::inline v0::log {
namespace {

const PackingLibrary& library_of(Packing packing) {
  return packing == Packing::bzip2 ? bzip2_library() : packing == Packing::lz4 ? lz4_library() : zstd_library();
}

}  // namespace

std::uint64_t most_unpacked(std::size_t packed) {
  constexpr std::uint64_t kAlways = std::uint64_t{64} << 20, kRatio = 1024;
  return kAlways + kRatio * packed;
}

bool is_zstd(std::string_view bytes) { return bytes.starts_with("\x28\xb5\x2f\xfd"); }

void require_packing(std::string_view name, Packing packing) {
  if (packing == Packing::none) return;
  const PackingLibrary& library = library_of(packing);
  if (library.unpack) return;
  text::fail(name, fmt::format("is packed with {}, which this build leaves out; install Debian's {} and build again",
                               library.name, library.package));
}

Unpacked Unpacker::unpack(Packing packing, std::string_view packed, std::optional<std::uint64_t> size) {
  if (packing == Packing::none) return {packed, {}};
  require_packing(name_, packing);
  const std::uint64_t most = most_unpacked(packed.size()), room = size.value_or(most);
  if (room > most) return {{}, fmt::format("{} packed bytes cannot unpack to {}", packed.size(), room)};
  // Of this room the kernel gives only what is written to.
  const std::span<char> out(pages_.room(static_cast<std::size_t>(std::max<std::uint64_t>(room, 1))),
                            static_cast<std::size_t>(room));
  PackingResult result = library_of(packing).unpack(packed, out);
  if (result.fault.empty() && size && result.size != *size) {
    result.fault = fmt::format("it unpacks to {} bytes, expected {}", result.size, *size);
  }
  return {{out.data(), result.size}, std::move(result.fault)};
}

}  // namespace gyrobudget::inline v0::log
