// SPDX-License-Identifier: MIT
// What readers of recordings do alike.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../recording.h"

namespace gyrobudget::inline v0::log {

/// @throws std::out_of_range for a stream or a field that is none.
void check_request(const std::vector<StreamInfo>& streams, std::size_t stream, std::span<const std::size_t> fields);

/// What is not finite becomes NaN, and a note says how many there are.
/// @param fields  those of the columns
void finish(Rows& rows, const StreamInfo& stream, std::span<const std::size_t> fields);

/// Whether stamps tell no time: there are several, and all are the same.
[[nodiscard]] bool is_constant(std::span<const std::int64_t> stamps);
/// Median of the intervals between stamps [s]; 0 where there are fewer than two.
[[nodiscard]] double median_interval_s(std::span<const std::int64_t> stamps);

/// Says where rows are further apart than the time that each of them covers, or, where that is not known (0), than any
/// sensor is sampled: an Allan curve from them would be wrong.
void note_decimation(Rows& rows, double covered_s);

/// A name from a file, fit for one line: at most 200 bytes, control characters and broken UTF-8 replaced.
[[nodiscard]] std::string clean_name(std::string_view name);

/// Makes names of streams different from each other.
class UniqueNames {
 public:
  /// The name, with " (2)" and so on behind it where it was taken.
  [[nodiscard]] std::string take(std::string_view name);

 private:
  std::map<std::string, int> taken_;  ///< and the last number behind each
};

/// "3 messages", "1 message".
[[nodiscard]] std::string counted(std::uint64_t count, std::string_view thing);

}  // namespace gyrobudget::inline v0::log
