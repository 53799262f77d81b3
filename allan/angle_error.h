// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "series.h"

namespace gyrobudget::inline v0::allan {

/// How far the integrated rate strays from its mean rate within a time: what clocks call time interval error.
struct AngleError {
  std::int64_t m = 1;   ///< [samples]
  double tau = 0;       ///< m dt [s]
  double rms = 0;       ///< TIE rms: root of < (x[k+m] - x[k])^2 > [signal s]
  double greatest = 0;  ///< MTIE: the greatest max - min of the m + 1 phases x[k] .. x[k+m] [signal s]
};

/// TIE rms and MTIE (ITU-T G.810) of a record, with x the phase (angle) about the record's mean rate: the error of an
/// angle that is integrated for tau after a calibration of the mean over the whole record. They are no estimators of
/// stability: both know the mean, flicker and random walk raise them without bound, MTIE grows with the record, and
/// neither has degrees of freedom. For budgets use the deviations.
///
/// Missing samples count as the mean rate. All NaN where no sample exists.
/// @param factors 1 <= m <= n, in any order.
/// @throws std::invalid_argument for a factor out of range.
/// Error 1e-12 relative to the largest phase. Cost: O(n) per factor and octave, 40 bytes a sample; one thread.
[[nodiscard]] std::vector<AngleError> angle_error(const Series& record, std::span<const std::int64_t> factors);

}  // namespace gyrobudget::inline v0::allan
