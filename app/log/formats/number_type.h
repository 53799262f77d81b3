// SPDX-License-Identifier: MIT
// Numbers as recordings hold them.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

namespace gyrobudget::inline v0::log {

static_assert(std::endian::native == std::endian::little, "numbers of recordings are copied as they are");

enum class NumberType : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f16, f32, f64 };

[[nodiscard]] constexpr std::size_t size_of(NumberType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}
[[nodiscard]] constexpr bool is_floating(NumberType type) { return type >= NumberType::f16; }

/// The little-endian number at a place of which the caller knows that it is in the text.
template <class Number>
[[nodiscard]] Number load(const char* at) {
  Number number;
  std::memcpy(&number, at, sizeof number);
  return number;
}
template <class Number>
[[nodiscard]] Number load(std::string_view text, std::size_t at) {
  return load<Number>(text.data() + at);
}

/// IEEE 754 binary16.
[[nodiscard]] inline double half_to_double(std::uint16_t half) {
  constexpr int kFraction = 10, kBias = 15, kSpecial = 31;
  const int exponent = half >> kFraction & kSpecial;
  const double fraction = (half & 0x3ff) / 1024.0;
  double magnitude = 0;
  if (exponent == kSpecial) {
    magnitude = fraction == 0 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  } else {
    magnitude = exponent == 0 ? std::ldexp(fraction, 1 - kBias) : std::ldexp(1 + fraction, exponent - kBias);
  }
  return half >> 15 ? -magnitude : magnitude;
}

/// The number at a place as a double: rounded where it is an integer beyond 2^53.
[[nodiscard]] inline double to_double(NumberType type, const char* at) {
  switch (type) {
    case NumberType::i8:
      return load<std::int8_t>(at);
    case NumberType::u8:
      return load<std::uint8_t>(at);
    case NumberType::i16:
      return load<std::int16_t>(at);
    case NumberType::u16:
      return load<std::uint16_t>(at);
    case NumberType::i32:
      return load<std::int32_t>(at);
    case NumberType::u32:
      return load<std::uint32_t>(at);
    case NumberType::i64:
      return static_cast<double>(load<std::int64_t>(at));
    case NumberType::u64:
      return static_cast<double>(load<std::uint64_t>(at));
    case NumberType::f16:
      return half_to_double(load<std::uint16_t>(at));
    case NumberType::f32:
      return load<float>(at);
    case NumberType::f64:
      break;
  }
  return load<double>(at);
}

/// Whole numbers only, for counts and stamps: what is negative is huge.
[[nodiscard]] inline std::uint64_t to_unsigned(NumberType type, const char* at) {
  switch (type) {
    case NumberType::i8:
      return static_cast<std::uint64_t>(load<std::int8_t>(at));
    case NumberType::u8:
      return load<std::uint8_t>(at);
    case NumberType::i16:
      return static_cast<std::uint64_t>(load<std::int16_t>(at));
    case NumberType::u16:
      return load<std::uint16_t>(at);
    case NumberType::i32:
      return static_cast<std::uint64_t>(load<std::int32_t>(at));
    case NumberType::u32:
      return load<std::uint32_t>(at);
    case NumberType::i64:
    case NumberType::u64:
      return load<std::uint64_t>(at);
    case NumberType::f16:
    case NumberType::f32:
    case NumberType::f64:
      break;
  }
  const double value = to_double(type, at);
  constexpr double kMost = 9e18;
  return value >= 0 && value < kMost ? static_cast<std::uint64_t>(value) : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace gyrobudget::inline v0::log
