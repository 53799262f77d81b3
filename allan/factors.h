// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace gyrobudget::inline v0::allan {

// Averaging factors m (cluster lengths in samples) for a record of n samples: 1 <= m <= n/2, ascending, unique.
[[nodiscard]] std::vector<std::int64_t> octave_factors(std::int64_t samples);   ///< 1, 2, 4, ...
[[nodiscard]] std::vector<std::int64_t> decade_factors(std::int64_t samples);   ///< 1, 2, 4, 10, 20, 40, 100, ...
[[nodiscard]] std::vector<std::int64_t> all_factors(std::int64_t samples);      ///< 1, 2, 3, ...
/// About `count` values evenly spaced in log m; rounding to whole samples can leave fewer.
[[nodiscard]] std::vector<std::int64_t> log_factors(std::int64_t samples, std::int64_t count);

}  // namespace gyrobudget::inline v0::allan
