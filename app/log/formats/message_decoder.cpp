// SPDX-License-Identifier: MIT
#include "message_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "byte_reader.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The number at `at`, its bytes the other way round where they are big-endian.
template <class Number, bool kSwapped>
Number number_at(const char* at) {
  if constexpr (!kSwapped || sizeof(Number) == 1) {
    return load<Number>(at);
  } else {
    std::array<char, sizeof(Number)> bytes;
    std::reverse_copy(at, at + sizeof(Number), bytes.begin());
    return load<Number>(bytes.data());
  }
}

template <bool kSwapped>
double value_at(const char* at, Primitive primitive) {
  switch (primitive) {
    case Primitive::i8:
      return static_cast<signed char>(*at);
    case Primitive::u8:
      return static_cast<unsigned char>(*at);
    case Primitive::u16:
      return number_at<std::uint16_t, kSwapped>(at);
    case Primitive::i32:
      return number_at<std::int32_t, kSwapped>(at);
    case Primitive::u32:
      return number_at<std::uint32_t, kSwapped>(at);
    case Primitive::f64:
      break;
  }
  return number_at<double, kSwapped>(at);
}

}  // namespace

MessageDecoder::MessageDecoder(const MessageType& type, Encoding encoding, std::span<const std::size_t> members)
    : type_(type), encoding_(encoding), members_(members.begin(), members.end()) {
  for (std::size_t mark = 0; mark < type.marks.size(); ++mark) {
    const auto has_it = [&](std::size_t member) { return type.members.at(member).mark == mark + 1; };
    if (std::ranges::any_of(members_, has_it)) marks_.push_back(mark);
  }
  constexpr std::size_t kCdr = 8, kXcdr2 = 4;  // the largest alignment
  if (encoding == Encoding::ros1) packed_ = layout(1, 0);
  if (encoding != Encoding::cdr) return;
  for (const std::size_t alignment : {kCdr, kXcdr2}) {
    for (std::size_t phase = 0; phase < kPhases; ++phase) aligned_.push_back(layout(alignment, phase));
  }
}

MessageDecoder::Layout MessageDecoder::layout(std::size_t most_alignment, std::size_t phase) const {
  std::vector<std::uint32_t> offsets;
  std::size_t at = phase;
  for (const Member& member : type_.members) {
    const std::size_t size = bytes_of(member.primitive), alignment = std::min(size, most_alignment);
    at = (at + alignment - 1) / alignment * alignment;
    offsets.push_back(static_cast<std::uint32_t>(at - phase));
    at += size;
  }
  Layout result;
  result.size = at - phase;
  for (const std::size_t member : members_) result.members.push_back(offsets[member]);
  for (const std::size_t mark : marks_) result.marks.push_back(offsets[type_.marks[mark].member]);
  return result;
}

Decoded MessageDecoder::decode(std::string_view message, std::int64_t& stamp_ns, std::span<double> values,
                               std::span<std::int64_t> absent) const {
  if (encoding_ == Encoding::ros1) return decode_ros1(message, stamp_ns, values, absent);
  constexpr std::size_t kEncapsulation = 4;
  if (encoding_ != Encoding::cdr || message.size() < kEncapsulation || message[0] != 0) return Decoded::other_encoding;
  const std::string_view payload = message.substr(kEncapsulation);
  switch (message[1]) {
    case 0:
      return decode_cdr<true>(payload, false, stamp_ns, values, absent);
    case 1:
      return decode_cdr<false>(payload, false, stamp_ns, values, absent);
    case 6:
      return decode_cdr<true>(payload, true, stamp_ns, values, absent);
    case 7:
      return decode_cdr<false>(payload, true, stamp_ns, values, absent);
    default:
      return Decoded::other_encoding;
  }
}

Decoded MessageDecoder::decode_ros1(std::string_view message, std::int64_t& stamp_ns, std::span<double> values,
                                    std::span<std::int64_t> absent) const {
  ByteReader header(message);
  header.number<std::uint32_t>();  // the sequence number
  const auto secs = header.number<std::uint32_t>(), nsecs = header.number<std::uint32_t>();
  header.prefixed();  // frame_id
  const std::string_view body = header.rest();
  const bool fits = type_.goes_on ? body.size() >= packed_.size : body.size() == packed_.size;
  if (!header.ok() || !fits) return Decoded::other_length;
  stamp_ns = secs * kNsPerS + nsecs;
  take<false>(body, packed_, values, absent);
  return Decoded::whole;
}

template <bool kSwapped>
Decoded MessageDecoder::decode_cdr(std::string_view payload, bool is_xcdr2, std::int64_t& stamp_ns,
                                   std::span<double> values, std::span<std::int64_t> absent) const {
  constexpr std::size_t kFrameId = 12, kMostPadding = 3;
  if (payload.size() < kFrameId) return Decoded::other_length;
  const std::uint64_t begin = kFrameId + std::uint64_t{number_at<std::uint32_t, kSwapped>(payload.data() + 8)};
  if (begin > payload.size()) return Decoded::other_length;
  const std::string_view body = payload.substr(static_cast<std::size_t>(begin));
  const Layout& layout = aligned_[begin % kPhases + (is_xcdr2 ? kPhases : 0)];
  if (body.size() < layout.size || (!type_.goes_on && body.size() > layout.size + kMostPadding)) {
    return Decoded::other_length;
  }
  stamp_ns = number_at<std::int32_t, kSwapped>(payload.data()) * kNsPerS +
             number_at<std::uint32_t, kSwapped>(payload.data() + 4);
  take<kSwapped>(body, layout, values, absent);
  return Decoded::whole;
}

template <bool kSwapped>
void MessageDecoder::take(std::string_view body, const Layout& layout, std::span<double> values,
                          std::span<std::int64_t> absent) const {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = value_at<kSwapped>(body.data() + layout.members[i], type_.members[members_[i]].primitive);
    values[i] = std::isfinite(value) ? value : kNaN;
  }
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const AbsenceMark& mark = type_.marks[marks_[i]];
    const Primitive primitive = type_.members[mark.member].primitive;
    if (value_at<kSwapped>(body.data() + layout.marks[i], primitive) != mark.absent) continue;
    ++absent[marks_[i]];
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (type_.members[members_[k]].mark == marks_[i] + 1) values[k] = kNaN;
    }
  }
}

}  // namespace gyrobudget::inline v0::log
