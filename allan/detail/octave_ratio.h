// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/identify.h"

#include <cstdint>

#include "phase.h"

namespace gyrobudget::inline v0::allan::detail {

/// The Allan variance at a factor m over that at m/2, and what it was measured from.
struct OctaveRatio {
  double log_ratio = 0;              ///< not finite where nothing could be measured
  std::int64_t m = 2, half = 1;      ///< the two factors
  double clusters = 0;               ///< of m samples in the record
  double terms = 0, half_terms = 0;  ///< second differences averaged at m and at m/2
};

/// From second differences of cluster means that begin up to 1024 times a cluster, at m and at m/2, and at no more
/// samples than that makes in 30 clusters: the degrees of freedom of angle noise grow with their number. Those of
/// clusters without half of their samples do not count.
/// @param samples of the record. @param m from 2 to samples/2.
[[nodiscard]] OctaveRatio octave_ratio(const Phase& phase, std::int64_t samples, std::int64_t m);

/// What the ratio says of a noise that was identified from shorter factors: `term` where the ratio denies the one that
/// is there, `widest` and `share`.
///
/// Power laws have ratios of 1/4 (Q), 1/2 (N), 1 (B) and 2 (K). The logarithm of the measured one is taken as normal,
/// with the mean and the variance that chi-squares with the exact degrees of freedom and correlation of the two
/// variances have; a noise is plausible where its likelihood is at least a twentieth of the best one's.
///
/// Angle noise has degrees of freedom by the sample, so that a small part of slower noise beside it makes most of the
/// scatter: `share` is what the ratio's 95 % limit leaves room for, white noise beside it raising the ratio the least.
void tell_by_ratio(Identified& noise, const OctaveRatio& ratio);

}  // namespace gyrobudget::inline v0::allan::detail
