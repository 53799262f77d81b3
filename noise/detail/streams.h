// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/normal.h"

#include <cstdint>

namespace gyrobudget::inline v0::noise::detail {

inline constexpr int kUserBits = 48;  ///< of a stream; those above name a source

/// The stream of one source among those of a user: its kind, a letter, and how many of that kind stand before
/// it, at most 255.
[[nodiscard]] constexpr StreamKey source_stream(StreamKey user, char kind, std::uint64_t occurrence = 0) {
  const auto letter = static_cast<std::uint64_t>(static_cast<unsigned char>(kind));
  return {user.seed, user.stream | letter << kUserBits | occurrence << (kUserBits + 8)};
}

}  // namespace gyrobudget::inline v0::noise::detail
