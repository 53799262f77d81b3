// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace gyrobudget::inline v0::allan {

/// How many terms the fully overlapped estimator has for n rate samples.
enum class Form {
  full,  ///< n - 2m + 1: the angle starts at zero before the first sample (n + 1 phase points)
  ieee,  ///< n - 2m: IEEE Std 952 and MATLAB's allanvar, whose angle starts at the first sample
};

/// Number of triples of a complete record. The first begins at sample 0 (full) or 1 (ieee).
[[nodiscard]] constexpr std::int64_t complete_terms(std::int64_t samples, std::int64_t m, Form form) {
  return samples - 2 * m + (form == Form::full ? 1 : 0);
}
[[nodiscard]] constexpr std::int64_t first_triple(Form form) { return form == Form::full ? 0 : 1; }

}  // namespace gyrobudget::inline v0::allan
