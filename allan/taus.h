// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "estimator.h"

namespace gyrobudget::inline v0::allan {

/// Which averaging times a curve is to have, as a value that is chosen before the length of the record is known.
struct Taus {
  enum class Kind { octave, decade, all, logarithmic };
  Kind kind = Kind::octave;
  std::int64_t count = 0;  ///< how many, for `logarithmic`; the other kinds do not read it
  bool operator==(const Taus&) const = default;
};

/// The averaging factors of this choice for a record of `samples`, in the range of the overlapped Allan variance; see
/// factors.h.
/// @throws std::invalid_argument for `logarithmic` with a count below 1.
[[nodiscard]] std::vector<std::int64_t> factors_of(const Taus& taus, std::int64_t samples);

/// The same choice over the range in which `estimator` has a term, which can be longer or shorter than n/2.
[[nodiscard]] std::vector<std::int64_t> factors_of(const Taus& taus, Estimator estimator, std::int64_t samples);

}  // namespace gyrobudget::inline v0::allan
