// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <vector>

#include "errors.h"

namespace gyrobudget::inline v0::navigation {

/// Flicker as a few Gauss-Markov processes, for a filter: those whose sum has the Allan variance
/// (2 ln 2/pi) B^2 most nearly from `shortest` to `longest` in the sense of the largest relative error
/// (poles and weights by least squares, reweighted towards equal peaks: Lawson's method).
///
///     decades of band   1 state   2        3        4        5        6
///     2                 37 %      4.6 %    0.62 %   0.08 %   0.01 %
///     3                 55 %      15 %     3.1 %    0.73 %   0.16 %   0.04 %
///     4                 79 %      28 %     9.3 %    2.6 %    0.79 %   0.26 %
///
/// of the Allan deviation. noise::flicker_approximation takes more poles and needs no fit.
struct FlickerStates {
  std::vector<noise::GaussMarkov> processes;  ///< fastest first
  double worst_error = 0;                     ///< largest relative error of the Allan deviation over the band
};

/// @param b         B [signal], 0 or more and finite
/// @param shortest  positive [s]
/// @param longest   above `shortest` [s], at most 1e8 of it
/// @param states    1 to 6; 0 gives none, with an error of 1
/// @throws SetupError outside these.
[[nodiscard]] FlickerStates flicker_states(double b, double shortest, double longest, int states);

}  // namespace gyrobudget::inline v0::navigation
