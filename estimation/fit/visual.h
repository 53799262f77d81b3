// SPDX-License-Identifier: MIT
#pragma once

#include "fit.h"

namespace gyrobudget::inline v0::fit {

/// The three readings of the source paper, as a person makes them on the log-log plot:
///   N = deviation at 1 s (slope -1/2 from the nearest tau where 1 s is outside the curve),
///   B = smallest deviation over tau <= T/10, divided by sqrt(2 ln2/pi) = 0.664,
///   K = the point right of the minimum whose slope is nearest +1/2, taken along +1/2 to tau = 3 s.
/// Here for comparison, not for use: the minimum is the crossing of N and K, sqrt(2 N K/sqrt 3 + 0.441 B^2), so B
/// comes out 122 to 377 % high for the paper's gyros, and K scatters by 25 % (1 sigma) in 10 h.
/// Intervals are those of the read deviations alone and know nothing of these errors; there is no p-value (NaN), and
/// the verdict goes by the misfit of the model that the readings make.
/// @param curve any ascending factors, dense ones too; at least two points with terms.
/// @throws std::invalid_argument for fewer.
/// Source: Nunes et al., sections II and III; IEEE Std 952-2020 annex C.
[[nodiscard]] Result read_visually(const allan::Curve& curve, const Options& options = {});

/// Slope picking as published tools do it: of the straight lines of slope -1/2, 0 and +1/2 in the log-log plot, each
/// through the tau where the curve's own slope (to the next tau) comes nearest to that, N is read at 1 s, B as the
/// level over 0.664, K at 3 s. Nothing keeps the flat or the rise from being found in the scatter of the last taus.
/// Intervals, verdict and refusals as above.
/// Source: the worked example of MATLAB's allanvar ("Inertial Sensor Noise Analysis Using Allan Variance"), restated.
[[nodiscard]] Result read_slopes(const allan::Curve& curve, const Options& options = {});

}  // namespace gyrobudget::inline v0::fit
