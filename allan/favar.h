// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"

#include <span>

namespace gyrobudget::inline v0::allan {

/// Fully overlapped Allan variance at m = 1, 2, 4, ... <= n/2 by the recursion of FAVAR (S. Maddipatla, H.
/// Haeri, K. Jerath, S. Brennan, "Fast Allan variance (FAVAR) and dynamic fast Allan variance (D-FAVAR)
/// algorithms for both regularly and irregularly sampled data", IFAC-PapersOnLine 54 (2021)):
///
///   sum_2m[k] = sum_m[k] + sum_m[k + m],  count_2m[k] = count_m[k] + count_m[k + m]
///
/// Every number is a sum over one cluster, so nothing long is ever summed and no mean is subtracted: the
/// plain path for masked or very unlike data, and a check of overlapped_variance, to which it is equal but
/// for rounding, gaps and their 95 % rule included. Irregular data: put samples on a grid with NaN where
/// there is none.
///
/// Cost: O(n) per octave, one thread; 16 bytes a sample. Error: 1e-15 m times the mean square of the samples.
/// @throws std::invalid_argument for a dt that is not positive and finite, or a minimum fill outside (0, 1].
[[nodiscard]] Curve recursive_variance(std::span<const double> rate, double dt,
                                       double minimum_fill = kMinimumFill);

}  // namespace gyrobudget::inline v0::allan
