// SPDX-License-Identifier: MIT
// A measured curve as it is quoted: deviations with their intervals.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deviation.h"
#include "identify.h"

namespace gyrobudget::inline v0::allan {

/// One averaging time of a measured curve. Deviations in SI units of the axis' signal; time deviations in those times
/// s.
struct DeviationPoint {
  std::int64_t m = 1;       ///< averaging factor, samples
  double tau_s = 0;         ///< averaging time: m / rate, for Theo1 0.75 m / rate
  double deviation = 0;     ///< its bias divided out
  double lower = 0;         ///< 95 %, chi-square with `edf`
  double upper = 0;         ///< 95 %
  double edf = 0;           ///< equivalent degrees of freedom
  std::int64_t terms = 0;   ///< overlapping differences averaged
  int alpha = 0;            ///< power law S ~ f^alpha identified at this tau
  std::int64_t stride = 1;  ///< samples from one term to the next
  double bias = 1;          ///< expectation of the estimator's variance over the one it is named for
};

/// The points of a curve that have a finite variance, with the degrees of freedom and the 95 % interval of
/// statistics.h.
/// @param curve       any of family.h
/// @param identified  the noise at each point, white where there is none
/// @param mix         where given, the degrees of freedom are those of this model's noise instead
[[nodiscard]] std::vector<DeviationPoint> deviation_points(const Curve& curve,
                                                           std::span<const Identified> identified = {},
                                                           std::span<const noise::Process> mix = {});

}  // namespace gyrobudget::inline v0::allan
