// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "deviation.h"

namespace gyrobudget::inline v0::allan {

/// Fully overlapped Allan variance at m = 1, 2, 4, ... <= n/2 by the recursion of FAVAR (S. Maddipatla, H.
/// Haeri, K. Jerath, S. Brennan, "Fast Allan variance (FAVAR) and dynamic fast Allan variance (D-FAVAR)
/// algorithms for both regularly and irregularly sampled data", IFAC-PapersOnLine 54 (2021)):
///
///   sum_2m[k] = sum_m[k] + sum_m[k + m],  count_2m[k] = count_m[k] + count_m[k + m]
///
/// Every number is a sum over one cluster, so nothing long is ever summed and no mean is subtracted: the
/// plain path for masked or very unlike data, and a check of overlapped_variance, to which it is equal but
/// for rounding, gaps and their 95 % rule included. For samples at irregular times see irregular_variance.
///
/// Cost: O(n) per octave, one thread; 16 bytes a sample. Error: 1e-15 m times the mean square of the samples.
/// @throws std::invalid_argument for a dt that is not positive and finite, or a minimum fill outside (0, 1].
[[nodiscard]] Curve recursive_variance(std::span<const double> rate, double dt, double minimum_fill = kMinimumFill);

/// One averaging time of samples at irregular times.
struct IrregularPoint {
  std::int64_t m = 1;      ///< [cells]
  double tau = 0;          ///< m cells [s]
  double variance = 0;     ///< [signal^2]; NaN without terms
  std::int64_t terms = 0;  ///< pairs of clusters that both hold samples
  double white_ratio = 1;  ///< expectation for white samples over that of as many, evenly spread; at least 1
};

/// The same recursion for samples at irregular times, as they are: they are counted into cells of `cell` seconds, and a
/// cluster of m = 1, 2, 4, ... cells has the mean of the samples c it happens to hold. Pairs of neighbouring clusters
/// are weighted by how well they know their difference,
///
///   s(m) = sum_k w_k (Y[k+m] - Y[k])^2 / (2 sum_k w_k),  w_k = c_k c_{k+m} / (c_k + c_{k+m}),
///
/// the weights of least variance for white samples; one sample a cell gives recursive_variance. White samples of
/// variance q expect terms q / (2 sum w), which `white_ratio` compares to q / (mean c): divide by it where white noise
/// dominates. Signals slower than a cluster need no correction; in between, the mean times of the samples wander
/// within their cluster, which lowers or raises random walks by the order of the spread of c / m.
///
/// @param time [s], in any order.
/// @param cell [s]; about the mean step between samples, or more.
/// Samples that are not finite, or at such times, are left out.
/// @throws std::invalid_argument for unequal lengths, a cell that is not positive and finite, or more than 2^31 cells.
/// Cost: O(cells) per octave, 24 bytes a cell.
[[nodiscard]] std::vector<IrregularPoint> irregular_variance(std::span<const double> time, std::span<const double> rate,
                                                             double cell);

}  // namespace gyrobudget::inline v0::allan
