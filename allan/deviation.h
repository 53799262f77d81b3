// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "estimator.h"
#include "form.h"
#include "mask.h"
#include "series.h"

namespace gyrobudget::inline v0::allan {

struct DeviationOptions {
  Form form = Form::full;
  double minimum_fill = kMinimumFill;  ///< in (0, 1]; 1: clusters without gaps only
};

/// One averaging factor of a curve.
struct Point {
  std::int64_t m = 1;       ///< averaging factor [samples]
  double variance = 0;      ///< Allan variance [signal^2]; the deviation is its square root
  std::int64_t terms = 0;   ///< number of terms averaged; 0 where none counts, and then the variance is NaN
  std::int64_t stride = 1;  ///< samples from one term to the next; 1 = fully overlapped
};

/// A variance curve, of the overlapped Allan variance unless `estimator` says otherwise, and what is needed to know its
/// statistics: `samples`, `form` and `mask` are what CurveCovariance and equivalent_dof ask for.
struct Curve {
  double dt = 1;             ///< sample interval [s]
  std::int64_t samples = 0;  ///< length of the record, missing ones included
  double mean = 0;           ///< of the samples that exist [signal]; NaN where none does
  Form form = Form::full;
  std::vector<Point> points;         ///< in the order of the factors asked for
  std::shared_ptr<const Mask> mask;  ///< null for a complete record
  Estimator estimator = Estimator::oadev;
  /// Averaging time of point i [s]: m dt, but 0.75 m dt for Theo1.
  [[nodiscard]] double tau(std::size_t i) const { return averaging_time(estimator, points[i].m, dt); }
};

/// Fully overlapped Allan variance (IEEE Std 952; NIST SP 1065 eq. 11) of n rates y, each the mean over dt:
///
///   s(m) = 1/(2 M) sum_k (Y[k+m] - Y[k])^2,  Y[k] = (y[k] + ... + y[k+m-1]) / m,  k = 0 .. M-1, M = n - 2m + 1
///
/// or, for Form::ieee, k = 1 .. n-2m. NaN and infinite samples are missing: see Mask for which clusters then count.
/// Their loss changes what s(m) estimates a little; Mask::expectation_ratio says by how much and s(m) is left as it
/// comes.
///
/// @param rate rates [signal]; for angle increments divide by dt, for angles difference first.
/// @param dt sample interval [s].
/// @param factors averaging factors m in any order, repeats allowed, each 1 <= m <= n/2 (see factors.h).
/// @throws std::invalid_argument for dt that is not positive and finite, a factor out of range, a minimum fill
/// outside (0, 1], a record of 2^32 samples or more with gaps, or samples whose sum overflows.
///
/// Error: below 1e-12 of s(m) against exact arithmetic on the same doubles for noise on any mean, also where the mean
/// is 1e9 times the noise; drifts cost digits only as they exceed 1e6 times the noise within 4096 samples (m <= 4096)
/// or in the whole record (m above). Samples apart from their mean must lie in 1e-150 .. 1e150 or be 0: squares
/// beyond that leave double and give 0 or infinity.
///
/// Cost: O(n) per factor, in cache-sized tiles that serve up to 256 factors at a time; memory 8
/// bytes per sample (12 with gaps) where a factor exceeds 4096. The result has the same bytes for any number of
/// threads and on any x86-64.
[[nodiscard]] Curve overlapped_variance(std::span<const double> rate, double dt, std::span<const std::int64_t> factors,
                                        const DeviationOptions& options = {});
/// The same of a record made ready before, whose minimum fill holds.
[[nodiscard]] Curve overlapped_variance(const Series& data, std::span<const std::int64_t> factors,
                                        Form form = Form::full);

}  // namespace gyrobudget::inline v0::allan
