// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deviation.h"
#include "series.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::allan {

struct DynamicOptions {
  std::int64_t window = 0;  ///< samples of one window; 0: a sixteenth of the record, at least 32
  std::int64_t hop = 0;     ///< samples from one window to the next; 0: a quarter of the window
};

/// Allan variance as a function of time and averaging time (dynamic Allan variance; L. Galleani, P. Tavella,
/// IEEE Trans. UFFC 56 (2009) 450): warm-up, temperature, turn-on and other effects that one curve of a whole
/// record hides.
struct DynamicSurface {
  double dt = 1;             ///< sample interval [s]
  std::int64_t window = 0;   ///< samples of each window
  std::int64_t hop = 0;      ///< samples between windows
  std::vector<double> time;  ///< middle of each window, from the first sample [s]
  std::vector<std::int64_t> factors;
  Eigen::MatrixXd variance;  ///< windows x factors [signal^2]; NaN where no term counts
  Eigen::Matrix<std::int64_t, Eigen::Dynamic, Eigen::Dynamic> terms;  ///< likewise
  [[nodiscard]] double tau(std::size_t i) const { return static_cast<double>(factors[i]) * dt; }
  /// One window as a curve, for its statistics; it carries no mask (see statistics.h).
  [[nodiscard]] Curve curve(std::size_t window_index) const;
};

/// Fully overlapped Allan variance of windows of a record at m = 1 .. window/2. The windows share their
/// terms: the record is gone through once per factor, in stretches between the ends of windows, so
/// overlapping windows cost almost nothing.
///
/// A complete window has the value that overlapped_variance has for it, to 1e-12 where the windows' variances
/// are alike and drifts are small (see there). Samples behind the last whole window are left out.
/// @param factors 1 <= m <= window/2, in any order; see factors.h.
/// @throws std::invalid_argument for a window shorter than 2 or longer than the record, a hop below 1, or a
/// factor out of range. Cost: O(n) per factor; the result has windows x factors numbers. Same bytes at any
/// number of threads.
[[nodiscard]] DynamicSurface dynamic_variance(const Series& record, std::span<const std::int64_t> factors,
                                              const DynamicOptions& wanted = {});

/// The window and hop that options stand for.
[[nodiscard]] DynamicOptions resolved(const DynamicOptions& options, std::int64_t samples);

}  // namespace gyrobudget::inline v0::allan
