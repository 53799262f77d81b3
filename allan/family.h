// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deviation.h"
#include "estimator.h"
#include "series.h"

namespace gyrobudget::inline v0::allan {

struct EstimatorOptions {
  /// Terms begin every max(1, floor(m / overlap)) samples; 0: at every sample, as textbooks have it. See
  /// Cost.
  std::int64_t overlap = 0;
  /// Strides below this are taken as 1: neighbouring terms are summed in wide registers, at the cost of every
  /// 8th alone.
  std::int64_t least_stride = 8;
  Form form = Form::full;  ///< of the oadev at every sample; all others are full
};

/// Variance curve of any estimator of a rate record (W. Riley, D. Howe, "Handbook of Frequency Stability
/// Analysis", NIST SP 1065, 2008, section 5.2). With phases x_0 .. x_n, x_k = dt (y_0 + ... + y_{k-1}), tau =
/// m dt, and < > the mean over all k for which the indices exist, the squares of the deviations are
///
///   adev, oadev    < (x[k+2m] - 2 x[k+m] + x[k])^2 > / (2 tau^2);  adev: k = 0, m, 2m, ...
///   mdev           < (mean of m of these differences, k .. k+m-1)^2 > / (2 tau^2)
///   tdev           tau^2 / 3 times mdev
///   hdev, ohdev    < (x[k+3m] - 3 x[k+2m] + 3 x[k+m] - x[k])^2 > / (6 tau^2);  hdev: k = 0, m, 2m, ...
///   totdev         < (x*[k+m] - 2 x*[k] + x*[k-m])^2 > / (2 tau^2), k = 1 .. n-1, where x* continues x by
///                  reflection about its end points, x*[-k] = 2 x[0] - x[k]
///   mtotdev        mdev of 3m neighbouring phases whose trend (that of the means of their halves) is removed
///                  and which are continued evenly to 9m, averaged over all such stretches
///   ttotdev        tau^2 / 3 times mtotdev
///   htotdev        the same for rates with the second difference of cluster means over 6; m = 1: ohdev
///   theo1          < sum_{j=1}^{m/2} (x[k] - x[k+j] + x[k+m] - x[k+m-j])^2 / j > / (0.75 (m dt)^2)
///   theobr         theo1 times the mean of oadev / theo1 at tau = 9, 12, 15 ... dt up to a tenth of the record (of
///   more
///                  than 64 such ratios 16, evenly spread)
///   theoh          oadev where 5 m <= n, theobr at 4m/3 beyond
///   pdev           72/(m^4 tau^2) < (sum_{j=0}^{m-1} ((m-1)/2 - j) (x[k+j] - x[k+j+m]))^2 >; m = 1: oadev (F.
///                  Vernotte, M. Lenczner, P.-Y. Bourgeois, E. Rubiola, IEEE Trans. UFFC 63 (2016) 611, and one term
///                  more, the last)
///
/// No other bias is removed: statistics.h knows it.
///
/// Gaps: a sample that is not finite is missing. The clusters of adev and oadev are means of what exists (see
/// Mask). For the others a missing run is bridged with the mean of as many existing samples, at least 16, on
/// either side, and a term counts where the record's minimum fill of the samples it spans exists: of N, B and
/// K the bridges take away at most the part of the variance that is missing.
///
/// @param factors averaging factors within factor_range(estimator, n), in any order.
/// @throws std::invalid_argument for a factor out of range (or odd, for Theo1), a negative overlap, or 2^31
/// samples for those whose terms cost O(m).
///
/// Error: 1e-12 of the variance against exact arithmetic for noise on any mean (see overlapped_variance);
/// drifts cost digits as they exceed 1e3 times the noise.
///
/// Cost: O(n) per factor, n/stride for second and third differences. A term of mtotdev, ttotdev, htotdev and
/// theo1 costs O(m) by itself: where a factor would need more than 2^26 steps, terms are thinned to what
/// needs as many, but to no fewer than 4 a cluster (theo1: 16), which costs N, B and K less than 1 % of the
/// degrees of freedom; an overlap that is asked for is kept to. Point::stride says what was done. Memory 8
/// bytes per sample (12 with gaps), and 8 more where gaps are bridged. Same bytes for any number of threads
/// and on any x86-64.
[[nodiscard]] Curve deviation(const Series& record, Estimator estimator, std::span<const std::int64_t> factors,
                              const EstimatorOptions& options = {});
/// The same of rates [signal] every dt [s].
[[nodiscard]] Curve deviation(std::span<const double> rate, double dt, Estimator estimator,
                              std::span<const std::int64_t> factors, const EstimatorOptions& options = {});

/// Rates of angle (phase) readings: n angles give n - 1 rates. Differences of neighbours keep every digit
/// that matters.
[[nodiscard]] std::vector<double> rates_of_angles(std::span<const double> angles, double dt);
/// Rates of angle increments over dt [s].
[[nodiscard]] std::vector<double> rates_of_increments(std::span<const double> increments, double dt);

/// The stride that deviation() takes.
[[nodiscard]] std::int64_t stride_of(Estimator estimator, std::int64_t samples, std::int64_t m,
                                     const EstimatorOptions& options = {});

}  // namespace gyrobudget::inline v0::allan
