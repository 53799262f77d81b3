// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace gyrobudget::inline v0::allan {

// Averaging factors m (cluster lengths in samples) for a record of n samples. All lists ascend without repeats
// within 1 <= m <= n/2, the range in which the overlapped Allan variance has at least one term; they are empty
// for n < 2. A fit uses octaves: denser grids buy no accuracy and make the covariance of the curve singular.

/// 1, 2, 4, 8, ...
[[nodiscard]] std::vector<std::int64_t> octave_factors(std::int64_t samples);
/// 1, 2, 4, 10, 20, 40, 100, ...
[[nodiscard]] std::vector<std::int64_t> decade_factors(std::int64_t samples);
/// 1, 2, 3, ...: n/2 factors, hence O(n^2) work.
[[nodiscard]] std::vector<std::int64_t> all_factors(std::int64_t samples);
/// `count` values evenly spaced in log m from 1 to n/2, rounded to whole samples; rounding can leave fewer.
/// @throws std::invalid_argument for count < 1.
[[nodiscard]] std::vector<std::int64_t> log_factors(std::int64_t samples, std::int64_t count);

}  // namespace gyrobudget::inline v0::allan
