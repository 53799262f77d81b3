// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::fit {

/// Neighbouring samples of a record.
struct Stretch {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// A stretch, its samples and their sine coefficients.
struct TransformedStretch {
  Stretch used;
  std::vector<double> rate;
  std::vector<double> coefficients;  ///< empty where the stretch has no answer
};

/// The sine coefficients of a record, its variation brought to about 1 by a power of two. The longest stretch comes
/// first, and the bins of a likelihood are its; the others add to them, each with a mean of its own.
struct Transformed : TransformedStretch {
  double dt = 1;
  double unit = 1;                             ///< signal = transformed signal * unit
  std::vector<TransformedStretch> others;      ///< in the order of time
  double missing_share = 0;                    ///< of the samples in use: filled in
  [[nodiscard]] std::int64_t samples() const;  ///< in use, of all stretches
};

/// Gaps of up to so many samples are filled in (see fill.h), longer ones end a stretch: the sensor may have been
/// switched off, and what it did meanwhile is not to be guessed.
inline constexpr std::int64_t kLongestFilled = 64;

/// A stretch counts from 16 samples on, and begins and ends where samples exist; each is trimmed at its end to a length
/// of a fast transform. Where more than a tenth of the samples would have to be filled in, none are.
/// No coefficients for fewer than 16 samples in a row, or samples all equal.
[[nodiscard]] Transformed transform_record(std::span<const double> rate, double dt);

}  // namespace gyrobudget::inline v0::fit
