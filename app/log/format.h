// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

/// How the samples of a log are written down.
enum class Format {
  csv,  ///< text, see read_log
  f32,  ///< raw IEEE 754 numbers of 4 bytes, little-endian, row after row
  f64,  ///< the same of 8 bytes
  npy,  ///< NumPy's .npy of one array, 1-D or 2-D (samples x columns) in C order, dtype <f4 or <f8
};

[[nodiscard]] std::string_view name(Format);
[[nodiscard]] std::optional<Format> format_named(std::string_view);
/// What the ending of a path says, whether in capitals or not: .npy, .f64 and .f32, also before .gz, .zst, .bz2 and
/// .lz4; text for all others.
[[nodiscard]] Format format_of(std::string_view path);

}  // namespace gyrobudget::inline v0::log
