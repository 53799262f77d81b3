// SPDX-License-Identifier: MIT
// The libraries that unpack what recorders packed. Each is left out of a build that does not find it.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

/// What a library made of packed bytes.
struct PackingResult {
  std::size_t size = 0;  ///< bytes that came out, up to where it ended or was damaged
  std::string fault;     ///< in the library's words; empty where it was whole
};

inline constexpr std::string_view kPackedEndsEarly = "the packed bytes end early";
inline constexpr std::string_view kUnpacksToMore = "it unpacks to more bytes than it says";

struct PackingLibrary {
  std::string_view name;     ///< "bzip2"
  std::string_view package;  ///< Debian's, "libbz2-dev"
  /// Unpacks into `out` and no further; null where the build leaves the library out.
  PackingResult (*unpack)(std::string_view packed, std::span<char> out);
};

[[nodiscard]] const PackingLibrary& bzip2_library();  ///< one stream
[[nodiscard]] const PackingLibrary& lz4_library();    ///< one frame
[[nodiscard]] const PackingLibrary& zstd_library();   ///< frames, one behind the other

/// Unpacks what may be larger than the memory, piece by piece. Of a build without zstd the fault says that it is.
/// @param take  gets the pieces in order
/// @return the fault, empty where all was whole
[[nodiscard]] std::string unpack_zstd_stream(std::string_view packed,
                                             const std::function<void(std::string_view piece)>& take);

}  // namespace gyrobudget::inline v0::log
